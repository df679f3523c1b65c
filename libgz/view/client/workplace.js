// @ts-check
/**
 * Workplace: all that is around the 3D view. To add a panel, write a class with an element `root` and add it here.
 * @module
 */

import { isOffered, makeActions } from 'libgz/actions.js';
import { Console } from 'libgz/console.js';
import { Dialogs } from 'libgz/dialogs.js';
import { element, fill, setText, show } from 'libgz/dom.js';
import { Drive } from 'libgz/drive.js';
import { icon } from 'libgz/icons.js';
import { Images } from 'libgz/images.js';
import { Inspector } from 'libgz/inspector.js';
import { Keys } from 'libgz/keys.js';
import { Layout } from 'libgz/layout.js';
import { Overlays } from 'libgz/overlays.js';
import { Plots } from 'libgz/plots.js';
import { Sampler } from 'libgz/series.js';
import { recall, remember } from 'libgz/settings.js';
import { isGround } from 'libgz/store.js';
import { Timeline } from 'libgz/timeline.js';
import { Toasts } from 'libgz/toasts.js';
import { Tool } from 'libgz/tool.js';
import { Toolbar } from 'libgz/toolbar.js';
import { imageOf, Tree } from 'libgz/tree.js';

/** @typedef {import('libgz/store.js').Store} Store */
/** @typedef {import('libgz/stage.js').Stage} Stage */

const WAIT = 1500; // [ms] until it is clear who controls
const WATCHING = 'This page only watches: you can look around, but not control.';

/** The page around the view. */
export class Workplace {
  /**
   * @param {HTMLElement} parent
   * @param {Store} store
   * @param {(parent: HTMLElement, store: Store) => Stage} makeStage
   */
  constructor(parent, store, makeStage) {
    this.store = store;
    this.toasts = new Toasts();
    this.#applyTheme();
    this.root = element('div', { class: 'workplace' });
    this.ask = this.ask.bind(this);
    this.layout = new Layout(this.root, store);
    this.loading = this.#makeLoading();
    this.banner = element('div', { class: 'banner', id: 'banner', role: 'alert', hidden: true });
    parent.append(this.root);
    this.root.append(this.layout.root);
    this.stage = makeStage(this.layout.stageParent, store);
    this.sampler = new Sampler(store);
    this.actions = makeActions(this);
    this.timeline = new Timeline(this);
    this.images = new Images(this);
    this.drive = new Drive(this);
    this.dialogs = new Dialogs(this);
    this.toolbar = new Toolbar(this);
    this.tree = new Tree(this);
    this.plots = new Plots(this);
    this.inspector = new Inspector(this);
    this.console = new Console(this);
    this.root.prepend(this.toolbar.root);
    this.root.append(this.layout.nav);
    this.layout.panels.tree.append(this.tree.root);
    this.layout.panels.inspector.append(this.inspector.root);
    this.layout.addTab('plots', 'Plots', 'plot', this.plots.root);
    this.layout.addTab('console', 'Console', 'console', this.console.root, this.console.badge);
    this.layout.strip.append(this.timeline.root);
    this.layout.stage.append(this.#makeViewTools(), this.#makeEmptyHint(), this.loading.root, this.banner, this.drive.root, this.toasts.root);
    this.overlays = new Overlays(this);
    this.keys = new Keys(this);
    this.layout.apply();
    this.#listen();
    this.#showStatus();
    this.#showProgress();
  }

  /**
   * Send a request; undefined if it was refused, which the user is shown.
   * @param {string} verb
   * @param {string} [argument]
   * @param {object} [content]
   * @returns {Promise<any>}
   */
  async ask(verb, argument = '-', content = {}) {
    try {
      return (await this.store.ask(verb, argument, content)) ?? null;
    } catch (error) {
      this.toasts.add(error instanceof Error ? error.message : String(error));
      return undefined;
    }
  }

  /**
   * Select an entity, as soon as it is in the scene.
   * @param {string[] | null} [names] of what was made; the first counts
   */
  selectNamed(names) {
    const { store } = this;
    const [name] = names ?? [];
    if (name === undefined) return;
    const look = () => {
      const number = store.ids.get(name);
      if (number === undefined) return;
      store.removeEventListener('scene', look);
      store.select({ entity: number });
    };
    store.addEventListener('scene', look);
    window.setTimeout(() => store.removeEventListener('scene', look), 5000);
    look();
  }

  /** Why this page does not control the world, as a sentence for users. */
  get whyWatching() {
    const { watchReason, controllers } = this.store;
    const other = controllers.canAsk && controllers.other ? 'Another page controls this world.' : '';
    return [watchReason ?? other, WATCHING].filter(Boolean).join(' ');
  }

  /**
   * Save a file where the browser keeps downloads.
   * @param {Blob} content
   * @param {string} name
   */
  download(content, name) {
    const url = URL.createObjectURL(content);
    const link = element('a', { href: url, download: name });
    link.click();
    window.setTimeout(() => URL.revokeObjectURL(url), 10000);
  }

  async takeScreenshot() {
    const name = (this.store.scene?.world || 'world').replace(/[^\w.-]+/g, '_');
    this.download(await this.stage.screenshot(), `${name}-${(this.store.state?.simTime ?? 0).toFixed(2)}.png`);
  }

  // Theme ------------------------------------------------------------------------------------------------------------

  /** Show the theme that the user chose, else that of the system. */
  #applyTheme() {
    const bright = window.matchMedia('(prefers-color-scheme: light)');
    const apply = () => {
      const chosen = recall('theme', /** @type {string} */ (''));
      this.#showTheme(chosen === 'dark' || chosen === 'light' ? chosen : bright.matches ? 'light' : 'dark');
    };
    bright.addEventListener('change', apply);
    apply();
  }

