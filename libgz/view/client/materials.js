// Materials: the looks of shapes. Shapes of one look share one material; their colours are those of their instances.

import { Color, DoubleSide, FrontSide, MeshLambertMaterial, MeshStandardMaterial, SRGBColorSpace } from "three";
import { ownTexture } from "libgz/assets.js";

/** @typedef {import("libgz/assets.js").Assets} Assets */
/** @typedef {import("three").Texture} Texture */

/**
 * @typedef {object} Look
 * @property {string} key distinguishes it from others
 * @property {Color} color of the instance
 * @property {number} opacity
 * @property {() => import("three").Material} make
 */

/**
 * How all or some shapes are shown, instead of by their own looks.
 * @typedef {object} Showing
 * @property {boolean} fine physically based shading, which costs more than a plain one
 * @property {boolean} wireframe
 * @property {boolean} collisions
 * @property {boolean} transparent
 * @property {boolean} [skins] whether old devices have fine skins
 */

const COLLISION = new Color(0xff8c1a); // of shapes that collide
export const SEEN_THROUGH = 0.45; // opacity of models that are switched to transparent

const LEAST = 0.012, MOST = 0.86; // of the light that a surface reflects: nothing is quite black or white
const GLOSS = 0.035; // what a plain material lacks: the mirrored light that tone mapping expects
const gray = new Color();

/**
 * The colour of a surface, of a colour in a world file: a little softer than pure ones.
 * @param {number[]} rgb
 * @param {boolean} fine
 */
function paint(rgb, fine) {
  const color = toned(rgb), tone = 0.3 * color.r + 0.59 * color.g + 0.11 * color.b;
  const least = fine ? LEAST : LEAST + GLOSS;
  return color.lerp(gray.setRGB(tone, tone, tone), 0.05).multiplyScalar(MOST - least).addScalar(least);
}

/** A colour of a world file, which has the tones of a screen. @param {number[]} rgb @param {Color} into */
export function toned(rgb, into = new Color()) {
  const [red, green, blue] = rgb.map((part) => Math.min(Math.max(part, 0), 1));
  return into.setRGB(red, green, blue, SRGBColorSpace);
}

/**
 * The look of a shape of the scene.
 * @param {any} shape
 * @param {Assets} assets
 * @param {Showing} showing
 * @param {{both?: boolean, geometry: import("three").BufferGeometry}} form
 * @returns {Look}
 */
export function lookOf(shape, assets, showing, form) {
  const { material } = shape;
  if (showing.collisions) {
    return {
      key: `collision ${form.both}`,
      color: COLLISION,
      opacity: 0.5,
      make: () => new MeshLambertMaterial({ transparent: true, opacity: 0.5, depthWrite: false, side: sideOf(form), wireframe: showing.wireframe }),
    };
  }
  const image = shape.texture ? assets.texture(shape.texture.file) : null;
  const arrays = !shape.texture && shape.kind === "mesh" ? assets.arrays(shape.data) : null;
  const map = image ?? (arrays ? ownTexture(arrays) : null);
  const colored = !map && form.geometry.hasAttribute("color");
  const opacity = material.opacity * (showing.transparent ? SEEN_THROUGH : 1);
  // Images and colours of vertices are tinted only by colours that are darker than the default one.
  const color = map || colored
    ? toned(material.diffuse.map((/** @type {number} */ part) => 1.25 * part))
    : paint(material.diffuse, showing.fine);
  const emission = material.emission.slice(0, 3);
  const matrix = shape.texture?.matrix ?? [1, 0, 0, 0, 1, 0];
  const rejection = shape.texture?.alpha_rejection ?? 0;
  const highlight = Math.max(...material.specular.slice(0, 3));
  const pbr = shape.pbr ?? null;
  const roughness = pbr?.roughness ?? roughnessOf(highlight, material.shininess);
  const metalness = pbr?.metalness ?? 0;
  const maps = pbr ? Object.fromEntries(
    ["normal", "metalness", "roughness", "emissive"].map((name) => [name, pbr[`${name}_map`] ? assets.texture(pbr[`${name}_map`]) : null]),
  ) : {};
  const key = [
    showing.fine, showing.wireframe, map?.uuid ?? "", map ? matrix : "", rejection, opacity, emission, roughness.toFixed(1), metalness,
    form.both, colored, Object.values(maps).map((found) => found?.uuid ?? ""), shape.cast_shadows,
  ].join(" ");
  const make = () => {
    const turned = map && String(matrix) !== "1,0,0,0,1,0" ? transformed(map, matrix) : map;
    const common = {
      map: turned,
      vertexColors: colored,
      transparent: opacity < 1,
      opacity,
      alphaTest: map ? rejection : 0,
      depthWrite: opacity === 1,
      side: sideOf(form),
      shadowSide: sideOf(form), // boxes that touch would darken each other's edges by their back sides
      wireframe: showing.wireframe,
      emissive: toned(emission),
      emissiveMap: maps.emissive ?? null,
    };
    if (!showing.fine) return new MeshLambertMaterial(common);
    return new MeshStandardMaterial({
      ...common,
      roughness,
      metalness,
      normalMap: linear(maps.normal),
      metalnessMap: linear(maps.metalness),
      roughnessMap: linear(maps.roughness),
    });
  };
  return { key, color, opacity, make };
}

/** @param {{both?: boolean}} form */
const sideOf = (form) => (form.both ? DoubleSide : FrontSide);

/** @param {number} highlight brightest part of the specular colour @param {number} shininess 0 to 128 */
function roughnessOf(highlight, shininess) {
  if (highlight < 0.02) return 0.95;
  return Math.min(Math.max(Math.sqrt(2 / (shininess + 2)), 0.3), 0.75);
}

/** @param {Texture | null | undefined} texture whose values are no colours */
function linear(texture) {
  if (texture) texture.colorSpace = "";
  return texture ?? null;
}

/** @param {Texture} map @param {number[]} matrix u' = a u + b v + c, v' = d u + e v + f */
function transformed(map, matrix) {
  const turned = map.clone();
  turned.matrixAutoUpdate = false;
  turned.matrix.set(matrix[0], matrix[1], matrix[2], matrix[3], matrix[4], matrix[5], 0, 0, 1);
  turned.needsUpdate = true;
  return turned;
}
