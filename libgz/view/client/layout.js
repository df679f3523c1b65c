// @ts-check
/**
 * Layout: where the page's panels are. On a phone they are sheets at the bottom, one at a time.
 * @module
 */

import { element, onDrag, show } from 'libgz/dom.js';
import { icon } from 'libgz/icons.js';
import { recall, remember } from 'libgz/settings.js';
import { splitter } from 'libgz/splitter.js';

/** @typedef {'tree' | 'inspector' | 'dock'} PanelName */

const PHONE = '(max-width: 640px)';
const NARROW = 1000; // [px] below, fewer panels are open at first
const LEAST_VIEW = 200; // [px] that panels leave to the view

/** The panels around the view. */
export class Layout {
  /**
   * @param {HTMLElement} root
   * @param {EventTarget} store it gets an event `layout` when a panel was opened or closed
   */
  constructor(root, store) {
    this.store = store;
    this.phone = window.matchMedia(PHONE);
    const wide = window.innerWidth >= NARROW;
    /** @type {Record<PanelName, boolean>} */
    this.open = {
      tree: recall('open.tree', wide || window.innerWidth >= 760),
      inspector: recall('open.inspector', wide),
      dock: recall('open.dock', false),
    };
    /** @type {PanelName | ''} */
    this.sheet = '';
    this.tab = recall('dock.tab', 'plots');
    this.stage = element('div', { id: 'view-area', class: 'view-area' });
    this.stageParent = element('div', { id: 'stage', class: 'stage' });
    this.stage.append(this.stageParent);
    this.dockTabs = element('div', { class: 'tabs', role: 'tablist', 'aria-label': 'Panels below' });
    this.dockBody = element('div', { class: 'dock-body' });
    const fold = element(
      'button',
      { type: 'button', class: 'tool fold', 'aria-label': 'Fold the panels below', title: 'Fold', on: { click: () => this.toggle('dock') } },
      icon('down'),
    );
    this.foldButton = fold;
    this.strip = element('div', { class: 'strip' });
    this.panels = {
      tree: this.#panel('tree', 'Tree', 'left'),
      inspector: this.#panel('inspector', 'Inspector', 'right'),
      dock: element('section', { class: 'dock', 'aria-label': 'Plots and console' }, element('div', { class: 'dock-head' }, this.dockTabs, fold), this.dockBody),
    };
    const space = () => window.innerWidth - LEAST_VIEW;
    const sizes = { tree: wide ? 250 : 190, inspector: wide ? 300 : 250, dock: 220 };
    this.edges = {
      tree: splitter(root, { name: 'tree', label: 'Width of the tree', side: 'left', size: sizes.tree, least: 150, most: () => space() * 0.6 }),
      inspector: splitter(root, { name: 'inspector', label: 'Width of the inspector', side: 'right', size: sizes.inspector, least: 200, most: () => space() * 0.6 }),
      dock: splitter(root, { name: 'dock', label: 'Height of plots and console', side: 'bottom', size: sizes.dock, least: 100, most: () => window.innerHeight * 0.7 }),
    };
    this.nav = element('nav', { class: 'phone-nav', 'aria-label': 'Panels' });
    this.root = element(
      'main',
      { class: 'middle' },
      this.panels.tree,
      this.edges.tree,
      element('div', { class: 'center' }, this.stage, this.strip, this.edges.dock, this.panels.dock),
      this.edges.inspector,
      this.panels.inspector,
    );
    /** @type {{ tab: string, button: HTMLElement, content: HTMLElement }[]} */
    this.docked = [];
    this.phone.addEventListener('change', () => this.apply());
    this.#addToNav('tree', 'World', 'world', () => this.toggle('tree'));
    this.#addToNav('inspector', 'Inspector', 'edit', () => this.toggle('inspector'));
    this.#sheetGrip();
  }

