// Cameras: where the scene is seen from: the start, views along axes, what is framed, followed and focused.

import { Box3, MathUtils, PerspectiveCamera, Quaternion, Sphere, Vector3 } from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";

/** @typedef {import("libgz/bodies.js").Bodies} Bodies */
/** @typedef {import("libgz/store.js").Store} Store */

const LOWEST = 0.08; // [m] of the camera above the ground, unless it is nearer to what it looks at
const LEAST = 0.005; // [m] radius of what is framed
const MARGIN = 1.5; // around robots at the start
const FLAT = 1.15; // around what is wide and low: the ball around it is higher than it
const CLOSE = 1.2; // around what is focused
const ASPECT = 4 / 3; // of the windows that views of worlds were chosen in
const LIFT = 0.07; // of the view's height that they are above its middle, as the stick is below
const FARTHEST = 1e6; // [m] from the origin of what is framed
const DEEP = -100; // [m] what is below has fallen off the world
const GLIDE = 350; // [ms] of a change of view
const OBLIQUE = new Vector3(-1, -1.25, 0.85).normalize(); // from what is framed to the eye
const RISE = Math.atan(0.3); // elevation at the start [rad], with the horizon in view
const SIDES = [110, 130, 150, 210, 230, 250].map(MathUtils.degToRad); // azimuths at the start: obliquely from behind
/** From what is looked at to the eye. @type {Record<string, Vector3>} */
const VIEWS = {
  front: new Vector3(1, 0, 0.001),
  back: new Vector3(-1, 0, 0.001),
  left: new Vector3(0, 1, 0.001),
  right: new Vector3(0, -1, 0.001),
  top: new Vector3(-0.001, 0, 1),
  iso: OBLIQUE,
};

/** Moves the camera. */
export class Cameras {
  /**
   * @param {HTMLElement} element that the pointer drags on
   * @param {Store} store
   * @param {Bodies} bodies
   * @param {() => void} changed
   */
  constructor(element, store, bodies, changed) {
    this.store = store;
    this.bodies = bodies;
    this.changed = changed;
    this.camera = new PerspectiveCamera(45, 1, 0.02, 5000);
    this.camera.up.set(0, 0, 1);
    this.camera.position.set(-4, -5, 3.4);
    this.controls = new OrbitControls(this.camera, element);
    this.controls.zoomToCursor = true;
    this.controls.minDistance = 0.01;
    this.controls.maxDistance = 3000;
    this.controls.screenSpacePanning = true;
    this.controls.zoomSpeed = 1.3;
    this.controls.addEventListener("change", () => this.changed());
    this.controls.addEventListener("start", () => {
      this._glide = null;
      this.touched = true;
    });
    this.touched = false; // by the user
    /** @type {{from: Vector3, to: Vector3, eye: Vector3, goal: Vector3, begin: number} | null} */
    this._glide = null;
    this._followed = new Vector3();
    /** @type {number | null} */
    this._follows = null;
    this._walk = [0, 0, 0]; // forward, left, up: -1 to 1
    this._walked = 0; // [ms]
    /** @type {(x: number, y: number) => number} height of the ground [m], -Infinity for none */
    this.groundAt = () => -Infinity;
  }

  /** Distance between the eye and what it looks at [m]. */
  get distance() {
    return this.camera.position.distanceTo(this.controls.target);
  }

  /**
   * Begin where the world says, else where the robots fill the frame, lit and with their shadow in sight.
   * @param {Vector3} sun towards it
   * @param {(eye: Vector3, place: Vector3, radius: number) => boolean} sees whether nothing is before a place
   */
  begin(sun, sees) {
    const { scene } = this.store, { view } = scene;
    this.touched = false;
    if (view) {
      const ahead = new Vector3(1, 0, 0).applyQuaternion(new Quaternion(view[4], view[5], view[6], view[3]));
      this.camera.position.set(view[0], view[1], view[2]);
      const box = this.bodies.bounds(this._movers());
      const middle = box.isEmpty() ? 0 : box.getCenter(new Vector3()).sub(this.camera.position).dot(ahead);
      const down = ahead.z < -0.02 ? -this.camera.position.z / ahead.z : Infinity;
      const reach = Math.min(middle > 0.2 ? middle : down > 0 && down < 200 ? down : 5, 1000);
      this.controls.target.copy(this.camera.position).addScaledVector(ahead, Math.max(reach, 0.2));
      this._stepBack(sees);
      this.controls.update();
      this.changed();
      return;
    }
    const box = this._interesting(), { center, radius } = box.getBoundingSphere(new Sphere());
    const { x, y, z } = box.getSize(new Vector3()), margin = z < 0.5 * Math.max(x, y) ? FLAT : MARGIN;
    const sides = startsFor(sun);
    const free = sides.find((outward) => sees(this._eye(center, radius, outward, margin), center, radius));
    this._frame(box, free ?? sides[0], false, margin);
    this.controls.target.z -= LIFT * 2 * Math.tan(MathUtils.degToRad(this.camera.fov) / 2) * this.distance;
    this.controls.update();
  }

