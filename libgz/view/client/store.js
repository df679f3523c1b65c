// @ts-check
// Store: all that the page knows. Its events carry no data: readers read the store.

/**
 * @typedef {{id: number, name: string, kind: string, pose: number[], collides: boolean, visible: boolean,
 *   [key: string]: any}} Shape
 * @typedef {{id: number, name: string, row: number, static: boolean, shapes: Shape[], mass?: number,
 *   inertia?: number[]}} Body
 * @typedef {{name: string, kind: string, row: number, bodies: [number, number], frame: number, anchor: number[],
 *   axes: number[][], limits?: ([number | null, number | null] | null)[]}} Joint
 * @typedef {{kind: string, body: number, name?: string, [key: string]: any}} Sensor
 * @typedef {{number: number, id: string, kind: string, type: string, parent: number, parent_body: number,
 *   body: number, pose: number[], static: boolean, interfaces: {type: string, id: string}[], bodies: Body[],
 *   joints: Joint[], sensors: Sensor[], [key: string]: any}} Entity
 * @typedef {{world: string, era: string, revision: number, gravity: number[], entities: Entity[], others: Body[],
 *   assets: Record<string, string>, [key: string]: any}} Scene
 * @typedef {{steps: number, simTime: number, pauseTime: number, realTime: number, paused: boolean, revision: number,
 *   bodyColumns: number, jointColumns: number, bodies: Float32Array, joints: Float32Array}} State
 * @typedef {{kind: 'body' | 'joint' | 'sensor' | 'light', name: string}} Part
 * @typedef {{entity: number, part?: Part}} Selection
 * @typedef {{number: number, level: 'error' | 'warning' | 'info', text: string, file?: string, line?: number,
 *   source?: string, time?: number}} Message
 * @typedef {{x: number[], lines: Record<string, number[]>}} Plot
 * @typedef {{name: string, text: string, buttons: string[], images: Record<string, string>,
 *   plots: Record<string, Plot>}} Overlay
 * @typedef {{position: number[], normal: number[], depth: number, force?: number[], entities?: number[]}} Contact
 * @typedef {{mode: 'none' | 'translate' | 'rotate', space: 'world' | 'local', snap: boolean}} Handles
 * @typedef {'fit' | 'front' | 'back' | 'left' | 'right' | 'top' | 'iso' | {focus: number} | {walk: number[]}} View
 * @typedef {{send: (message: object) => void, ask: (verb: string, argument: string, content: object) => Promise<any>}} Link
 */

const MOST_MESSAGES = 1000;
const SPAN = 2; // [s] over which the real-time factor is measured
const ROW = { bodies: 16, joints: 4 };

/** The one model of what is known. */
export class Store extends EventTarget {
  constructor() {
    super();
    /** @type {Link | null} */
    this.link = null;
    this.title = 'libgz';
    this.connected = false;
    this.control = false;
    /** Why this page only watches. @type {string | undefined} */
    this.watchReason = undefined;
    /** Who else may control, and whether this page can ask for it. */
    this.controllers = { here: false, other: false, canAsk: false };
    /** Who asks for control. */
    this.asked = '';
    /** @type {Set<string>} */
    this.abilities = new Set();
    /** @type {{text: string, level: '' | 'waiting' | 'lost' | 'ended'}} */
    this.status = { text: 'Connecting …', level: 'waiting' };
    /** @type {{begin: number, end: number, time: number, speed?: number} | null} */
    this.log = null;

    /** @type {Scene} */
    this.scene = /** @type {any} */ (null);
    /** @type {State} */
    this.state = /** @type {any} */ (null);
    /** @type {Map<number, Entity>} */
    this.entities = new Map();
    /** @type {Map<string, number>} */
    this.ids = new Map();
    /** @type {Map<number, {body: Body, entity: number, row: number}>} */
    this.bodies = new Map();
    /** Addresses of assets that the page has in itself. @type {Record<string, string> | null} */
    this.assetsHere = null;
    this.realTimeFactor = 0;
    this.stepRate = 0;
    /** @type {{at: number, sim: number, steps: number}[]} */
    this.history = [];

    /** @type {Selection | null} */
    this.selection = null;
    /** @type {number | null} */
    this.hover = null;
    /** @type {number | null} */
    this.follow = null;
    /** @type {Handles} */
    this.handles = { mode: 'none', space: 'world', snap: false };
    /** @type {'dark' | 'light'} */
    this.theme = 'dark';
    /** @type {View} */
    this.viewed = 'fit';
    /** @type {Set<string>} */
    this.switches = new Set(['grid', 'shadows', 'skins']);

    /** @type {{label: string, entity: string, kind: string}[]} */
    this.robots = [];
    this.robot = '';
    this.speeds = { linear: 0.4, angular: 0.8 };

    /** @type {Map<string, Map<string, string[]>>} what each part of the page wants of a channel */
    this.wants = new Map();
    /** @type {Map<string, string>} */
    this.images = new Map();
    /** @type {Map<string, Float32Array>} */
    this.ranges = new Map();
    /** @type {Map<string, {positions: number[][], directions: number[], ranges: number[]}>} */
    this.rings = new Map();
    /** @type {Contact[]} */
    this.contacts = [];
    /** @type {Map<string, {time: number, value: number}>} */
    this.series = new Map();
    /** @type {Message[]} */
    this.messages = [];
    /** @type {Overlay[]} */
    this.overlays = [];
  }

