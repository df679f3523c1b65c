// @ts-check
/**
 * Tree: what is in the world, with search, and an eye and a lock for each model.
 *
 * Only the rows that are in sight are in the page, so that large worlds cost no more than small ones.
 * @module
 */

import { element, fill, setText } from 'libgz/dom.js';
import { icon } from 'libgz/icons.js';
import { openMenu } from 'libgz/menu.js';
import { entryOf, isOffered } from 'libgz/actions.js';
import { marks } from 'libgz/switches.js';

/**
 * @typedef {object} TreeNode
 * @property {string} key
 * @property {string} label
 * @property {string} note beside the label, such as the type
 * @property {import('libgz/icons.js').IconName} icon
 * @property {number} depth
 * @property {number} entity its number; 0 for the world
 * @property {import('libgz/store.js').Part} [part]
 * @property {TreeNode[]} children
 *
 * @typedef {{ root: HTMLElement, node: TreeNode, rendered: string }} Row in the page
 */

const WORLD = 'world';
const INDENT = 14; // [px]

/** The tree at the left. */
export class Tree {
  /** @param {import('libgz/workplace.js').Workplace} workplace */
  constructor(workplace) {
    this.workplace = workplace;
    const { store } = workplace;
    /** @type {TreeNode[]} */
    this.roots = [];
    /** @type {TreeNode[]} that are unfolded, in order */
    this.shown = [];
    /** @type {Map<string, Row>} */
    this.made = new Map();
    /** Names of what is unfolded: an edited model gets another number. */
    this.open = new Set([WORLD]);
    this.active = WORLD;
    this.search = element('input', {
      type: 'search',
      placeholder: 'Search',
      'aria-label': 'Search the tree',
      on: { input: () => this.draw() },
    });
    this.rows = element('div', { class: 'tree-rows' });
    this.list = element(
      'div',
      { class: 'tree', role: 'tree', 'aria-label': 'World', tabindex: 0 },
      this.rows,
    );
    this.empty = element('p', { class: 'hint', hidden: true });
    this.root = element(
      'div',
      { class: 'panel-body tree-panel' },
      element('div', { class: 'search' }, icon('search'), this.search),
      this.list,
      this.empty,
    );
    this.list.addEventListener('scroll', () => this.#drawRows());
    this.list.addEventListener('keydown', (event) => this.#key(event));
    this.list.addEventListener('focus', () => this.#drawRows());
    new ResizeObserver(() => this.#drawRows()).observe(this.list);
    store.addEventListener('scene', () => this.build());
    store.addEventListener('hello', () => this.build());
    store.addEventListener('switches', () => this.#drawRows());
    store.addEventListener('selection', () => this.#reveal());
    store.addEventListener('hover', () => this.#drawRows());
    this.build();
  }

  /** Height of a row [px]. */
  get height() {
    return this.workplace.layout?.isPhone ? 40 : 26;
  }

  build() {
    const { scene, entities } = this.workplace.store;
    if (!scene) return;
    /** @type {Map<number, number[]>} */
    const below = new Map();
    for (const [number, entity] of entities) {
      if (entity.kind === 'joints' && !entity.joints.length) continue;
      const parent = entities.has(entity.parent) ? entity.parent : 0;
      const list = below.get(parent);
      if (list) list.push(number);
      else below.set(parent, [number]);
    }
    const models = (below.get(0) ?? []).map((number) => this.#model(number, 1, below));
    this.roots = [
      { key: WORLD, label: scene.world || 'world', note: `${entities.size}`, icon: 'world', depth: 0, entity: 0, children: models },
    ];
    if (this.roots[0] && models.length <= 8)
      for (const model of models) if (model.children.some((child) => !child.part)) this.open.add(nameOf(model));
    this.draw();
  }

  /**
   * @param {number} number
   * @param {number} depth
   * @param {Map<number, number[]>} below
   * @returns {TreeNode}
   */
  #model(number, depth, below) {
    const entity = /** @type {import('libgz/store.js').Entity} */ (this.workplace.store.entities.get(number));
    const key = `${number}`;
    /**
     * @param {import('libgz/store.js').Part['kind']} kind
     * @param {import('libgz/icons.js').IconName} image
     * @param {string} name
     * @param {string} note
     * @param {number} place
     * @returns {TreeNode}
     */
    const part = (kind, image, name, note, place) => ({
      key: `${key}/${kind}/${place}`,
      label: name || note || kind,
      note: name ? note : '',
      icon: image,
      depth: depth + 1,
      entity: number,
      part: { kind, name },
      children: [],
    });
    const nested = depth < 40 ? (below.get(number) ?? []) : [];
    return {
      key,
      label: entity.id,
      note: entity.type || (entity.kind === 'model' ? '' : entity.kind),
      icon: imageOf(entity),
      depth,
      entity: number,
      children: [
        ...nested.map((child) => this.#model(child, depth + 1, below)),
        ...entity.bodies.map((body, i) => part('body', 'link', body.name, body.name ? '' : `body ${i + 1}`, i)),
        ...entity.joints.map((joint, i) => part('joint', 'joint', joint.name, joint.kind, i)),
        ...entity.sensors.map((sensor, i) => part('sensor', 'sensor', sensor.name ?? '', sensor.kind, i)),
      ],
    };
  }

  /** Find out which rows there are, and show them. */
  draw() {
    const wanted = this.search.value.trim().toLowerCase();
    /** @type {TreeNode[]} */
    const found = [];
    /** @param {TreeNode} node @returns {boolean} */
    const collect = (node) => {
      const place = found.length;
      found.push(node);
      const own = !wanted || node.label.toLowerCase().includes(wanted) || node.note.toLowerCase().includes(wanted);
      let any = own;
      if (wanted ? true : this.open.has(nameOf(node))) for (const child of node.children) any = collect(child) || any;
      if (wanted && !any) found.length = place;
      return any;
    };
    this.roots.forEach(collect);
    this.shown = found;
    const nothing = wanted !== '' && !found.length;
    this.empty.hidden = !nothing;
    this.list.hidden = nothing;
    if (nothing) setText(this.empty, `Nothing is called “${this.search.value.trim()}”.`);
    if (!found.some((node) => node.key === this.active)) this.active = found[0]?.key ?? '';
    this.#drawRows();
  }

  /** Show the rows that are in sight. A row stays the same element, so that clicks on it can be counted. */
  #drawRows() {
    const { height } = this;
    const first = Math.max(Math.floor(this.list.scrollTop / height) - 4, 0);
    const count = Math.ceil((this.list.clientHeight || 400) / height) + 8;
    this.rows.style.height = `${this.shown.length * height}px`;
    const used = new Set();
    this.shown.slice(first, first + count).forEach((node, i) => {
      used.add(node.key);
      let row = this.made.get(node.key);
      if (!row) {
        row = { root: element('div', { class: 'tree-row', id: `tree-${node.key}`, role: 'treeitem' }), node, rendered: '' };
        this.#listen(row);
        this.made.set(node.key, row);
      }
      row.node = node;
      this.#drawRow(row, first + i);
      if (row.root.parentElement !== this.rows || this.rows.children[i] !== row.root)
        this.rows.insertBefore(row.root, this.rows.children[i] ?? null);
    });
    for (const [key, row] of this.made) {
      if (used.has(key)) continue;
      row.root.remove();
      this.made.delete(key);
    }
    this.list.setAttribute('aria-activedescendant', this.active ? `tree-${this.active}` : '');
  }

  /** @param {TreeNode} node */
  #isSelected(node) {
    const { selection } = this.workplace.store;
    if (!node.entity) return false;
    if (!selection || selection.entity !== node.entity) return false;
    if (!selection.part || !node.part) return !selection.part && !node.part;
    return selection.part.kind === node.part.kind && selection.part.name === node.part.name;
  }

  /** @param {Row} row */
  #listen(row) {
    const { store } = this.workplace;
    const { root } = row;
    const isModel = () => row.node.entity !== 0 && !row.node.part;
    root.addEventListener('click', () => this.#choose(row.node));
    root.addEventListener('dblclick', () => row.node.entity && store.view({ focus: row.node.entity }));
    root.addEventListener('contextmenu', (event) => {
      event.preventDefault();
      this.#choose(row.node);
      this.#menu(row.node, { x: event.clientX, y: event.clientY });
    });
    root.addEventListener('pointerenter', () => isModel() && this.#hover(row.node.entity));
    root.addEventListener('pointerleave', () => isModel() && this.#hover(null));
  }

  /** @param {Row} row @param {number} place */
  #drawRow(row, place) {
    const { store } = this.workplace;
    const { root, node } = row;
    const [own, many] = [node.entity !== 0 && !node.part, node.children.length > 0];
    const open = this.search.value.trim() !== '' || this.open.has(nameOf(node));
    const isHidden = own && store.isOn('hidden', node.entity);
    const isLocked = own && store.isOn('locked', node.entity);
    const selected = this.#isSelected(node);
    root.classList.toggle('active', node.key === this.active);
    root.classList.toggle('off', isHidden);
    root.classList.toggle('hover', own && store.hover === node.entity);
    root.style.top = `${place * this.height}px`;
    const rendered = JSON.stringify([node.label, node.note, node.icon, node.depth, many, open, selected, isHidden, isLocked]);
    if (rendered === row.rendered) return;
    row.rendered = rendered;
    root.style.paddingLeft = `${4 + INDENT * node.depth}px`;
    root.setAttribute('aria-level', String(node.depth + 1));
    root.setAttribute('aria-selected', String(selected));
    root.setAttribute('aria-label', node.note ? `${node.label}, ${node.note}` : node.label);
    if (many) root.setAttribute('aria-expanded', String(open));
    else root.removeAttribute('aria-expanded');
    fill(
      root,
      element(
        'span',
        {
          class: 'twist',
          'aria-hidden': 'true',
          on: {
            click: (/** @type {Event} */ event) => {
              event.stopPropagation();
              if (many) this.#unfold(node, !open);
            },
            dblclick: (/** @type {Event} */ event) => event.stopPropagation(),
          },
        },
        many && icon(open ? 'down' : 'right'),
      ),
      icon(node.icon),
      element('span', { class: 'tree-label', text: node.label }),
      node.note && element('span', { class: 'tree-note', text: node.note }),
      own && this.#switch(node, 'locked', isLocked, isLocked ? 'lock' : 'unlock', isLocked ? 'Unlock' : 'Lock'),
      own && this.#switch(node, 'hidden', isHidden, isHidden ? 'hidden' : 'eye', isHidden ? 'Show' : 'Hide'),
    );
  }

  /** @param {number | null} entity */
  #hover(entity) {
    const { store } = this.workplace;
    if (store.hover !== entity) store.setHover(entity);
  }

  /**
   * @param {TreeNode} node
   * @param {'hidden' | 'locked'} name
   * @param {boolean} on
   * @param {import('libgz/icons.js').IconName} image
   * @param {string} label
   */
  #switch(node, name, on, image, label) {
    return element(
      'button',
      {
        type: 'button',
        class: `small quiet${on ? ' on' : ''}`,
        tabindex: -1,
        title: label,
        'aria-label': `${label} ${node.label}`,
        'aria-pressed': String(on),
        on: {
          click: (/** @type {Event} */ event) => {
            event.stopPropagation();
            this.workplace.store.setSwitch(name, !on, node.entity);
          },
          dblclick: (/** @type {Event} */ event) => event.stopPropagation(),
        },
      },
      icon(image),
    );
  }

  /** @param {TreeNode} node */
  #choose(node) {
    this.active = node.key;
    const { store } = this.workplace;
    store.select(node.entity ? { entity: node.entity, ...(node.part ? { part: node.part } : {}) } : null);
    this.#drawRows();
    this.list.focus({ preventScroll: true });
  }

  /** @param {TreeNode} node @param {boolean} open */
  #unfold(node, open) {
    if (open) this.open.add(nameOf(node));
    else this.open.delete(nameOf(node));
    this.draw();
  }

  /** Show the row of what was selected elsewhere. */
  #reveal() {
    const { selection } = this.workplace.store;
    if (!selection) {
      this.#drawRows();
      return;
    }
    /** @param {TreeNode} node @param {TreeNode[]} above @returns {boolean} */
    const find = (node, above) => {
      if (this.#isSelected(node)) {
        for (const one of above) this.open.add(nameOf(one));
        this.active = node.key;
        return true;
      }
      return node.children.some((child) => find(child, [...above, node]));
    };
    this.roots.some((node) => find(node, []));
    this.draw();
    this.#scrollTo();
  }

  #scrollTo() {
    const place = this.shown.findIndex((node) => node.key === this.active);
    const [top, height] = [place * this.height, this.list.clientHeight];
    if (place < 0) return;
    if (top < this.list.scrollTop) this.list.scrollTop = top;
    else if (top + this.height > this.list.scrollTop + height) this.list.scrollTop = top + this.height - height;
    this.#drawRows();
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const place = this.shown.findIndex((node) => node.key === this.active);
    const node = this.shown[place];
    if (!node) return;
    /** @param {number} to */
    const go = (to) => {
      const next = this.shown[Math.max(Math.min(to, this.shown.length - 1), 0)];
      if (next) this.active = next.key;
      this.#scrollTo();
    };
    const many = node.children.length > 0;
    const open = this.open.has(nameOf(node));
    const { store } = this.workplace;
    if (event.key === 'ArrowDown') go(place + 1);
    else if (event.key === 'ArrowUp') go(place - 1);
    else if (event.key === 'Home') go(0);
    else if (event.key === 'End') go(this.shown.length - 1);
    else if (event.key === 'PageDown') go(place + 10);
    else if (event.key === 'PageUp') go(place - 10);
    else if (event.key === 'ArrowRight' && many) open ? go(place + 1) : this.#unfold(node, true);
    else if (event.key === 'ArrowLeft') {
      if (many && open) this.#unfold(node, false);
      else for (let i = place; i >= 0; i--) if ((this.shown[i]?.depth ?? 0) < node.depth) return void (go(i), event.preventDefault());
    } else if (event.key === 'Enter') this.#choose(node);
    else if (event.key === 'ContextMenu' || (event.key === 'F10' && event.shiftKey)) {
      const box = document.getElementById(`tree-${node.key}`)?.getBoundingClientRect();
      this.#choose(node);
      this.#menu(node, { x: (box?.left ?? 0) + 40, y: box?.bottom ?? 0 });
    } else if (event.key === 'e' && node.entity && event.shiftKey === false) {
      store.setSwitch('hidden', !store.isOn('hidden', node.entity), node.entity);
    } else if (event.key === 'l' && node.entity) {
      store.setSwitch('locked', !store.isOn('locked', node.entity), node.entity);
    } else return;
    event.preventDefault();
    event.stopPropagation();
  }

  /** @param {TreeNode} node @param {{ x: number, y: number }} point */
  #menu(node, point) {
    if (node.entity) openMenu(point, () => entityMenu(this.workplace, node.entity), node.label);
  }
}

