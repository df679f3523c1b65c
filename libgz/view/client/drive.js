// @ts-check
/**
 * Drive: robots by keys, by a stick on the page, and by a gamepad. Without a robot the keys move the camera.
 * @module
 */

import { element, fill, newId, onDrag, show } from 'libgz/dom.js';
import { slider } from 'libgz/controls.js';
import { icon } from 'libgz/icons.js';
import { recall, remember } from 'libgz/settings.js';

/** @typedef {[number, number, number]} Way forward, left and up, each from -1 to 1 */

const PERIOD = 60; // [ms] between two commands
const AGAIN = 500; // [ms] after which the same command is sent again
const DEAD = 0.12; // of a gamepad's axes
const FREE = 'free camera';

/** Which key moves where. */
const WAYS = /** @type {Record<string, Way>} */ ({
  w: [1, 0, 0],
  s: [-1, 0, 0],
  a: [0, 1, 0],
  d: [0, -1, 0],
  PageUp: [0, 0, 1],
  PageDown: [0, 0, -1],
});
const ARROWS = /** @type {Record<string, Way>} */ ({
  ArrowUp: [1, 0, 0],
  ArrowDown: [-1, 0, 0],
  ArrowLeft: [0, 1, 0],
  ArrowRight: [0, -1, 0],
});

/** What moves robots. */
export class Drive {
  /** @param {import('libgz/workplace.js').Workplace} workplace */
  constructor(workplace) {
    this.workplace = workplace;
    const { store } = workplace;
    /** @type {Map<string, Way>} keys that are held */
    this.held = new Map();
    this.stick = /** @type {Way} */ ([0, 0, 0]);
    this.sent = '0,0,0';
    this.sentAt = 0;
    this.walking = false;
    this.isOpen = recall('drive.open', true);
    const id = newId('robot');
    this.robot = element('select', {
      id: 'robot',
      'aria-label': 'Robot',
      on: {
        change: () => {
          store.chooseRobot(this.robot.value === FREE ? '' : this.robot.value);
          this.robot.blur();
        },
        keydown: (/** @type {Event} */ event) => event.stopPropagation(),
      },
    });
    this.options = '';
    this.knob = element('div', { class: 'knob', 'aria-hidden': 'true' });
    this.pad = element(
      'div',
      { class: 'pad', role: 'application', tabindex: 0, 'aria-label': 'Stick: drag it, or use the arrow keys', 'aria-describedby': id },
      element('span', { class: 'pad-mark up', 'aria-hidden': 'true' }, icon('up')),
      element('span', { class: 'pad-mark down', 'aria-hidden': 'true' }, icon('down')),
      element('span', { class: 'pad-mark left', 'aria-hidden': 'true' }, icon('left')),
      element('span', { class: 'pad-mark right', 'aria-hidden': 'true' }, icon('right')),
      this.knob,
    );
    const speeds = store.speeds ?? { linear: 0.4, angular: 0.8 };
    this.foldButton = element(
      'button',
      { type: 'button', class: 'small', 'aria-label': 'Close the drive panel', on: { click: () => this.toggle() } },
      icon('close'),
    );
    this.root = element(
      'section',
      { class: 'drive', 'aria-label': 'Drive', hidden: true },
      this.pad,
      element('div', { class: 'drive-head' }, this.robot, this.foldButton),
      element(
        'div',
        { class: 'drive-speeds' },
        slider({ label: 'Speed', unit: 'm/s', value: speeds.linear, low: 0.05, high: 3, step: 0.05, changed: (linear) => store.setSpeeds({ linear }) }),
        slider({ label: 'Turn', unit: 'rad/s', value: speeds.angular, low: 0.1, high: 3, step: 0.1, changed: (angular) => store.setSpeeds({ angular }) }),
        element('p', { class: 'hint', id, text: 'Keys: W A S D, arrows; page up, page down' }),
      ),
    );
    this.#listen();
    for (const event of ['hello', 'robots', 'scene', 'layout']) store.addEventListener(event, () => this.refresh());
    window.setInterval(() => this.#act(), PERIOD);
    this.refresh();
  }

  /** Whether there is something to drive, and this page may. */
  get offered() {
    const { store } = this.workplace;
    return store.control && store.robots.length > 0;
  }

  /** Whether a robot is driven. */
  get driving() {
    return this.offered && Boolean(this.workplace.store.robot);
  }

  toggle() {
    this.isOpen = !this.isOpen;
    remember('drive.open', this.isOpen);
    this.refresh();
  }

  refresh() {
    const { store } = this.workplace;
    show(this.root, this.offered && this.isOpen);
    const options = JSON.stringify(store.robots.map((robot) => robot.label));
    if (options !== this.options) {
      this.options = options;
      fill(
        this.robot,
        element('option', { value: FREE, text: FREE }),
        store.robots.map((robot) => element('option', { value: robot.label, text: robot.label })),
      );
    }
    const value = store.robot || FREE;
    if (this.robot.value !== value) this.robot.value = value;
    this.root.classList.toggle('idle', !store.robot);
  }

  #listen() {
    const stop = () => {
      this.held.clear();
      this.#place([0, 0, 0]);
      this.#act();
    };
    window.addEventListener('blur', stop);
    document.addEventListener('visibilitychange', () => document.hidden && stop());
    onDrag(this.pad, (event) => {
      this.pad.focus({ preventScroll: true });
      /** @param {PointerEvent} moved */
      const move = (moved) => {
        const box = this.pad.getBoundingClientRect();
        const [x, y] = [moved.clientX - box.left - box.width / 2, moved.clientY - box.top - box.height / 2];
        const reach = box.width / 2 - 18;
        const far = Math.max(Math.hypot(x, y) / reach, 1);
        this.#place([-y / reach / far, -x / reach / far, 0]);
        this.#act();
      };
      const end = () => {
        this.#place([0, 0, 0]);
        this.#act();
      };
      move(event);
      return { move, end };
    });
  }