  /**
   * Move back in a narrow window, until it shows as much as the world's view did in a wide one, or something is behind.
   * @param {(eye: Vector3, place: Vector3, radius: number) => boolean} sees
   */
  _stepBack(sees) {
    const { position } = this.camera, { target } = this.controls;
    for (const share of [1, 0.5]) {
      const factor = 1 + share * Math.max(ASPECT / this.camera.aspect - 1, 0);
      const eye = position.clone().sub(target).multiplyScalar(factor).add(target);
      if (factor === 1 || !sees(position, eye, 0)) continue;
      position.copy(eye);
      return;
    }
  }

  /** The box of what a user wants to see first: robots, else what moves, else everything. */
  _interesting() {
    const { entities } = this.store.scene;
    const robots = new Set(this.store.robots.map(({ entity }) => entity));
    const driven = entities.filter((/** @type {any} */ entity) =>
      robots.has(entity.id) || entity.interfaces.some((/** @type {any} */ one) => one.type === "position"));
    const groups = [driven.map((/** @type {any} */ entity) => entity.number), this._movers(), [...this.bodies.of.keys()]];
    for (const numbers of groups) {
      const box = this.bodies.bounds(numbers.flatMap((/** @type {number} */ number) => this.bodies.family(number)));
      // Many robots, or ones far apart, would be dots: the first one is better.
      if (!box.isEmpty() && box.getSize(new Vector3()).length() > 25 && numbers === groups[0]) {
        return this.bodies.bounds(this.bodies.family(numbers[0]));
      }
      if (!box.isEmpty()) return box;
    }
    return new Box3(new Vector3(-1.5, -1.5, 0), new Vector3(1.5, 1.5, 1));
  }

  /** Whether the scene has models that are not fixed. */
  get hasMovers() {
    return this._movers().length > 0;
  }

  /** The models that are not fixed, without those that have fallen off the world, unless all have. */
  _movers() {
    const all = this.store.scene.entities
      .filter((/** @type {any} */ entity) => !entity.static && entity.kind !== "light")
      .map((/** @type {any} */ entity) => entity.number);
    const here = all.filter((/** @type {number} */ number) => {
      const box = this.bodies.bounds([number]);
      return box.isEmpty() || box.max.z > DEEP;
    });
    return here.length ? here : all;
  }

  /**
   * A command: fit, focus on an entity, or a view along an axis.
   * @param {any} view
   */
  show(view) {
    if (view?.walk) {
      this._walk = view.walk;
      this._walked = performance.now();
      this.changed();
    } else if (typeof view === "object" && view !== null) {
      this.focus(view.focus);
    } else if (view === "fit") {
      const { selection } = this.store;
      if (selection) this.focus(selection.entity);
      else this._frame(this.bodies.bounds(this._everything()), this._outward(), true);
    } else if (view in VIEWS) {
      const { selection } = this.store;
      const numbers = selection ? this.bodies.family(selection.entity) : this._everything();
      this._frame(this.bodies.bounds(numbers), VIEWS[view], true);
    }
  }

  /** What moves; everything where nothing does. */
  _everything() {
    const movers = this._movers();
    return this.bodies.bounds(movers).isEmpty() ? [...this.bodies.of.keys()] : movers;
  }

  /** @param {number} number */
  focus(number) {
    this._frame(this.bodies.bounds(this.bodies.family(number)), this._outward(), true, CLOSE);
  }

  /** From what is looked at to the eye. */
  _outward() {
    return this.camera.position.clone().sub(this.controls.target);
  }

  /**
   * Frame a box, seen from a direction.
   * @param {Box3} box
   * @param {Vector3} outward
   * @param {boolean} glide
   * @param {number} margin around it, 1 for none
   */
  _frame(box, outward, glide, margin = 1) {
    if (box.isEmpty() || ![...box.min.toArray(), ...box.max.toArray()].every((part) => Math.abs(part) < FARTHEST)) return;
    const { center, radius } = box.getBoundingSphere(new Sphere());
    const eye = this._eye(center, radius, outward, margin);
    if (glide) {
      this._glide = {
        from: this.controls.target.clone(), to: center, eye: this.camera.position.clone(), goal: eye, begin: performance.now(),
      };
    } else {
      this.controls.target.copy(center);
      this.camera.position.copy(eye);
      this.controls.update();
    }
    this.changed();
  }

