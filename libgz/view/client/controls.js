// @ts-check
/**
 * Controls: sliders, buttons and colours for joints, lights and interfaces of models.
 * @module
 */

import { element, newId, setText } from 'libgz/dom.js';
import { hexOf, partsOf, short } from 'libgz/format.js';

/**
 * @typedef {import('libgz/workplace.js').Workplace} Workplace
 * @typedef {import('libgz/store.js').Entity} Entity
 */

const REACH = /** @type {Record<string, [string, number]>} */ ({
  revolute: ['rad', Math.PI],
  universal: ['rad', Math.PI],
  revolute2: ['rad', Math.PI],
  prismatic: ['m', 1],
}); // unit, and how far without limits
const FREE = 100; // [rad] or [m]: limits beyond are none
const MOST_JOINTS = 24;
const PERIOD = 60; // [ms] between two commands of one control

/**
 * Send the newest value only, one request at a time.
 * @template T
 * @param {(value: T) => Promise<unknown> | void} send
 */
export function newest(send) {
  /** @type {{ value: T } | null} */
  let waiting = null;
  let busy = false;
  const next = async () => {
    while (waiting) {
      const { value } = waiting;
      waiting = null;
      await Promise.all([send(value), new Promise((done) => setTimeout(done, PERIOD))]).catch(() => undefined);
    }
    busy = false;
  };
  return (/** @type {T} */ value) => {
    waiting = { value };
    if (!busy) {
      busy = true;
      void next();
    }
  };
}

/**
 * A slider with its label, value and unit.
 *
 * @param {object} choice
 * @param {string} choice.label
 * @param {string} [choice.unit]
 * @param {number} choice.value
 * @param {number} choice.low
 * @param {number} choice.high
 * @param {number} [choice.step]
 * @param {(value: number) => void} choice.changed
 * @returns {HTMLElement & { set: (value: number) => void }} `set` shows another value, unless a user holds the slider
 */
export function slider({ label, unit = '', value, low, high, step, changed }) {
  const id = newId('slider');
  const figure = element('output', { for: id, class: 'figure' });
  const input = element('input', {
    id,
    type: 'range',
    min: low,
    max: high,
    step: step ?? 'any',
    value: String(Math.min(Math.max(value, low), high)),
  });
  const update = () => {
    const text = `${short(Number(Number(input.value).toFixed(3)))}${unit && ` ${unit}`}`;
    setText(figure, text);
    input.setAttribute('aria-valuetext', text);
  };
  let held = 0;
  input.addEventListener('input', () => {
    held = performance.now();
    update();
    changed(Number(input.value));
  });
  input.addEventListener('keydown', (event) => {
    const fine = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1 }[event.key];
    if (fine || /^(Page|Home|End)/.test(event.key)) event.stopPropagation(); // they move this slider, and nothing else
    if (!fine || step) return;
    event.preventDefault();
    input.value = String(Number(input.value) + (fine * (high - low)) / 100);
    input.dispatchEvent(new Event('input'));
  });
  update();
  const root = element('div', { class: 'slider' }, element('label', { for: id, text: label, title: label }), figure, input);
  return Object.assign(root, {
    /** @param {number} shown */
    set(shown) {
      if (performance.now() - held < 1500 || document.activeElement === input || !Number.isFinite(shown)) return;
      input.value = String(shown);
      update();
    },
  });
}

/**
 * Sliders for the axes of a model's joints, and a button that releases them.
 * @param {Workplace} workplace
 * @param {Entity} entity
 * @param {string} [only] of this joint
 */
export function jointControls(workplace, entity, only) {
  const { ask, store } = workplace;
  const made = [];
  for (const joint of entity.joints) {
    const [unit, reach] = REACH[joint.kind] ?? [];
    if (!unit || !reach || (only !== undefined && joint.name !== only)) continue;
    const limits = joint.limits ?? [];
    limits.slice(0, 2).forEach((pair, axis) => {
      const [least, most] = pair ?? [null, null];
      const low = least === null || Math.abs(least) >= FREE ? -reach : least;
      const high = most === null || Math.abs(most) >= FREE ? reach : most;
      if (!(low < high) || made.length >= MOST_JOINTS) return;
      const send = newest((/** @type {number} */ position) =>
        ask('joint', '-', { name: entity.id, joint: joint.name, axis, position }),
      );
      const value = store.state?.joints[4 * joint.row + axis] ?? 0;
      const label = limits.length > 1 ? `${joint.name} ${axis + 1}` : joint.name;
      made.push(slider({ label, unit, value, low, high, changed: send }));
    });
  }
  if (made.length)
    made.push(
      element('button', {
        type: 'button',
        class: 'text wide-button',
        text: 'Release the joints',
        on: { click: () => ask('release', '-', { name: entity.id }) },
      }),
    );
  return made;
}

/**
 * Brightness and colour of an entity's lights.
 * @param {Workplace} workplace
 * @param {Entity} entity
 */
export function lightControls({ ask }, entity) {
  const lights = entity.bodies.flatMap((body) => body.shapes).filter((shape) => shape.kind === 'light');
  const light = lights[0];
  if (!light) return [];
  /** @type {number[]} */
  const diffuse = (light.material?.diffuse ?? [1, 1, 1]).slice(0, 3).map(Number);
  const most = Math.max(...diffuse, 1e-6);
  let strength = Math.min(most, 1);
  let tint = diffuse.map((part) => Math.min(Math.max(part / most, 0), 1));
  const send = newest(() => ask('light', '-', { name: entity.id, color: tint.map((part) => part * strength) }));
  const id = newId('colour');
  return [
    slider({
      label: 'Brightness',
      value: strength,
      low: 0,
      high: 1,
      changed: (value) => {
        strength = value;
        send(0);
      },
    }),
    element(
      'div',
      { class: 'property' },
      element('label', { for: id, text: 'Colour' }),
      element('input', {
        id,
        type: 'color',
        value: hexOf(tint),
        on: {
          input: (/** @type {Event} */ event) => {
            tint = partsOf(/** @type {HTMLInputElement} */ (event.target).value);
            send(0);
          },
        },
      }),
    ),
  ];
}

/**
 * Sliders and buttons of the heads, grippers and actuators that an entity has or carries.
 * @param {Workplace} workplace
 * @param {Entity} entity
 */
export async function interfaceControls({ ask, store }, entity) {
  if (!store.control || !store.abilities.has('parts')) return [];
  /** @type {{ key: string, kind: string, label: string, value: number, low: number, high: number, unit: string }[]} */
  const parts = (await ask('parts', entity.id)) ?? [];
  return parts.map((part) => {
    const send = newest((/** @type {number} */ value) => ask('steer', part.key, { value }));
    if (part.kind === 'button')
      return element('button', { type: 'button', class: 'text part', text: part.label, on: { click: () => send(1) } });
    return slider({ label: part.label, unit: part.unit, value: part.value, low: part.low, high: part.high, changed: send });
  });
}