  /** @param {string} name */
  #emit(name) {
    this.dispatchEvent(new Event(name));
  }

  // What arrives -----------------------------------------------------------------------------------------------------

  /** @param {Link} link */
  connect(link) {
    this.link = link;
  }

  /** The connection was lost. @param {string} text for users */
  lose(text) {
    this.connected = this.control = false;
    this.controllers = { here: false, other: false, canAsk: false };
    this.asked = '';
    this.status = { text, level: 'lost' };
    this.#emit('status');
    this.#emit('hello');
  }

  /**
   * Take in a message in JSON.
   * @param {Record<string, any>} message
   */
  learn(message) {
    const { hello, control, status, robots, contacts, ranges, rings, series, messages, overlays, problem } = message;
    if (control) {
      this.controllers = { here: control.here, other: control.other, canAsk: control.canAsk };
      this.control = control.here;
      this.asked = control.asked ?? '';
    }
    if (hello) {
      this.title = hello.title;
      this.abilities = new Set(hello.abilities);
      this.watchReason = hello.reason ?? undefined;
      if (!this.connected) {
        this.connected = true;
        if (hello.skins === 'plain') this.setSwitch('skins', false);
        this.messages = [];
        for (const channel of this.wants.keys()) this.#sendWants(channel);
      }
    }
    if (hello || (control && this.connected)) {
      this.#emit('hello');
      this.#emit('status');
    }
    if (status) {
      this.status = status;
      this.log = message.log ?? null;
      this.#emit('status');
    }
    if (robots) {
      this.robots = robots.list;
      this.robot = robots.robot;
      this.speeds = robots.speeds;
      this.#emit('robots');
    }
    if (contacts) {
      this.contacts = contacts.map(contactOf);
      this.#emit('contacts');
    }
    if (ranges || rings) {
      this.ranges = new Map(Object.entries(ranges ?? {}).map(([name, values]) => [name, Float32Array.from(values)]));
      this.rings = new Map(Object.entries(rings ?? {}));
      this.#emit('ranges');
    }
    if (series) {
      for (const [key, [time, value]] of Object.entries(series)) this.series.set(key, { time, value });
      this.#emit('series');
    }
    if (messages) {
      this.messages = [...this.messages, ...messages].slice(-MOST_MESSAGES);
      this.#emit('messages');
    }
    if (overlays) {
      this.overlays = overlays;
      this.#emit('overlays');
    }
    if (problem) this.problem(problem.text, problem.level);
  }

  /** @param {Scene} scene */
  setScene(scene) {
    const here = this.assetsHere;
    if (here) {
      const known = Object.entries(scene.assets).filter(([, address]) => address in here);
      scene.assets = Object.fromEntries(known.map(([file, address]) => [file, here[address]]));
    }
    const former = this.entities;
    this.scene = scene;
    this.entities = new Map(scene.entities.map((entity) => [entity.number, entity]));
    this.ids = new Map(scene.entities.map((entity) => [entity.id, entity.number]));
    this.bodies = new Map();
    for (const entity of scene.entities) {
      for (const body of entity.bodies) this.bodies.set(body.id, { body, entity: entity.number, row: body.row });
    }
    for (const body of scene.others) this.bodies.set(body.id, { body, entity: 0, row: body.row });
    this.#renumber((number) => this.ids.get(former.get(number)?.id ?? '') ?? (this.entities.has(number) ? number : null));
    this.#emit('scene');
  }

  /**
   * Keep what is selected, followed, hidden: an entity that was edited is built again, with another number.
   * @param {(number: number) => number | null} now the number of an entity of the former scene; null if it is not there
   */
  #renumber(now) {
    const { selection, follow } = this;
    const entity = selection && now(selection.entity);
    if (selection && entity !== selection.entity) this.select(entity === null ? null : { ...selection, entity });
    if (follow !== null && now(follow) !== follow) this.setFollow(now(follow));
    this.switches = new Set([...this.switches].flatMap((key) => {
      const [name = '', number] = key.split(' ');
      if (number === undefined) return [key];
      const other = now(Number(number));
      return other === null ? [] : [`${name} ${other}`];
    }));
  }

  /** @param {State} state */
  setState(state) {
    if (state.revision !== this.scene?.revision) return; // its scene, and another state, are on their way
    this.state = state;
    // By the server's clock: states arrive unevenly at a page that is busy. A log has the clock of its recording.
    const now = this.log ? performance.now() / 1000 : state.realTime, { history } = this, last = history.at(-1);
    if (last && (last.steps > state.steps || last.at > now)) history.length = 0; // a reset, or back in time
    history.push({ at: now, sim: state.simTime, steps: state.steps });
    while (history.length > 2 && history[0].at < now - SPAN) history.shift();
    const span = now - history[0].at;
    if (span > 0.1) {
      this.realTimeFactor = state.paused ? 0 : (state.simTime - history[0].sim) / span;
      this.stepRate = state.paused ? 0 : (state.steps - history[0].steps) / span;
    }
    this.#emit('state');
  }

  /** @param {string} name @param {Blob} image */
  setImage(name, image) {
    const former = this.images.get(name);
    this.images.set(name, URL.createObjectURL(image));
    this.#emit('images');
    if (former) window.setTimeout(() => URL.revokeObjectURL(former), 1000); // it may be loading still
  }

  // Questions --------------------------------------------------------------------------------------------------------

  /** Position and quaternion (w, x, y, z) of a row of the bodies. @param {number} row @returns {Float32Array | null} */
  bodyPose(row) {
    const { state } = this, columns = state?.bodyColumns ?? ROW.bodies;
    if (!state || row < 0 || columns * (row + 1) > state.bodies.length) return null;
    return state.bodies.subarray(columns * row, columns * row + 7);
  }

  /** Position and quaternion (w, x, y, z) of an entity. @param {number} number @returns {ArrayLike<number> | null} */
  entityPose(number) {
    const entity = this.entities.get(number);
    if (!entity) return null;
    const known = this.bodies.get(entity.body);
    const frame = known ? this.bodyPose(known.row) : null;
    return frame ? composed(frame, entity.pose) : entity.pose;
  }

  // What users do ----------------------------------------------------------------------------------------------------

  /**
   * Send a request; the answer is plain data.
   * @param {string} verb
   * @param {string} [argument]
   * @param {object} [content]
   * @returns {Promise<any>}
   */
  async ask(verb, argument = '-', content = {}) {
    if (!this.link) throw new Error('There is no connection.');
    return this.link.ask(verb, argument, content);
  }

  /**
   * Choose what a channel sends; the names of all that want something of it are added.
   * @param {string} channel
   * @param {string[]} names
   * @param {string} [who]
   */
  want(channel, names, who = '') {
    const all = this.wants.get(channel) ?? new Map();
    this.wants.set(channel, all);
    all.set(who, names);
    this.#sendWants(channel);
  }

  /** @param {string} channel */
  #sendWants(channel) {
    const names = new Set([...(this.wants.get(channel)?.values() ?? [])].flat());
    if (channel === 'images') {
      for (const [name, address] of this.images) {
        if (names.has(name)) continue;
        this.images.delete(name);
        URL.revokeObjectURL(address);
      }
    }
    this.link?.send({ want: channel, names: [...names].slice(0, 500) });
  }

  /** @param {Selection | null} selection */
  select(selection) {
    this.selection = selection;
    this.#emit('selection');
  }

  /** @param {number | null} number */
  setHover(number) {
    if (number === this.hover) return;
    this.hover = number;
    this.#emit('hover');
  }

  /** @param {number | null} number */
  setFollow(number) {
    this.follow = number;
    this.#emit('follow');
  }

  /** @param {Partial<Handles>} some */
  setHandles(some) {
    this.handles = { ...this.handles, ...some };
    this.#emit('handles');
  }

  /** @param {'dark' | 'light'} theme */
  setTheme(theme) {
    this.theme = theme;
    this.#emit('theme');
  }

  /** A switch of an entity, or of all; an entity's counts beside the common one. @param {string} name @param {number} [entity] */
  isOn(name, entity) {
    return this.switches.has(name) || (entity !== undefined && this.switches.has(`${name} ${entity}`));
  }

  /** @param {string} name @param {boolean} on @param {number} [entity] */
  setSwitch(name, on, entity) {
    const key = entity === undefined ? name : `${name} ${entity}`;
    if (on) this.switches.add(key);
    else this.switches.delete(key);
    this.#emit('switches');
  }

  /** @param {View} command */
  view(command) {
    this.viewed = command;
    this.dispatchEvent(new CustomEvent('view', { detail: command }));
  }

  /** @param {string} label */
  chooseRobot(label) {
    this.robot = label;
    this.link?.send({ robot: label });
    this.#emit('robots');
  }

  /** @param {{linear?: number, angular?: number}} some [m/s], [rad/s] */
  setSpeeds(some) {
    this.speeds = { ...this.speeds, ...some };
    this.link?.send({ speeds: this.speeds });
    this.#emit('robots');
  }

  /** Drive the chosen robot: each from -1 to 1. @param {number} forward @param {number} left @param {number} [up] */
  drive(forward, left, up = 0) {
    this.link?.send({ drive: [forward, left, up] });
  }

  /** A key for plugins that listen to keys. @param {number} code */
  pressKey(code) {
    this.link?.send({ key: code });
  }

  /** Show a user a problem. @param {string} text @param {string} [level] */
  problem(text, level = 'error') {
    this.dispatchEvent(new CustomEvent('problem', { detail: { text, level } }));
  }
}

