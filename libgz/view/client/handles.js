// Handles: arrows and rings that move what is selected. What they hold is held: it does not fall until it is released.

import { Group, MathUtils, Object3D } from "three";
import { TransformControls } from "three/addons/controls/TransformControls.js";

/** @typedef {import("libgz/cameras.js").Cameras} Cameras */
/** @typedef {import("libgz/store.js").Store} Store */

const PERIOD = 50; // [ms] between two poses that are sent
const AGAIN = 500; // [ms] after which a pose is sent again
const STEP = 0.1; // [m] of snapping
const TURN = MathUtils.degToRad(15);

/** Moves the selected entity. */
export class Handles {
  /**
   * @param {Cameras} cameras
   * @param {HTMLElement} element
   * @param {Store} store
   * @param {() => void} changed
   */
  constructor(cameras, element, store, changed) {
    this.cameras = cameras;
    this.store = store;
    this.changed = changed;
    this.group = new Group();
    this.grip = new Object3D();
    this.controls = new TransformControls(cameras.camera, element);
    this.controls.size = 0.85;
    this.group.add(this.grip, this.controls.getHelper());
    /** @type {number | null} entity that the handles are at */
    this._entity = null;
    /** @type {string | null} name of the entity that is held */
    this._held = null;
    this._sent = 0;
    this._timer = 0;
    this._asking = false;
    this.controls.addEventListener("change", changed);
    this.controls.addEventListener("objectChange", () => this._send());
    this.controls.addEventListener("dragging-changed", ({ value }) => {
      cameras.controls.enabled = !value;
      if (value) this._hold();
      else this._release();
    });
  }

  /** Whether the pointer is on a handle. */
  get busy() {
    return this.controls.dragging || (this._entity !== null && this.controls.axis !== null);
  }

  /** Take up the selection and the kind of handles. */
  choose() {
    const { store } = this, { selection } = store;
    const { mode, space, snap } = store.handles ?? { mode: "none", space: "world", snap: false };
    const entity = selection ? store.entities.get(selection.entity) : null;
    const movable = entity && store.control && mode !== "none" && store.abilities.has("move") && !store.isOn("locked", entity.number);
    if (!movable) {
      if (this.controls.dragging) this._release();
      this._entity = null;
      this.controls.detach();
      this.changed();
      return;
    }
    this._entity = entity.number;
    this.controls.setMode(mode);
    this.controls.setSpace(space);
    this.controls.setTranslationSnap(snap ? STEP : null);
    this.controls.setRotationSnap(snap ? TURN : null);
    if (this.controls.object !== this.grip) this.controls.attach(this.grip);
    this.follow();
    this.changed();
  }

  /** Be where the entity is. */
  follow() {
    if (this._entity === null || this.controls.dragging) return;
    const pose = this.store.entityPose(this._entity);
    if (!pose) return;
    this.grip.position.set(pose[0], pose[1], pose[2]);
    this.grip.quaternion.set(pose[4], pose[5], pose[6], pose[3]);
  }

  _hold() {
    this._held = this.store.entities.get(this._entity ?? 0)?.id ?? null;
    this._send();
  }

  /** Send where the entity is held, at most every 50 ms, and not before the former pose was answered. */
  _send() {
    if (this._held === null) return;
    clearTimeout(this._timer);
    const wait = this._sent + PERIOD - performance.now();
    if (wait > 0 || this._asking) {
      this._timer = window.setTimeout(() => this._send(), Math.max(wait, 5));
      return;
    }
    this._sent = performance.now();
    this._asking = true;
    this._ask().finally(() => {
      this._asking = false;
      // What is held without being moved would be released.
      if (this._held !== null && this._holds) this._timer = window.setTimeout(() => this._send(), AGAIN);
    });
  }

  get _holds() {
    return this.store.abilities.has("hold");
  }

  async _ask() {
    const { position: p, quaternion: q } = this.grip, pose = [p.x, p.y, p.z, q.w, q.x, q.y, q.z];
    try {
      await this.store.ask(this._holds ? "hold" : "move", this._holds ? "on" : "-", { name: this._held, pose });
    } catch (problem) {
      this.store.problem(problem instanceof Error ? problem.message : String(problem));
    }
  }

  async _release() {
    const name = this._held;
    if (name === null) return;
    clearTimeout(this._timer);
    await this._ask();
    this._held = null;
    if (this._holds) await this.store.ask("hold", "off", { name }).catch(() => undefined);
  }
}