  /**
   * A button of a phone, which opens a panel.
   * @param {string} panel its name, or that of a tab
   * @param {string} label
   * @param {import('libgz/icons.js').IconName} image
   * @param {() => void} act
   */
  #addToNav(panel, label, image, act) {
    const button = element('button', { type: 'button', 'data-panel': panel, 'aria-pressed': 'false', on: { click: act } }, icon(image), element('span', { text: label }));
    this.nav.append(button);
  }

  get isPhone() {
    return this.phone.matches;
  }

  /**
   * @param {PanelName} name
   * @param {string} title
   * @param {string} side
   */
  #panel(name, title, side) {
    return element(
      'aside',
      { class: `side ${side}`, 'aria-label': title },
      element(
        'div',
        { class: 'side-head' },
        element('h2', { text: title }),
        element(
          'button',
          { type: 'button', class: 'tool fold', 'aria-label': `Fold the ${title.toLowerCase()}`, title: 'Fold', on: { click: () => this.toggle(name) } },
          icon(side === 'left' ? 'left' : 'right'),
        ),
      ),
    );
  }

  /** Sheets are moved by their heads. */
  #sheetGrip() {
    for (const name of /** @type {PanelName[]} */ (['tree', 'inspector', 'dock'])) {
      const head = /** @type {HTMLElement} */ (this.panels[name].firstElementChild);
      onDrag(head, ({ target }) => {
        if (!this.isPhone || /** @type {Element} */ (target).closest('button, [role=tab]')) return undefined;
        return {
          move: ({ clientY }) => {
            const share = (window.innerHeight - clientY) / window.innerHeight;
            this.root.style.setProperty('--sheet', `${Math.round(100 * Math.min(Math.max(share, 0.15), 0.85))}%`);
            if (share < 0.14) this.toggle(name, false);
          },
        };
      });
    }
  }

  /**
   * Add a tab to the dock, which is a sheet of its own on a phone.
   * @param {string} tab
   * @param {string} label
   * @param {import('libgz/icons.js').IconName} image
   * @param {HTMLElement} content
   * @param {HTMLElement} [badge]
   */
  addTab(tab, label, image, content, badge) {
    const button = element(
      'button',
      {
        type: 'button',
        role: 'tab',
        id: `tab-${tab}`,
        'aria-controls': `panel-${tab}`,
        on: {
          click: () => (this.isOpen('dock') && this.tab === tab ? this.toggle('dock') : this.openDock(tab)),
          keydown: (/** @type {KeyboardEvent} */ event) => this.#moveTab(event),
        },
      },
      icon(image),
      label,
      badge,
    );
    content.id = `panel-${tab}`;
    content.setAttribute('role', 'tabpanel');
    content.setAttribute('aria-labelledby', button.id);
    this.docked.push({ tab, button, content });
    this.dockTabs.append(button);
    this.dockBody.append(content);
    this.#addToNav(tab, label, image, () => this.#phoneTab(tab));
  }

  /** @param {KeyboardEvent} event */
  #moveTab(event) {
    const way = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (!way) return;
    event.preventDefault();
    event.stopPropagation();
    const here = this.docked.findIndex(({ button }) => button === document.activeElement);
    const next = this.docked[(here + way + this.docked.length) % this.docked.length];
    if (!next) return;
    this.openDock(next.tab);
    next.button.focus();
  }

  /** @param {string} tab */
  #phoneTab(tab) {
    if (this.sheet === 'dock' && this.tab === tab) this.toggle('dock', false);
    else this.openDock(tab);
  }

  /** @param {PanelName} name */
  isOpen(name) {
    return this.isPhone ? this.sheet === name : this.open[name];
  }

  /**
   * Open or close a panel.
   * @param {PanelName} name
   * @param {boolean} [wanted]
   */
  toggle(name, wanted = !this.isOpen(name)) {
    if (this.isPhone) this.sheet = wanted ? name : '';
    else {
      this.open[name] = wanted;
      remember(`open.${name}`, wanted);
    }
    this.apply();
  }

  /**
   * Open the dock at a tab.
   * @param {string} tab
   */
  openDock(tab) {
    if (this.tab === tab && this.isOpen('dock')) return;
    this.tab = tab;
    remember('dock.tab', tab);
    this.toggle('dock', true);
  }

  /** Show what is open. */
  apply() {
    const { isPhone } = this;
    if (!this.docked.some(({ tab }) => tab === this.tab)) this.tab = this.docked[0]?.tab ?? '';
    for (const name of /** @type {PanelName[]} */ (['tree', 'inspector', 'dock'])) {
      const open = this.isOpen(name);
      if (name === 'dock') {
        this.panels.dock.classList.toggle('folded', !open);
        show(this.panels.dock, open || !isPhone);
        show(this.dockBody, open);
        this.foldButton.setAttribute('aria-expanded', String(open));
        this.foldButton.classList.toggle('turned', !open);
      } else show(this.panels[name], open);
      show(this.edges[name], open && !isPhone);
    }
    for (const { tab, button, content } of this.docked) {
      const on = tab === this.tab && this.isOpen('dock');
      button.setAttribute('aria-selected', String(on));
      button.tabIndex = tab === this.tab ? 0 : -1;
      show(content, on);
    }
    for (const button of this.nav.querySelectorAll('button')) {
      const panel = button.getAttribute('data-panel');
      const on = this.sheet === panel || (this.sheet === 'dock' && this.tab === panel);
      button.setAttribute('aria-pressed', String(on));
    }
    document.documentElement.classList.toggle('phone', isPhone);
    this.root.classList.toggle('sheet-open', isPhone && this.sheet !== '');
    this.store.dispatchEvent(new Event('layout'));
  }
}