/** Whether an entity is the ground of a world: an infinite plane. @param {Entity} entity */
export const isGround = ({ bodies }) => bodies.some(({ shapes }) => shapes.some(({ kind }) => kind === 'plane'));

/** @param {number[]} row @returns {Contact} */
function contactOf(row) {
  const contact = { position: row.slice(0, 3), normal: row.slice(3, 6), depth: row[6] };
  return row.length < 12 ? contact : { ...contact, force: row.slice(7, 10), entities: row.slice(10, 12) };
}

/** A pose in the frame of another one. @param {ArrayLike<number>} a @param {ArrayLike<number>} b */
function composed(a, b) {
  const [x, y, z, w, i, j, k] = Array.from(a), [px, py, pz, qw, qi, qj, qk] = Array.from(b);
  const tx = 2 * (j * pz - k * py), ty = 2 * (k * px - i * pz), tz = 2 * (i * py - j * px);
  return [
    x + px + w * tx + j * tz - k * ty,
    y + py + w * ty + k * tx - i * tz,
    z + pz + w * tz + i * ty - j * tx,
    w * qw - i * qi - j * qj - k * qk,
    w * qi + i * qw + j * qk - k * qj,
    w * qj - i * qk + j * qw + k * qi,
    w * qk + i * qj - j * qi + k * qw,
  ];
}
