// @ts-check
/**
 * Series: values of the world by name, for plots and the inspector.
 * @module
 */

import { anglesOf } from 'libgz/format.js';

/**
 * What can be plotted. The key is a JSON list, because names in worlds may have any letters:
 * `["sim", "factor"]` (or rate, steps, pauseTime), `["entity", id, "x"]`, `["body", entity id, body name, "vx"]`, `["joint", entity id, joint, axis,
 * "rate"]`, `["field", key]` of an interface or topic.
 *
 * @typedef {object} Series
 * @property {string} key
 * @property {string} label
 * @property {string} unit
 */

export const DRAGGED = 'application/x-libgz-series';

export const POSES = ['x', 'y', 'z', 'roll', 'pitch', 'yaw'];
export const SPEEDS = ['vx', 'vy', 'vz', 'wx', 'wy', 'wz'];
const UNITS = ['m', 'm', 'm', 'rad', 'rad', 'rad', 'm/s', 'm/s', 'm/s', 'rad/s', 'rad/s', 'rad/s'];
const NAMES = [...POSES, ...SPEEDS];
const VELOCITY = 10; // its column in the table of bodies

/** @param {string} name of an entity's or body's value */
export const unitOf = (name) => UNITS[NAMES.indexOf(name)] ?? '';

/** @param {...(string | number)} parts */
export const keyOf = (...parts) => JSON.stringify(parts);

/** Reads series from the present state. */
export class Sampler {
  /** @param {import('libgz/store.js').Store} store */
  constructor(store) {
    this.store = store;
    /** @type {Map<string, (() => number)>} of the present scene */
    this.readers = new Map();
    store.addEventListener('scene', () => this.readers.clear());
  }

  /**
   * The present value; NaN if there is none.
   * @param {string} key
   */
  read(key) {
    if (!this.store.state) return NaN;
    let reader = this.readers.get(key);
    if (!reader) {
      reader = this.#reader(key);
      this.readers.set(key, reader);
    }
    return reader();
  }

  /** @param {string} key @returns {() => number} */
  #reader(key) {
    const { store } = this;
    const none = () => NaN;
    /** @type {unknown[]} */
    let parts;
    try {
      parts = JSON.parse(key);
    } catch {
      return none;
    }
    const [kind, name, ...rest] = Array.isArray(parts) ? parts : [];
    if (kind === 'sim') {
      if (name === 'factor') return () => store.realTimeFactor;
      if (name === 'rate') return () => store.stepRate;
      return name === 'steps' || name === 'pauseTime' ? () => store.state?.[name] ?? NaN : none;
    }
    if (kind === 'field') return () => store.series.get(String(name))?.value ?? NaN;
    const number = store.ids.get(String(name));
    const entity = number === undefined ? undefined : store.entities.get(number);
    if (number === undefined || !entity) return none;
    if (kind === 'entity') {
      const place = NAMES.indexOf(String(rest[0]));
      const row = store.bodies.get(entity.body)?.row ?? -1;
      return place < 0 ? none : place < 6 ? () => poseValue(store.entityPose(number), place) : this.#speed(row, place - 6);
    }
    if (kind === 'body') {
      const body = entity.bodies.find((one) => one.name === rest[0]);
      const place = NAMES.indexOf(String(rest[1]));
      if (!body || place < 0) return none;
      return place < 6 ? () => poseValue(store.bodyPose(body.row), place) : this.#speed(body.row, place - 6);
    }
    if (kind === 'joint') {
      const joint = entity.joints.find((one) => one.name === rest[0]);
      const column = (rest[1] === 1 ? 1 : 0) + (rest[2] === 'rate' ? 2 : 0);
      return joint && joint.row >= 0 ? () => store.state?.joints[4 * joint.row + column] ?? NaN : none;
    }
    return none;
  }

  /** @param {number} row @param {number} axis */
  #speed(row, axis) {
    const { store } = this;
    return row < 0 ? () => NaN : () => store.state?.bodies[BODY_COLUMNS * row + VELOCITY + axis] ?? NaN;
  }
}

const BODY_COLUMNS = 16;

/**
 * @param {ArrayLike<number> | null | undefined} pose x, y, z and a quaternion
 * @param {number} place
 */
function poseValue(pose, place) {
  if (!pose) return NaN;
  if (place < 3) return pose[place] ?? NaN;
  return anglesOf([pose[3] ?? 1, pose[4] ?? 0, pose[5] ?? 0, pose[6] ?? 0])[place - 3] ?? NaN;
}
