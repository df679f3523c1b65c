// @ts-check
/**
 * Toolbar: time, editing, what is shown, and the page itself.
 * @module
 */

import { entryOf, isOffered } from 'libgz/actions.js';
import { element, fill, newId, setText, show } from 'libgz/dom.js';
import { clock, fixed } from 'libgz/format.js';
import { icon } from 'libgz/icons.js';
import { menuButton } from 'libgz/menu.js';
import { globalMarks } from 'libgz/switches.js';
import { Tool } from 'libgz/tool.js';

/** @typedef {import('libgz/actions.js').Action} Action */

const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 5];
const FASTEST = 10;

/** The bar at the top of the page. */
export class Toolbar {
  /** @param {import('libgz/workplace.js').Workplace} workplace */
  constructor(workplace) {
    this.workplace = workplace;
    const { actions, store } = workplace;
    /** @type {Tool[]} */
    this.tools = [];
    this.speed = 1;

    this.title = element('span', { class: 'world-title' });
    this.simTime = element('output', { id: 'sim-time', class: 'figure', title: 'Sim time' }, '–');
    this.factor = element('output', { id: 'real-time-factor', class: 'figure', title: 'Real-time factor: sim time per real time' }, '–');
    this.runState = element('span', { id: 'run-state', class: 'run-state' });
    this.speedText = element('span', { text: '1×' });
    this.speedButton = menuButton(
      element('button', { type: 'button', class: 'text', title: 'Speed', 'aria-label': 'Speed' }, icon('speed'), this.speedText),
      'Speed',
      () => this.#speeds(),
    );
    this.control = element('button', { type: 'button', class: 'chip', id: 'control', on: { click: () => workplace.dialogs.control() } });

    const more = menuButton(
      element('button', { type: 'button', class: 'tool more', 'aria-label': 'More', title: 'More' }, icon('more')),
      'More',
      () => this.#more(),
    );
    const marks = menuButton(
      element('button', { type: 'button', class: 'text', 'aria-label': 'Show', title: 'What is shown' }, icon('marks'), element('span', { class: 'wide', text: 'Show' })),
      'Show',
      () => globalMarks(workplace),
    );
    const views = menuButton(
      element('button', { type: 'button', class: 'tool not-phone', 'aria-label': 'Views', title: 'Views' }, icon('view')),
      'Views',
      () =>
        [actions.fit, actions.focus, actions.follow, null, actions.front, actions.back, actions.left, actions.right, actions.top, actions.iso].map(
          (action) => (action ? entryOf(action) : { line: true }),
        ),
    );

    /** @param {Action} action @param {string} [extra] */
    const tool = (action, extra = '') => this.#tool(action, extra);
    this.root = element(
      'header',
      { class: 'toolbar', role: 'toolbar', 'aria-label': 'Tools' },
      element('div', { class: 'tools brand wide' }, this.title),
      element('div', { class: 'tools' }, tool(actions.run, 'main'), tool(actions.step), tool(actions.reset), this.speedButton),
      element('div', { class: 'tools figures' }, this.runState, this.simTime, this.factor),
      element('div', { class: 'spring' }),
      element('div', { class: 'tools not-phone' }, tool(actions.undo), tool(actions.redo)),
      element('div', { class: 'tools' }, tool(actions.insert, 'not-phone'), tool(actions.save, 'not-phone'), marks, views),
      element('div', { class: 'tools wide' }, tool(actions.record), tool(actions.screenshot)),
      element('div', { class: 'tools wide' }, tool(actions.tree), tool(actions.dock), tool(actions.inspector)),
      element('div', { class: 'tools wide' }, tool(actions.theme), tool(actions.help)),
      this.control,
      more,
    );
    this.root.addEventListener('keydown', (event) => this.#moveFocus(event));
    for (const event of ['hello', 'state', 'status', 'scene', 'handles', 'theme', 'layout', 'selection', 'follow', 'control'])
      store.addEventListener(event, () => this.refresh());
    this.refresh();
  }

  /**
   * @param {Action} action
   * @param {string} extra classes
   */
  #tool(action, extra) {
    const tool = new Tool(action, extra);
    this.tools.push(tool);
    return tool.root;
  }

