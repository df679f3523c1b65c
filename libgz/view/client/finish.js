// Finish: what the plain boxes and wheels of old robots look like with fine skins: edges that are round, tyres on rims.

import { BufferGeometry, ExtrudeGeometry, LatheGeometry, Path, Shape, Vector2 } from "three";
import { boxWithRoundEdges, once } from "libgz/forms.js";

/** @typedef {import("libgz/forms.js").Form} Form */

/**
 * A piece of a shape.
 * @typedef {object} Piece
 * @property {Form} form
 * @property {{color: number[], roughness: number, metalness: number}} paint instead of the shape's own
 */

const EDGE = 0.16, ROUNDEST = 0.02; // radius of an edge: of the shortest side, and at most [m]
const SOLIDS = new Set(["SimpleSolid", "GroundPlane", "MapExtruder", "Factory"]); // models that are no devices
const RUBBER = { color: [0.17, 0.17, 0.18], roughness: 0.92, metalness: 0 };
const METAL = { color: [0.74, 0.76, 0.79], roughness: 0.34, metalness: 0.85 };
const DARK = 0.35; // brightness below which a wheel's own colour is rubber
const SPOKES = 5;
const HAIR = 0.995; // of a cylinder's radius: else it would show through the sides of boxes that it touches
const DARKEST = 0.13, SOFT = 0.25; // of lacquer: its black, and how gray colours are

/** Whether an entity is a device of old, which may have a fine skin. @param {any} scene @param {any} entity */
export const isDevice = (scene, entity) =>
  scene.era !== "classic" && entity.kind === "model" && !entity.static && !SOLIDS.has(entity.type);

/**
 * The pieces that stand for a shape; null for one that stays as it is.
 * @param {any} shape of the scene
 * @returns {Piece[] | null}
 */
export function piecesOf(shape) {
  if (shape.texture || shape.skin || shape.material.opacity < 1) return null;
  const paint = { color: lacquer(shape.material.diffuse), roughness: 0.5, metalness: 0 };
  if (shape.kind === "box") return [{ form: roundBox(shape.size), paint }];
  if (shape.kind === "cylinder") return [{ form: roundCylinder(shape.radius, shape.length), paint }];
  if (shape.kind !== "wheel") return null;
  const dark = Math.max(...shape.material.diffuse.slice(0, 3)) < DARK;
  const { radius, tire_radius: tire } = shape;
  return [{ form: tyre(radius, tire), paint: dark ? RUBBER : paint }, { form: rim(radius, tire), paint: METAL }];
}

/** A colour as lacquer has it: no pure black, and none of a screen's pure colours. @param {number[]} color */
function lacquer([red, green, blue]) {
  const gray = 0.3 * red + 0.59 * green + 0.11 * blue;
  return [red, green, blue].map((part) => DARKEST + (1 - DARKEST) * (part + SOFT * (gray - part)));
}

/** @param {number[]} size [m] */
function roundBox(size) {
  const edge = Math.min(EDGE * Math.min(...size), ROUNDEST);
  return made(`round box ${size}`, () => boxWithRoundEdges(size, edge));
}

/** @param {number} nominal radius @param {number} length [m] */
function roundCylinder(nominal, length) {
  const radius = HAIR * nominal;
  const edge = Math.min(EDGE * Math.min(radius, length), ROUNDEST), half = length / 2;
  const side = [new Vector2(0, -half)];
  for (const [x, y, begin] of [[radius - edge, edge - half, -Math.PI / 2], [radius - edge, half - edge, 0]]) {
    for (let i = 0; i <= 4; i++) {
      const angle = begin + (i * Math.PI) / 8;
      side.push(new Vector2(x + edge * Math.cos(angle), y + edge * Math.sin(angle)));
    }
  }
  side.push(new Vector2(0, half));
  return made(`round cylinder ${radius} ${length}`, () => new LatheGeometry(side, 40).rotateX(Math.PI / 2));
}

/** A tyre with a flat tread and grooves along it. @param {number} radius @param {number} tire radius of its tube [m] */
function tyre(radius, tire) {
  const inner = Math.max(radius - 1.55 * tire, 0.35 * radius), half = 0.95 * tire, groove = 0.05 * tire;
  const points = [[inner, -0.82], [radius - 0.5 * tire, -1], [radius - 0.16 * tire, -0.86], [radius, -0.6]];
  for (const at of [-0.32, 0.0, 0.32]) {
    points.push([radius, at - 0.07], [radius - groove, at - 0.04], [radius - groove, at + 0.04], [radius, at + 0.07]);
  }
  points.push([radius, 0.6], [radius - 0.16 * tire, 0.86], [radius - 0.5 * tire, 1], [inner, 0.82], [inner, -0.82]);
  const side = points.map(([x, y]) => new Vector2(x, y * half));
  return made(`tyre ${radius} ${tire}`, () => new LatheGeometry(side, 48).rotateX(Math.PI / 2));
}

/** A rim with spokes. @param {number} radius @param {number} tire [m] */
function rim(radius, tire) {
  const outer = Math.max(radius - 1.55 * tire, 0.35 * radius) * 1.01, depth = 1.1 * tire;
  return made(`rim ${radius} ${tire}`, () => {
    const disc = new Shape().absarc(0, 0, outer, 0, 2 * Math.PI, false);
    for (let i = 0; i < SPOKES; i++) {
      const middle = (2 * Math.PI * i) / SPOKES, half = 0.62 * (Math.PI / SPOKES);
      const hole = new Path();
      hole.absarc(0, 0, 0.8 * outer, middle - half, middle + half, false);
      hole.absarc(0, 0, 0.36 * outer, middle + 0.7 * half, middle - 0.7 * half, true);
      disc.holes.push(hole);
    }
    const bevel = 0.04 * outer;
    return new ExtrudeGeometry(disc, {
      depth: depth - 2 * bevel, bevelEnabled: true, bevelSize: -bevel, bevelOffset: 0, bevelThickness: bevel, bevelSegments: 2, curveSegments: 12,
    }).translate(0, 0, bevel - depth / 2);
  });
}

/** @param {string} key @param {() => BufferGeometry} build @returns {Form} */
const made = (key, build) => ({ key, geometry: once(key, build), scale: [1, 1, 1] });
