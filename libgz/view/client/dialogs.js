// @ts-check
/**
 * Dialogs: insert, save, delete, control, keys.
 * @module
 */

import { isOffered, keyName, labelOf } from 'libgz/actions.js';
import { element, fill, setText, show } from 'libgz/dom.js';
import { capitalized } from 'libgz/format.js';
import { icon } from 'libgz/icons.js';
import { isGround } from 'libgz/store.js';

/** @typedef {{ name: string, title: string, group: string, about: string }} Model */

const LARGEST = 24 << 20; // [bytes] of a file that is dropped
const DESCRIPTIONS = ['sdf', 'urdf', 'world', 'xml'];
const MESHES = ['dae', 'stl', 'obj', 'glb'];
const DRIVING = [
  ['W A S D', 'Drive forward, left, back, right'],
  ['Arrows', 'Drive, if a robot is chosen; else move the camera, or step a paused world'],
  ['Page up, Page down', 'Drive up and down'],
];

/** The page's dialogs. */
export class Dialogs {
  /** @param {import('libgz/workplace.js').Workplace} workplace */
  constructor(workplace) {
    this.workplace = workplace;
    /** @type {Model[] | null} */
    this.catalogue = null;
    workplace.store.addEventListener('hello', () => (this.catalogue = null));
    this.#acceptFiles();
  }