  /** @param {'dark' | 'light'} theme */
  setTheme(theme) {
    remember('theme', theme);
    this.#showTheme(theme);
  }

  /** @param {'dark' | 'light'} theme */
  #showTheme(theme) {
    document.documentElement.setAttribute('data-theme', theme);
    this.store.setTheme(theme);
  }

  // Over the view ----------------------------------------------------------------------------------------------------

  #makeViewTools() {
    const { actions, store } = this;
    const some = [actions.translate, actions.rotate, actions.space, actions.snap, null, actions.fit, actions.follow];
    const made = some.map((action) => action && new Tool(action));
    const root = element(
      'div',
      { class: 'view-tools', role: 'toolbar', 'aria-label': 'View', 'aria-orientation': 'vertical' },
      made.map((tool) => tool?.root ?? element('hr')),
    );
    const refresh = () => made.forEach((tool) => tool?.refresh());
    for (const event of ['hello', 'handles', 'selection', 'follow', 'scene']) store.addEventListener(event, refresh);
    refresh();
    return root;
  }

  /** What to do first in a world with nothing but ground and light. */
  #makeEmptyHint() {
    const { actions, store } = this;
    const insert = element('button', { type: 'button', class: 'text primary', text: 'Insert a model', on: { click: () => actions.insert.act() } });
    const root = element('div', { class: 'empty-hint', hidden: true }, element('p', { text: 'This world is empty.' }), insert, element('p', { class: 'hint', text: 'or drop an SDF, URDF or mesh file here' }));
    const refresh = () => {
      const fills = (/** @type {import('libgz/store.js').Entity} */ entity) => imageOf(entity) !== 'light' && entity.bodies.length > 0 && !isGround(entity);
      show(root, isOffered(actions.insert) && Boolean(store.scene) && ![...store.entities.values()].some(fills));
    };
    for (const event of ['hello', 'scene']) store.addEventListener(event, refresh);
    return root;
  }

  #makeLoading() {
    const bar = element('div', { class: 'loading-bar' });
    const text = element('p', { text: 'Connecting …' });
    const root = element(
      'div',
      { class: 'loading', role: 'progressbar', 'aria-label': 'Loading the world', 'aria-valuemin': 0, 'aria-valuemax': 100 },
      element('div', { class: 'loading-box' }, text, element('div', { class: 'loading-track' }, bar)),
    );
    return { root, bar, text };
  }

  #showProgress() {
    const { stage, store } = this;
    const { root, bar, text } = this.loading;
    show(root, !stage.ready);
    if (stage.ready) return;
    const { done, total } = stage.progress;
    const share = store.state ? (total ? 0.15 + 0.85 * (done / total) : 0.15) : store.connected ? 0.08 : 0.02;
    bar.style.transform = `scaleX(${share})`;
    root.setAttribute('aria-valuenow', String(Math.round(100 * share)));
    setText(text, !store.connected ? 'Connecting …' : !store.scene ? 'Waiting for the world …' : `Loading ${store.scene.world || 'the world'} …`);
  }

  #listen() {
    const { store } = this;
    for (const event of ['hello', 'status', 'scene', 'progress']) store.addEventListener(event, () => this.#showProgress());
    for (const event of ['hello', 'status']) store.addEventListener(event, () => this.#showStatus());
    store.addEventListener('problem', (event) => {
      const { text, level } = /** @type {CustomEvent} */ (event).detail;
      this.toasts.add(String(text), level);
    });
    let asked = '';
    let reported = false;
    store.addEventListener('hello', () => {
      if (store.asked && store.asked !== asked) this.toasts.add(`${store.asked} asks for control. Answer at the upper right.`, 'warning');
      asked = store.asked;
      document.title = store.title || 'libgz';
      if (reported) return;
      reported = true;
      window.setTimeout(() => {
        if (store.connected && !store.control) this.toasts.add(this.whyWatching, 'info');
      }, WAIT);
    });
  }

  #showStatus() {
    const { text } = this.store.status;
    show(this.banner, Boolean(text));
    if (this.banner.getAttribute('data-text') === text) return;
    this.banner.setAttribute('data-text', text);
    fill(this.banner, icon('warning'), element('span', { text }));
  }
}
