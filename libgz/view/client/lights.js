// Lights: those of the world, the light of its sky, and one sun whose shadows follow the view.

import { Color, DirectionalLight, Group, HemisphereLight, Matrix4, PointLight, Quaternion, SpotLight, Vector3 } from "three";
import { bodiesOf, placed } from "libgz/bodies.js";
import { toned } from "libgz/materials.js";

/** @typedef {import("libgz/store.js").Store} Store */

const FULL = Math.PI; // intensity at which a white surface that faces the light is white
const WARM = new Color(1, 0.955, 0.885); // sunlight beside the light of the sky
const DEFAULT_SUN = new Vector3(0.45, 0.3, -0.85); // of worlds without lights
const ABOVE = new Vector3(0, 0, 1);
const FAR = 300; // [m] of the sun from what it shines on, at least
const MOST = 8; // lights beside the sun, each of which costs time in every pixel
const matrix = new Matrix4(), turn = new Quaternion(), place = new Vector3(), size = new Vector3();
const right = new Vector3(), up = new Vector3(), forward = new Vector3();

/** Shows all lights. */
export class Lights {
  /** @param {Store} store */
  constructor(store) {
    this.store = store;
    this.group = new Group();
    this.hemisphere = new HemisphereLight(0xffffff, 0x9c968d, 1);
    this.hemisphere.position.copy(ABOVE); // where the sky is; three's own is along y
    // A little light from the eye, so that sides away from the sun have a shape.
    this.eye = new DirectionalLight(0xffffff, 1);
    this.sun = new DirectionalLight(0xffffff, 1);
    // The light from straight above, whose blurred shadows darken what is close to the ground.
    this.above = new DirectionalLight(0xffffff, 1);
    this.above.shadow.radius = 7;
    this.sun.shadow.radius = 1.6;
    this.group.add(this.hemisphere, this.eye, this.eye.target, this.sun, this.sun.target, this.above, this.above.target);
    /** @type {{light: any, row: number, shape: any}[]} */
    this._others = [];
    /** @type {{row: number, shape: any} | null} what the sun is, of the scene */
    this._source = null;
    this._signature = "";
    this.towards = new Vector3(0, 0, 1); // the sun
    this.shadows = true; // whether the user wants them
    this.possible = true; // whether there is time for them
    this.casts = true; // whether the world has them
    this.soft = true;
  }

  /** Show the lights of the scene. @param {import("three").Color} sky @param {boolean} fine */
  build(sky, fine) {
    const { scene } = this.store;
    /** @type {{entity: any, row: number, shape: any}[]} */
    const found = [];
    let any = false; // a world whose lights are all out is dark
    for (const [entity, body] of bodiesOf(scene)) {
      for (const shape of body.shapes) {
        any ||= shape.kind === "light" && shape.visible;
        const shines = shape.kind === "light" && shape.visible && Math.max(...shape.material.diffuse.slice(0, 3)) > 0;
        if (shines && !(entity.number && this.store.isOn("hidden", entity.number))) found.push({ entity, row: body.row, shape });
      }
    }
    const ambient = scene.ambient.slice(0, 3).reduce((/** @type {number} */ sum, /** @type {number} */ part) => sum + part, 0) / 3;
    const signature = JSON.stringify([found.map(({ row, shape }) => [row, shape]), any, ambient, sky.getHex(), scene.shadows, fine]);
    if (signature === this._signature) return;
    this._signature = signature;
    for (const { light } of this._others) {
      light.removeFromParent();
      light.dispose();
    }
    this._others = [];
    const share = 1 / Math.max(1, Math.sqrt(found.length));
    const source =
      found.find(({ shape }) => shape.light === "directional") ??
      found.find(({ shape }) => shape.light === "point" && !fades(shape)) ?? null;
    this._source = source;
    this.sun.color.set(0xffffff);
    if (source) toned(source.shape.material.diffuse, this.sun.color);
    this.sun.color.multiply(WARM);
    // Without any light the world would be black; a world that has only lamps is lit by them.
    this.sun.intensity = source ? 1.35 * FULL * share : any ? 0 : FULL;
    this.sun.visible = this.sun.intensity > 0;
    this.casts = (source ? source.entity.cast_shadows !== false : true) && scene.shadows !== false;
    this.hemisphere.color.set(0xe9f1ff).lerp(sky, 0.3);
    const around = FULL * (0.6 + 0.4 * Math.min(Math.max(ambient, 0), 1)) * (any && !source ? 0.5 : 1);
    this.hemisphere.intensity = (fine ? 0.48 : 0.8) * around; // of fine materials, the sky's image does the rest
    this.eye.intensity = 0.28 * around;
    this.above.position.copy(ABOVE).multiplyScalar(FAR);
    this.above.color.copy(this.hemisphere.color);
    this.above.intensity = 0.42 * around;
    for (const one of found) {
      if (one === source || this._others.length === MOST) continue;
      const light = lightOf(one.shape, share);
      this._others.push({ light, row: one.row, shape: one.shape });
      this.group.add(light);
      if ("target" in light) this.group.add(light.target);
    }
    this.move();
  }