  /**
   * Open a dialog.
   * @param {string} title
   * @param {import('libgz/dom.js').Child[]} content
   * @param {HTMLElement[]} [buttons]
   * @param {string} [extra] classes
   */
  #open(title, content, buttons = [], extra = '') {
    const close = element('button', { type: 'button', class: 'tool', 'aria-label': 'Close', title: 'Close (Esc)' }, icon('close'));
    const dialog = element(
      'dialog',
      { class: extra, 'aria-label': title },
      element('div', { class: 'dialog-head' }, element('h2', { text: title }), close),
      element('div', { class: 'dialog-body' }, content),
      buttons.length > 0 && element('div', { class: 'dialog-foot' }, buttons),
    );
    close.addEventListener('click', () => dialog.close());
    dialog.addEventListener('close', () => dialog.remove());
    dialog.addEventListener('pointerdown', (event) => {
      if (event.target === dialog) dialog.close();
    });
    dialog.addEventListener('keydown', (event) => event.stopPropagation());
    document.body.append(dialog);
    dialog.showModal();
    return dialog;
  }

  /** @param {string} label @param {string} [extra] */
  #button(label, extra = '') {
    return element('button', { type: 'button', class: `text ${extra}`, text: label });
  }

  // Keys -------------------------------------------------------------------------------------------------------------

  help() {
    const groups = /** @type {Map<string, [string, string][]>} */ (new Map());
    for (const action of Object.values(this.workplace.actions)) {
      if (!action.keys?.length || !isOffered(action)) continue;
      const rows = groups.get(action.group) ?? [];
      groups.set(action.group, rows);
      rows.push([action.keys.map(keyName).join(', '), labelOf(action)]);
    }
    if (this.workplace.store.control) groups.set('Drive', DRIVING.map(([keys = '', text = '']) => [keys, text]));
    groups.set('Mouse', [
      ['Drag', 'Turn the view'],
      ['Right drag', 'Shift the view'],
      ['Wheel', 'Zoom'],
      ['Click', 'Select'],
      ['Double click', 'Fit a model into the view'],
    ]);
    this.#open(
      'Keys',
      [...groups].map(([title, rows]) =>
        element(
          'section',
          { class: 'keys' },
          element('h3', { text: title }),
          element('dl', {}, rows.map(([keys, text]) => element('div', {}, element('dt', {}, keys.split(', ').map((key) => element('kbd', { text: key }))), element('dd', { text })))),
        ),
      ),
      [],
      'keys-dialog',
    );
  }

  // Insert -----------------------------------------------------------------------------------------------------------

  async insert() {
    const search = element('input', { type: 'search', placeholder: 'Search models', 'aria-label': 'Search models', autofocus: true });
    const grid = element('div', { class: 'catalogue', role: 'listbox', 'aria-label': 'Models' }, element('p', { class: 'hint', text: 'Loading the catalogue …' }));
    const dialog = this.#open(
      'Insert a model',
      [element('div', { class: 'search' }, icon('search'), search), grid],
      [element('p', { class: 'hint', text: 'A model is put on free ground near the middle of the view. Files can be dropped on the view.' })],
      'insert-dialog',
    );
    this.catalogue ??= models((await this.workplace.ask('catalogue', 'full')) ?? []);
    const all = this.catalogue;
    const draw = () => {
      const wanted = search.value.trim().toLowerCase();
      const words = wanted.split(/\s+/);
      const shown = all.filter((one) => {
        const text = `${one.title} ${one.name} ${one.group} ${one.about}`.toLowerCase();
        return words.every((word) => text.includes(word));
      });
      /** @type {import('libgz/dom.js').Child[]} */
      const cards = [];
      let group = '';
      for (const one of shown) {
        if (one.group && one.group !== group) cards.push(element('h3', { text: capitalized(one.group) }));
        group = one.group;
        cards.push(
          element(
            'button',
            {
              type: 'button',
              class: 'card',
              role: 'option',
              'aria-selected': 'false',
              title: one.about || one.name,
              'aria-label': one.title,
              on: {
                click: () => {
                  dialog.close();
                  void this.place(one.name);
                },
              },
            },
            this.#portrait(one.name),
            element('span', { class: 'card-title', text: one.title }),
          ),
        );
      }
      fill(grid, cards.length ? cards : element('p', { class: 'hint', text: 'No model matches.' }));
    };
    search.addEventListener('input', draw);
    search.addEventListener('keydown', (event) => {
      const first = grid.querySelector('button');
      if (event.key === 'Enter') first?.click();
      else if (event.key === 'ArrowDown') first?.focus();
      else return;
      event.preventDefault();
    });
    grid.addEventListener('keydown', (event) => {
      const way = { ArrowRight: 1, ArrowLeft: -1, ArrowDown: 1, ArrowUp: -1 }[event.key];
      const cards = [...grid.querySelectorAll('button')];
      const here = cards.indexOf(/** @type {HTMLButtonElement} */ (document.activeElement));
      if (!way || here < 0) return;
      event.preventDefault();
      if (here + way < 0) search.focus();
      else cards[here + way]?.focus();
    });
    draw();
    search.focus();
  }

  /** The portrait of a model of the catalogue; an icon until it has come, and where there is none. @param {string} name */
  #portrait(name) {
    const frame = element('span', { class: 'card-portrait' }, icon('model'));
    if (!this.workplace.store.abilities.has('portrait')) return frame;
    const image = element('img', { src: `portraits/${encodeURIComponent(name)}`, alt: '', loading: 'lazy', width: 256, height: 192 });
    image.addEventListener('load', () => frame.classList.add('shown'));
    image.addEventListener('error', () => image.remove());
    frame.append(image);
    return frame;
  }

  /**
   * Insert a model of the catalogue and select it.
   * @param {string} model
   */
  async place(model) {
    const [x = 0, y = 0, z = 0] = this.workplace.stage.place() ?? [];
    this.workplace.selectNamed(await this.workplace.ask('insert', '-', { model, pose: [x, y, z, 1, 0, 0, 0] }));
  }

  /** Copy what is selected, and select the copy. */
  async duplicate() {
    const { store, ask } = this.workplace;
    const entity = store.selection && store.entities.get(store.selection.entity);
    if (entity) this.workplace.selectNamed(await ask('duplicate', '-', { name: entity.id }));
  }

  /** Move what is selected until it is aligned with another model along an axis. */
  align() {
    const { store, ask, toasts } = this.workplace;
    const entity = store.selection && store.entities.get(store.selection.entity);
    if (!entity) return;
    const here = store.entityPose(entity.number) ?? [];
    /** @param {import('libgz/store.js').Entity} one */
    const distance = (one) => Math.hypot(...Array.from(store.entityPose(one.number) ?? []).slice(0, 3).map((part, i) => part - (here[i] ?? 0)));
    const others = [...store.entities.values()]
      .filter((one) => one !== entity && one.kind === 'model' && !one.parent && !isGround(one))
      .sort((one, other) => distance(one) - distance(other));
    if (!others.length) {
      toasts.add('There is no other model to align with.', 'info');
      return;
    }
    /** @param {string} label @param {string[][]} options */
    const list = (label, options) => {
      const select = element('select', { 'aria-label': label }, options.map(([value, text]) => element('option', { value, text })));
      return { select, row: element('label', { class: 'property' }, element('span', { class: 'name', text: label }), select) };
    };
    const other = list('With', others.map((one) => [one.id, one.id]));
    const axis = list('Along', ['x', 'y', 'z'].map((name) => [name, name]));
    const to = list('At', [['low', 'its lower side'], ['center', 'its middle'], ['high', 'its upper side']]);
    const yes = this.#button('Align', 'primary');
    const no = this.#button('Cancel');
    const dialog = this.#open(`Align ${entity.id}`, [other.row, axis.row, to.row], [no, yes]);
    no.addEventListener('click', () => dialog.close());
    yes.addEventListener('click', () => {
      dialog.close();
      void ask('align', axis.select.value, { names: [other.select.value, entity.id], to: to.select.value });
    });
  }

  /** Files that are dropped on the view. */
  #acceptFiles() {
    const { store, stage, layout } = this.workplace;
    const area = layout.stage;
    /** @param {DragEvent} event */
    const fits = (event) => store.control && store.abilities.has('insert') && event.dataTransfer?.types.includes('Files');
    document.addEventListener('dragover', (event) => {
      if (!event.dataTransfer?.types.includes('Files')) return;
      event.preventDefault(); // else the browser would open the file instead of the page
      if (fits(event)) area.classList.add('dropping');
    });
    document.addEventListener('dragleave', (event) => {
      if (!event.relatedTarget) area.classList.remove('dropping');
    });
    document.addEventListener('drop', (event) => {
      area.classList.remove('dropping');
      if (!event.dataTransfer?.files.length) return;
      event.preventDefault();
      if (!fits(event)) return;
      const place = stage.place(event.clientX, event.clientY) ?? [0, 0, 0];
      void this.#insertFiles([...event.dataTransfer.files], place);
    });
  }

  /** @param {File[]} files @param {ArrayLike<number>} place */
  async #insertFiles(files, place) {
    for (const file of files) await this.#insertFile(file, place);
  }

  /** @param {File} file @param {ArrayLike<number>} place */
  async #insertFile(file, place) {
    const { toasts, ask, store } = this.workplace;
    const ending = file.name.split('.').at(-1)?.toLowerCase() ?? '';
    const pose = [place[0] ?? 0, place[1] ?? 0, place[2] ?? 0, 1, 0, 0, 0];
    if (file.size > LARGEST) toasts.add(`${file.name} is larger than ${LARGEST >> 20} MiB.`);
    else if (DESCRIPTIONS.includes(ending)) this.workplace.selectNamed(await ask('insert', '-', { model: file.name, text: await file.text(), pose }));
    else if (MESHES.includes(ending) && store.abilities.has('mesh')) {
      const bytes = new Uint8Array(await file.arrayBuffer());
      let text = '';
      for (let i = 0; i < bytes.length; i += 8192) text += String.fromCharCode(...bytes.subarray(i, i + 8192));
      this.workplace.selectNamed(await ask('mesh', '-', { file: file.name, data: btoa(text), pose }));
    } else {
      const known = store.abilities.has('mesh') ? [...DESCRIPTIONS, ...MESHES] : DESCRIPTIONS;
      toasts.add(`${file.name} cannot be inserted; allowed are ${known.join(', ')}.`);
    }
  }

  // Save and delete --------------------------------------------------------------------------------------------------

  async save() {
    const { workplace } = this;
    const { store } = workplace;
    const save = this.#button('Save', 'primary');
    const cancel = this.#button('Cancel');
    const compares = store.abilities.has('diff');
    const text = compares
      ? 'What changed is written to the world’s file, with comments and order as they are; the file as it is now is kept as NAME.bak.'
      : 'The world is written to a file of the server.';
    const diff = element('div', { class: 'diff', role: 'region', 'aria-label': 'Changes', tabindex: 0, hidden: !compares, text: 'Comparing with the file …' });
    const dialog = this.#open('Save the world?', [element('p', { text }), diff], [cancel, save], 'save-dialog');
    cancel.addEventListener('click', () => dialog.close());
    save.addEventListener('click', async () => {
      dialog.close();
      const path = await workplace.ask('write');
      if (path !== undefined) workplace.toasts.add(`Saved: ${path || 'the world’s file'}`, 'info');
    });
    save.focus();
    if (!compares) return;
    const changes = await workplace.ask('diff');
    show(diff, Boolean(changes));
    if (!changes) return;
    const lines = String(changes.text ?? changes);
    if (lines.trim()) fill(diff, lines.split('\n').map(diffLine));
    else setText(diff, 'Nothing has changed.');
  }

  /** Delete what is selected; without undo, a dialog asks first. */
  remove() {
    const { store, ask, toasts } = this.workplace;
    const entity = store.selection && store.entities.get(store.selection.entity);
    if (!entity) return;
    const act = async () => {
      store.select(null);
      const done = await ask('delete', '-', { name: entity.id });
      if (done !== undefined && store.abilities.has('undo')) toasts.add(`Deleted ${entity.id}. Ctrl + Z brings it back.`, 'info');
    };
    if (store.abilities.has('undo')) {
      void act();
      return;
    }
    const yes = this.#button('Delete', 'danger');
    const no = this.#button('Cancel');
    const dialog = this.#open(`Delete ${entity.id}?`, [element('p', { text: 'The model is removed from the running world. A reset brings it back if it is in the world’s file.' })], [no, yes]);
    no.addEventListener('click', () => dialog.close());
    yes.addEventListener('click', () => {
      dialog.close();
      void act();
    });
    yes.focus();
  }

  // Control ----------------------------------------------------------------------------------------------------------

  /** Who controls, and how that changes. */
  control() {
    const { store, ask } = this.workplace;
    const { controllers } = store;
    const close = this.#button('Close');
    const buttons = [close];
    let text = `${this.workplace.whyWatching} You can also select, plot and follow.`;
    /** @param {string} label @param {string} verb @param {string} [extra] */
    const offer = (label, verb, extra = '') => {
      const button = this.#button(label, extra);
      button.addEventListener('click', () => {
        dialog.close();
        void ask('control', verb);
      });
      buttons.push(button);
    };
    if (store.control) {
      text = store.asked ? `${store.asked} asks for control.` : 'You control this world; other pages watch.';
      if (controllers?.other || store.asked) offer('Hand over', 'give', 'primary');
      if (store.asked) offer('Keep control', 'keep');
    } else if (controllers?.canAsk) offer(controllers.other ? 'Ask for control' : 'Take control', controllers.other ? 'ask' : 'take', 'primary');
    const dialog = this.#open('Control', [element('p', { text })], buttons);
    close.addEventListener('click', () => dialog.close());
  }
}

/**
 * The catalogue, as the server gives it.
 * @param {unknown[]} list
 * @returns {Model[]}
 */
function models(list) {
  return list.map((entry) => {
    const { name, title, group, about } = typeof entry === 'string' ? { name: entry } : /** @type {any} */ (entry);
    const text = String(name);
    return { name: text, title: String(title ?? text.replace(/^model:\/\//, '')), group: String(group ?? ''), about: String(about ?? '') };
  });
}

/** @param {string} line of a unified diff */
function diffLine(line) {
  const heads = /^(@@|---|\+\+\+) /.test(line);
  const kind = heads ? 'place' : line.startsWith('+') ? 'added' : line.startsWith('-') ? 'removed' : '';
  return element('div', { class: kind, text: line || ' ' });
}