  /** What the bar has no space for. */
  #more() {
    const { actions } = this.workplace;
    const phone = this.workplace.layout.isPhone;
    const groups = [
      phone ? [actions.insert, actions.save, actions.undo, actions.redo] : [],
      phone ? [actions.fit, actions.focus, actions.follow, actions.top, actions.front, actions.left, actions.iso] : [],
      [actions.record, actions.screenshot],
      phone ? [] : [actions.tree, actions.dock, actions.inspector],
      [actions.theme, actions.help],
    ];
    return groups
      .map((group) => group.filter(isOffered).map((action) => entryOf(action)))
      .filter((group) => group.length)
      .flatMap((group, i) => (i ? [{ line: true }, ...group] : group));
  }

  /** @returns {import('libgz/menu.js').Entry[]} */
  #speeds() {
    const choose = (/** @type {number} */ speed) => this.setSpeed(speed);
    const id = newId('speed');
    const slider = element('input', {
      id,
      type: 'range',
      min: -1,
      max: 1,
      step: 0.01,
      value: String(Math.log10(this.speed)),
      'aria-valuetext': `${this.speed}×`,
      on: {
        input: (/** @type {Event} */ event) => {
          const value = 10 ** Number(/** @type {HTMLInputElement} */ (event.target).value);
          choose(Number(value.toPrecision(2)));
          slider.setAttribute('aria-valuetext', `${this.speed}×`);
        },
      },
    });
    return [
      { content: element('div', { class: 'menu-slider' }, element('label', { for: id, text: 'Speed' }), slider) },
      { line: true },
      ...SPEEDS.map((speed) => ({
        label: `${speed}×`,
        choice: true,
        checked: speed === this.speed,
        action: () => choose(speed),
      })),
    ];
  }

  /**
   * Ask for another speed.
   * @param {number} speed simulated seconds per second
   */
  setSpeed(speed) {
    this.speed = Math.min(Math.max(speed, 0.1), FASTEST);
    setText(this.speedText, `${this.speed}×`);
    this.workplace.ask('speed', String(this.speed));
  }

  /** @param {KeyboardEvent} event */
  #moveFocus(event) {
    const way = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (!way || event.ctrlKey || event.altKey) return;
    const all = [...this.root.querySelectorAll('button')].filter((one) => one.offsetParent !== null && !one.disabled);
    const here = all.indexOf(/** @type {HTMLButtonElement} */ (document.activeElement));
    if (here < 0) return;
    all[(here + way + all.length) % all.length]?.focus();
    event.preventDefault();
    event.stopPropagation();
  }

  refresh() {
    const { store } = this.workplace;
    for (const tool of this.tools) tool.refresh(store.connected);
    const { state } = store;
    setText(this.title, store.title);
    show(this.speedButton, store.control && store.abilities.has('speed'));
    setText(this.simTime, state ? clock(state.simTime) : '–');
    setText(this.factor, state && Number.isFinite(store.realTimeFactor) ? `${fixed(store.realTimeFactor, 2)}×` : '–');
    this.factor.title = `Real-time factor: sim time per real time; ${fixed(store.stepRate || 0, 0)} steps per second`;
    const running = !store.connected ? 'lost' : !state ? 'loading' : state.paused ? 'paused' : 'running';
    setText(this.runState, running);
    this.runState.className = `run-state ${running}`;
    this.#showControl();
  }

  #showControl() {
    const { store } = this.workplace;
    const { controllers } = store;
    show(this.control, store.connected && Boolean(!store.control || controllers?.other || store.asked));
    const text = store.asked ? `${store.asked} asks for control` : store.control ? 'You control' : 'Watching';
    if (this.control.getAttribute('aria-label') !== text) {
      this.control.setAttribute('aria-label', text);
      this.control.title = store.control ? 'You control this world' : 'You can look around, but not control';
      fill(this.control, icon(store.control ? 'hand' : 'eye'), element('span', { text }));
    }
  }
}