  /** Move lights to where they are in the present state. */
  move() {
    for (const { light, row, shape } of this._others) {
      this._place(row, shape);
      light.position.copy(place);
      if (light.target) light.target.position.copy(place).add(direct(shape));
    }
    if (!this._source) {
      this.towards.copy(DEFAULT_SUN).negate().normalize();
      return;
    }
    const { row, shape } = this._source;
    this._place(row, shape);
    if (shape.light === "directional") this.towards.copy(direct(shape)).negate().normalize();
    else this.towards.copy(place.length() > 0.5 ? place : DEFAULT_SUN).normalize(); // it shines to the middle of the world
    if (this.towards.z < 0.12) this.towards.setZ(0.12).normalize(); // shadows of a low sun have no end
  }

  /** @param {number} row @param {any} shape */
  _place(row, shape) {
    placed(shape.pose, 0, matrix);
    const pose = this.store.bodyPose(row);
    if (pose) matrix.premultiply(placed(pose, 0, new Matrix4()));
    matrix.decompose(place, turn, size);
  }

  /** @param {number} size of the shadow map; 0 for none @param {boolean} soft whether there are soft shadows below things */
  resize(size, soft) {
    this.possible = size > 0;
    this.soft = soft;
    for (const [{ shadow }, side] of /** @type {[DirectionalLight, number][]} */ ([[this.sun, size], [this.above, 512]])) {
      if (!size || shadow.mapSize.x === side) continue;
      shadow.mapSize.set(side, side);
      shadow.map?.dispose();
      shadow.map = null;
    }
  }

  /**
   * Let shadows cover what is in view; returns whether they have changed.
   * @param {Vector3} eye
   * @param {Vector3} middle of the view
   * @param {number} radius [m] around it
   */
  cover(eye, middle, radius) {
    this.eye.position.copy(eye);
    this.eye.target.position.copy(middle);
    this.eye.target.updateMatrixWorld();
    const casts = this.shadows && this.possible && this.casts;
    this.sun.castShadow = casts && this.sun.visible;
    this.above.castShadow = casts && this.soft;
    const one = aim(this.sun, this.towards, middle, radius, 1.2) && casts;
    const other = this.above.castShadow && aim(this.above, ABOVE, middle, radius, 2);
    return one || other;
  }
}

/**
 * Let a light shine around a point. Its map moves by whole texels, so that edges do not crawl.
 * @param {DirectionalLight} light
 * @param {Vector3} towards it
 * @param {Vector3} middle
 * @param {number} radius [m]
 * @param {number} bias along normals [texels]
 */
function aim(light, towards, middle, radius, bias) {
  const { shadow, target } = light, { camera } = shadow;
  const before = light.position.clone();
  forward.copy(towards);
  right.set(0, 0, 1).cross(forward);
  if (right.lengthSq() < 1e-3) right.set(1, 0, 0);
  right.normalize();
  up.crossVectors(forward, right);
  const side = 2 ** (Math.round(2 * Math.log2(radius)) / 2), texel = (2 * side) / shadow.mapSize.x;
  const x = Math.round(middle.dot(right) / texel) * texel, y = Math.round(middle.dot(up) / texel) * texel;
  const along = Math.round(middle.dot(forward) / 5) * 5, far = Math.max(FAR, 3 * side);
  target.position.copy(right).multiplyScalar(x).addScaledVector(up, y).addScaledVector(forward, along);
  light.position.copy(target.position).addScaledVector(forward, far);
  target.updateMatrixWorld();
  shadow.normalBias = bias * texel;
  shadow.bias = -texel / (2 * far); // one texel deep: more would part shadows from what stands on the ground
  if (camera.right !== side) {
    Object.assign(camera, { left: -side, right: side, top: side, bottom: -side, near: 1, far: 2 * far });
    camera.updateProjectionMatrix();
    return true;
  }
  return !before.equals(light.position);
}

/** @param {any} shape */
const fades = (shape) => (shape.attenuation[1] ?? 0) + (shape.attenuation[2] ?? 0) > 0.02;

/** @param {any} shape which way it shines, in the world. `turn` is its rotation. */
const direct = (shape) => new Vector3(shape.direction[0], shape.direction[1], shape.direction[2]).applyQuaternion(turn);

/** @param {any} shape @param {number} share */
function lightOf(shape, share) {
  const color = toned(shape.material.diffuse, new Color());
  const [constant, linear, quadratic] = shape.attenuation.map((/** @type {number | null} */ part) => part ?? 0);
  if (shape.light === "directional") return new DirectionalLight(color, 0.6 * FULL * share);
  const range = shape.range ?? 0;
  const strength = (FULL * share * (linear + quadratic > 0 ? 4 : 1)) / Math.max(constant, 0.25);
  const decay = linear + quadratic > 0 ? 0.8 : 0;
  if (shape.light !== "spot") return new PointLight(color, 0.8 * strength, range, decay);
  const [inner, outer] = shape.spot.map((/** @type {number | null} */ part) => part ?? 0);
  const half = Math.min(Math.max(outer / 2, 0.02), Math.PI / 2);
  return new SpotLight(color, strength, range, half, outer ? Math.min(Math.max(1 - inner / outer, 0), 1) : 0, decay);
}