  /** @param {Way} way */
  #place(way) {
    this.stick = way;
    const reach = this.pad.clientWidth / 2 - 18;
    this.knob.style.transform = `translate(${-way[1] * reach}px, ${-way[0] * reach}px)`;
  }

  /**
   * A key was pressed; whether it moves something.
   * @param {string} key
   * @param {boolean} onPad whether the stick has the focus
   */
  press(key, onPad) {
    const name = key.length === 1 ? key.toLowerCase() : key;
    const arrows = this.driving || onPad || !this.workplace.store.state?.paused || !this.workplace.store.control;
    const way = WAYS[name] ?? (arrows ? ARROWS[name] : undefined);
    if (!way) return false;
    this.held.set(name, way);
    this.#act();
    return true;
  }

  /** @param {string} key that was released */
  release(key) {
    if (this.held.delete(key.length === 1 ? key.toLowerCase() : key)) this.#act();
  }

  /** @returns {Way} */
  #gamepad() {
    for (const pad of navigator.getGamepads?.() ?? []) {
      if (!pad?.connected) continue;
      const axis = (/** @type {number} */ i) => {
        const value = pad.axes[i] ?? 0;
        return Math.abs(value) < DEAD ? 0 : (value - Math.sign(value) * DEAD) / (1 - DEAD);
      };
      const up = (pad.buttons[7]?.value ?? 0) - (pad.buttons[6]?.value ?? 0);
      if (axis(0) || axis(1) || up) return [-axis(1), -axis(0), up];
    }
    return [0, 0, 0];
  }

  #act() {
    const { store } = this.workplace;
    const total = [this.stick, this.#gamepad(), ...this.held.values()].reduce(
      (sum, way) => /** @type {Way} */ (sum.map((part, i) => part + way[i])),
      /** @type {Way} */ ([0, 0, 0]),
    );
    const [forward = 0, left = 0, up = 0] = total.map((part) => Math.round(100 * Math.min(Math.max(part, -1), 1)) / 100 + 0);
    const moves = forward !== 0 || left !== 0 || up !== 0;
    if (!this.stick.some(Boolean)) {
      const reach = this.pad.clientWidth / 2 - 18;
      this.knob.style.transform = `translate(${-left * reach}px, ${-forward * reach}px)`;
    }
    this.knob.classList.toggle('moved', moves);
    const text = `${forward},${left},${up}`;
    const now = performance.now();
    if (this.driving) {
      if (this.walking) {
        this.walking = false;
        store.view({ walk: [0, 0, 0] });
      }
      if (text === this.sent && (!moves || now - this.sentAt < AGAIN)) return;
      if (moves && text !== this.sent && now - this.sentAt < PERIOD / 2) return;
      store.drive(forward, left, up);
      this.sentAt = now;
      this.sent = text;
    } else {
      if (text === this.sent) return;
      this.sent = text;
      this.walking = moves;
      store.view({ walk: [forward, left, up] });
    }
  }
}