/** By what it is known whether it is unfolded; a model may be named like the root. @param {TreeNode} node */
const nameOf = (node) => (node.entity ? `entity ${node.label}` : WORLD);

/**
 * What can be done with an entity.
 * @param {import('libgz/workplace.js').Workplace} workplace
 * @param {number} number
 * @returns {import('libgz/menu.js').Entry[]}
 */
export function entityMenu(workplace, number) {
  const { actions, store } = workplace;
  return [
    ...[actions.focus, actions.follow, actions.translate, actions.rotate, actions.duplicate, actions.align, actions.remove]
      .filter(isOffered)
      .map((action) => ({ ...entryOf(action), checked: undefined, danger: action === actions.remove })),
    { line: true },
    { label: 'Hidden', checked: store.isOn('hidden', number), action: () => store.setSwitch('hidden', !store.isOn('hidden', number), number) },
    { label: 'Locked', checked: store.isOn('locked', number), action: () => store.setSwitch('locked', !store.isOn('locked', number), number) },
    ...marks(workplace, number),
  ];
}

/**
 * The icon of an entity.
 * @param {import('libgz/store.js').Entity} entity
 * @returns {import('libgz/icons.js').IconName}
 */
export function imageOf(entity) {
  if (entity.kind === 'joints') return 'joint';
  if (entity.kind === 'light' || entity.bodies.some((body) => body.shapes.some((shape) => shape.kind === 'light'))) return 'light';
  if (entity.sensors.length && !entity.joints.length && entity.parent) return 'sensor';
  return entity.interfaces.length || entity.joints.length > 1 ? 'robot' : 'model';
}