  /**
   * From where a ball fills the frame.
   * @param {Vector3} center
   * @param {number} radius [m]
   * @param {Vector3} outward
   * @param {number} margin around it, 1 for none
   */
  _eye(center, radius, outward, margin) {
    const half = MathUtils.degToRad(this.camera.fov) / 2;
    const narrow = Math.atan(Math.tan(half) * Math.min(this.camera.aspect, 1));
    const reach = (0.92 * margin * Math.max(radius, LEAST)) / Math.sin(narrow);
    return center.clone().addScaledVector(outward.clone().normalize(), reach);
  }

  /** Bring the camera up to date before a frame; returns whether it is still moving. @param {number} now [ms] */
  update(now) {
    const { camera, controls } = this;
    this._follow();
    if (this._glide) {
      const { from, to, eye, goal, begin } = this._glide;
      const share = Math.min((now - begin) / GLIDE, 1), eased = share * share * (3 - 2 * share);
      controls.target.lerpVectors(from, to, eased);
      camera.position.lerpVectors(eye, goal, eased);
      if (share === 1) this._glide = null;
    }
    this._step(now);
    controls.update();
    const lowest = this.groundAt(camera.position.x, camera.position.y) + Math.min(LOWEST, 0.2 * this.distance);
    if (camera.position.z < lowest) {
      camera.position.z = lowest;
      camera.lookAt(controls.target);
    }
    const near = MathUtils.clamp(this.distance / 60, 0.001, 2);
    const far = Math.max(3000, 20 * this.distance);
    if (Math.abs(near / camera.near - 1) > 0.2 || far !== camera.far) {
      camera.near = near;
      camera.far = far;
      camera.updateProjectionMatrix();
    }
    camera.updateMatrixWorld();
    return this._glide !== null || this._walk.some((part) => part !== 0);
  }

  /** Walk on, as fast as the view is wide. @param {number} now [ms] */
  _step(now) {
    const time = Math.min(Math.max(now - this._walked, 0), 100) / 1000, [ahead, left, up] = this._walk;
    this._walked = now;
    if (!ahead && !left && !up) return;
    const forward = this.camera.getWorldDirection(new Vector3()).setZ(0);
    if (forward.lengthSq() < 1e-6) forward.set(0, 1, 0).applyQuaternion(this.camera.quaternion).setZ(0);
    forward.normalize();
    const step = forward.clone().multiplyScalar(ahead).addScaledVector(new Vector3(-forward.y, forward.x, 0), left);
    step.z = up;
    step.multiplyScalar(time * Math.max(this.distance, 1));
    this.camera.position.add(step);
    this.controls.target.add(step);
  }

  /** Keep the place of the eye beside what is followed. */
  _follow() {
    const number = this.store.follow ?? null;
    const pose = number === null ? null : this.store.entityPose(number);
    if (!pose) {
      this._follows = null;
      return;
    }
    const here = new Vector3(pose[0], pose[1], pose[2]);
    if (this._follows === number) {
      const step = here.clone().sub(this._followed);
      this.controls.target.add(step);
      this.camera.position.add(step);
      for (const point of this._glide ? [this._glide.to, this._glide.goal, this._glide.from, this._glide.eye] : []) point.add(step);
    }
    this._follows = number;
    this._followed.copy(here);
  }

  /** @param {number} width @param {number} height [px] */
  resize(width, height) {
    this.camera.aspect = width / Math.max(height, 1);
    this.camera.updateProjectionMatrix();
  }
}

/**
 * From where robots are seen at the start, the best first: the sides that are seen are bright, and the shadow falls aside.
 * @param {Vector3} sun towards it
 */
function startsFor(sun) {
  const light = sun.clone().setZ(0).normalize();
  const found = SIDES.map((azimuth) => {
    const outward = new Vector3(Math.cos(azimuth), Math.sin(azimuth), Math.tan(RISE)).normalize();
    const bright = Math.max(outward.x * light.x, 0) + Math.max(outward.y * light.y, 0);
    const aside = Math.abs(outward.x * light.y - outward.y * light.x);
    return { outward, worth: bright * (0.3 + aside) };
  });
  return found.sort((one, other) => other.worth - one.worth).map(({ outward }) => outward);
}
