// @ts-check
/**
 * Inspector: what is known of the selected model, link, joint or sensor, and what can be changed there.
 * @module
 */

import { iconOf, isOffered, keyName, labelOf } from 'libgz/actions.js';
import { interfaceControls, jointControls, lightControls } from 'libgz/controls.js';
import { editors } from 'libgz/editors.js';
import { element, fill, newId, setText, show, throttled } from 'libgz/dom.js';
import { anglesOf, degrees, fixed, quaternionOf, radians, short } from 'libgz/format.js';
import { icon } from 'libgz/icons.js';
import { menuButton } from 'libgz/menu.js';
import { DRAGGED, keyOf, POSES, SPEEDS, unitOf } from 'libgz/series.js';
import { recall, remember } from 'libgz/settings.js';
import { entityMenu, imageOf } from 'libgz/tree.js';

/**
 * @typedef {import('libgz/store.js').Entity} Entity
 * @typedef {import('libgz/series.js').Series} Series
 *
 * @typedef {object} Field numbers of an interface
 * @property {string} of the interface
 * @property {string} label with `#` for the place in an array
 * @property {string} unit
 * @property {boolean} [whole] whether they are integers
 * @property {number} [count] of an array
 *
 * @typedef {object} Place what is scrolled to, and the field with the focus
 * @property {number} scrollTop
 * @property {number} scrollHeight
 * @property {string} name of the attribute that its row is known by, and
 * @property {string | null} [key] the value of it
 * @property {number} field place in the row
 */

const PERIOD = 120; // [ms] between two refreshes of numbers
const FEW = 4; // numbers of an array, each of which has its row
const MANY = 48; // of which one is chosen

/** The panel at the right. */
export class Inspector {
  /** @param {import('libgz/workplace.js').Workplace} workplace */
  constructor(workplace) {
    this.workplace = workplace;
    this.root = element('div', { class: 'panel-body inspector', id: 'inspector' });
    /** @type {(() => void)[]} that bring the numbers up to date */
    this.live = [];
    /** @type {Set<string>} */
    this.folded = new Set(recall('inspector.folded', /** @type {string[]} */ ([])));
    /** @type {Set<string>} groups of rows that are open */
    this.opened = new Set();
    this.shown = '';
    /** Done when the fields of the attributes are there. @type {Promise<void>} */
    this.edited = Promise.resolve();
    this.named = ''; // what is shown
    this.builds = 0; // how often it was made anew: what is asked for one is not for the next
    const { store } = workplace;
    const refresh = throttled(() => this.refresh(), PERIOD);
    store.addEventListener('state', refresh);
    store.addEventListener('series', refresh);
    store.addEventListener('selection', () => this.build());
    store.addEventListener('hello', () => this.#keepUp());
    store.addEventListener('scene', () => this.#keepUp());
    this.build();
  }

  /** What is selected, as a text that changes when the panel has to be made anew. */
  get #subject() {
    const { store } = this.workplace;
    const { selection, entities, control, abilities, scene } = store;
    const entity = selection && entities.get(selection.entity);
    if (!entity) return `world ${scene?.world} ${entities.size} ${control} ${[...abilities]}`;
    const parts = [entity.bodies.length, entity.joints.length, entity.sensors.length, entity.interfaces.length];
    return JSON.stringify([selection, entity.id, parts, control, [...abilities], store.connected]);
  }

  #keepUp() {
    if (this.#subject !== this.shown) this.build();
  }

  refresh() {
    if (this.root.offsetParent !== null) for (const update of this.live) update();
  }

  build() {
    const { store } = this.workplace;
    const place = this.#place();
    this.shown = this.#subject;
    this.builds += 1;
    this.edited = Promise.resolve();
    this.live = [];
    store.want('fields', this.workplace.plots?.fields() ?? []);
    const { selection } = store;
    const entity = selection && store.entities.get(selection.entity);
    if (!selection || !entity) this.#showWorld();
    else {
      const { part } = selection;
      if (part?.kind === 'body') this.#showBody(entity, part.name);
      else if (part?.kind === 'joint') this.#showJoint(entity, part.name);
      else if (part?.kind === 'sensor') this.#showSensor(entity, part.name);
      else this.#showModel(selection.entity, entity);
    }
    this.refresh();
    const named = `${entity?.id} ${selection?.part?.kind} ${selection?.part?.name}`;
    if (this.named === named) this.#return(place);
    else this.root.scrollTop = 0;
    this.named = named;
  }

  /** Where the user is. @returns {Place} */
  #place() {
    const { scrollTop, scrollHeight } = this.root;
    const field = document.activeElement;
    const row = field && this.root.contains(field) ? field.closest('[data-key], [data-series]') : null;
    const name = row?.hasAttribute('data-key') ? 'data-key' : 'data-series';
    return { scrollTop, scrollHeight, name, key: row?.getAttribute(name), field: row ? fieldsOf(row).findIndex((one) => one === field) : -1 };
  }

  /** Be there again when all has come that is asked for: what is shown was only built again. @param {Place} place */
  #return({ scrollTop, scrollHeight, name, key, field }) {
    const { builds } = this;
    const space = element('div');
    space.style.height = `${Math.max(scrollHeight - this.root.scrollHeight, 0)}px`;
    this.root.append(space);
    this.root.scrollTop = scrollTop;
    void this.edited.then(() => {
      space.remove();
      if (this.builds !== builds) return;
      this.root.scrollTop = scrollTop;
      const row = key && [...this.root.querySelectorAll(`[${name}]`)].find((one) => one.getAttribute(name) === key);
      if (row && document.activeElement === document.body) fieldsOf(row)[field]?.focus({ preventScroll: true });
    });
  }

  // Kinds ------------------------------------------------------------------------------------------------------------

  #showWorld() {
    const { store } = this.workplace;
    const { scene } = store;
    if (!scene) {
      fill(this.root, element('p', { class: 'hint', text: 'Waiting for the world …' }));
      return;
    }
    const counts = { models: 0, lights: 0, links: 0, joints: 0 };
    for (const entity of store.entities.values()) {
      if (imageOf(entity) === 'light') counts.lights += 1;
      else if (entity.kind === 'model') counts.models += 1;
      counts.links += entity.bodies.length;
      counts.joints += entity.joints.length;
    }
    const root = [
      this.#head('world', scene.world || 'World', scene.era === 'classic' ? 'SDF world' : 'worldfile'),
      this.#section('Run', [
        this.#value({ key: keyOf('sim', 'factor'), label: 'real-time factor', unit: '' }, 2),
        this.#value({ key: keyOf('sim', 'rate'), label: 'steps per second', unit: 'Hz' }, 0),
        this.#value({ key: keyOf('sim', 'steps'), label: 'steps', unit: '' }, 0),
        this.#value({ key: keyOf('sim', 'pauseTime'), label: 'paused time', unit: 's' }, 2),
      ]),
      this.#section('Contents', [
        this.#text('gravity', () => `${scene.gravity.map((part) => short(part)).join('  ')} m/s²`),
        ...Object.entries(counts).map(([name, count]) => this.#text(name, () => String(count))),
      ]),
    ];
    fill(this.root, ...root, element('p', { class: 'hint', text: 'Click a model in the view or in the tree to see more.' }));
    this.#addEditors('');
    this.#addProbes('');
  }

  /** @param {number} number @param {Entity} entity */
  #showModel(number, entity) {
    const { workplace } = this;
    const { store } = workplace;
    const key = (/** @type {string} */ name) => ({ key: keyOf('entity', entity.id, name), label: `${entity.id} ${name}`, unit: unitOf(name) });
    const able = (/** @type {string} */ verb) => store.control && store.abilities.has(verb);
    const moving = (store.bodies.get(entity.body)?.row ?? -1) >= 0;
    const controls = this.#section('Controls', [
      ...(able('light') ? lightControls(workplace, entity) : []),
      ...(able('joint') && store.scene?.era === 'classic' ? jointControls(workplace, entity) : []),
    ]);
    const details = this.#section('Properties', [
      entity.static && this.#text('static', () => 'yes'),
      store.entities.has(entity.parent) && this.#text('attached to', () => store.entities.get(entity.parent)?.id ?? ''),
      ...carried(store, number).map((name) => this.#link('carries', name, () => store.select({ entity: store.ids.get(name) ?? 0 }))),
    ]);
    const plugins = this.#section('Plugins', []);
    fill(
      this.root,
      this.#head(imageOf(entity), entity.id, entity.type || entity.kind, number),
      this.#pose(number, entity, key),
      moving && !entity.static && this.#section('Velocity', SPEEDS.map((name) => this.#value(key(name), 3, name))),
      controls,
      details,
      this.#section('Interfaces', entity.interfaces.map((one) => this.#interface(`${one.type}.${one.id}`, []))),
      this.#section('Sensors', entity.sensors.map((sensor) => this.#sensorRow(number, entity, sensor))),
      this.#section('Links', entity.bodies.map((body, i) => this.#partRow(number, 'body', body.name, body.name || `body ${i + 1}`))),
      this.#section('Joints', entity.joints.map((joint) => this.#partRow(number, 'joint', joint.name, joint.name || joint.kind, joint))),
      plugins,
    );
    const shown = this.shown;
    const current = () => this.shown === shown && controls.isConnected;
    void interfaceControls(workplace, entity).then((made) => {
      if (!current() || !made.length) return;
      this.#extend(controls, made);
    });
    if (store.abilities.has('describe'))
      void workplace.ask('describe', '-', { name: entity.id }).then((answer) => {
        if (!current() || !answer) return;
        const rows = [];
        if (answer.mass) rows.push(this.#text('mass', () => `${short(answer.mass)} kg`));
        this.#extend(details, rows, true);
        this.#extend(plugins, (answer.plugins ?? []).map((/** @type {[string, string]} */ [name, file]) => this.#text(name, () => file)));
        this.refresh();
      });
    this.#addEditors(entity.id);
    this.#addFields(entity);
    this.#addProbes(entity.id);
  }

  /** @param {Entity} entity @param {string} name */
  #showBody(entity, name) {
    const { store } = this.workplace;
    const body = entity.bodies.find((one) => one.name === name);
    if (!body) return this.#showWorld();
    const key = (/** @type {string} */ value) => ({ key: keyOf('body', entity.id, name, value), label: `${entity.id}/${name} ${value}`, unit: unitOf(value) });
    const shapes = body.shapes.filter((shape) => shape.kind !== 'frustum' && shape.kind !== 'ray');
    const row = body.row;
    fill(
      this.root,
      this.#head('link', name || 'body', `link of ${entity.id}`, undefined, () => store.select({ entity: entity.number })),
      this.#shownPose(key),
      row >= 0 && !body.static && this.#section('Velocity', SPEEDS.map((value) => this.#value(key(value), 3, value))),
      this.#section('Shapes', shapes.map((shape) => this.#text(shape.name || shape.kind, () => shapeText(shape)))),
      this.#section('Sensors', entity.sensors.filter((sensor) => sensor.body === body.id).map((sensor) => this.#sensorRow(entity.number, entity, sensor))),
    );
    this.#addEditors(entity.id, name, 'link');
  }

  /** @param {Entity} entity @param {string} name */
  #showJoint(entity, name) {
    const { store } = this.workplace;
    const joint = entity.joints.find((one) => one.name === name);
    if (!joint) return this.#showWorld();
    const slides = joint.kind === 'prismatic' || joint.kind === 'slider';
    const [unit, rate] = slides ? ['m', 'm/s'] : ['rad', 'rad/s'];
    const count = Math.max(joint.axes?.length ?? 0, joint.limits?.length ?? 0, joint.row >= 0 ? 1 : 0);
    /** @param {number} number */
    const bodyName = (number) => {
      const found = store.bodies.get(number);
      return found ? `${store.entities.get(found.entity)?.id ?? ''}/${found.body.name || 'body'}` : 'world';
    };
    const axes = [];
    for (let axis = 0; axis < Math.min(count, 2) && joint.row >= 0; axis++) {
      const extra = count > 1 ? ` ${axis + 1}` : '';
      const label = `${entity.id}/${name}${extra}`;
      axes.push(this.#value({ key: keyOf('joint', entity.id, name, axis, 'position'), label, unit }, 4, `${slides ? 'position' : 'angle'}${extra}`));
      axes.push(this.#value({ key: keyOf('joint', entity.id, name, axis, 'rate'), label: `${label} rate`, unit: rate }, 4, `rate${extra}`));
    }
    const limit = (/** @type {number | null | undefined} */ side, /** @type {string} */ free) => (side === null || side === undefined || Math.abs(side) > 1e9 ? free : short(side));
    const able = store.control && store.abilities.has('joint') && store.scene?.era === 'classic';
    fill(
      this.root,
      this.#head('joint', name || joint.kind, `${joint.kind} joint of ${entity.id}`, undefined, () => store.select({ entity: entity.number })),
      this.#section('State', axes),
      this.#section('Controls', able ? jointControls(this.workplace, entity, name) : []),
      this.#section('Properties', [
        this.#text(store.scene?.era === 'classic' ? 'parent' : 'body 1', () => bodyName(joint.bodies[0] ?? 0)),
        this.#text(store.scene?.era === 'classic' ? 'child' : 'body 2', () => bodyName(joint.bodies[1] ?? 0)),
        ...(joint.limits ?? []).map((pair) => this.#text('limits', () => `${limit(pair?.[0], '−∞')} to ${limit(pair?.[1], '∞')} ${unit}`)),
        ...(joint.axes ?? []).map((axis) => this.#text('axis', () => axis.map((part) => fixed(part, 3)).join('  '))),
      ]),
    );
    this.#addEditors(entity.id, name, 'joint');
  }

  /** @param {Entity} entity @param {string} name */
  #showSensor(entity, name) {
    const { store } = this.workplace;
    const sensor = entity.sensors.find((one) => (one.name ?? '') === name);
    if (!sensor) return this.#showWorld();
    const body = store.bodies.get(sensor.body)?.body.name || 'body';
    fill(
      this.root,
      this.#head('sensor', name || sensor.kind, `${sensor.kind} sensor of ${entity.id}`, undefined, () => store.select({ entity: entity.number })),
      this.#section('Properties', [
        this.#text('link', () => body),
        sensor.rate !== undefined && this.#text('rate', () => `${short(sensor.rate ?? 0)} Hz`),
        sensor.topic ? this.#text('topic', () => String(sensor.topic)) : null,
        sensor.fov !== undefined && this.#text('field of view', () => `${fixed(degrees(sensor.fov ?? 0), 1)}°`),
        sensor.near !== undefined && this.#text('near, far', () => `${short(sensor.near ?? 0)}, ${short(sensor.far ?? Infinity)} m`),
        ...(Array.isArray(sensor.rays) ? sensor.rays : []).map((rays) =>
          this.#text('rays', () => `${rays.horizontal?.samples ?? '?'} × ${rays.vertical?.samples ?? 1}, ${short(rays.min)} to ${short(rays.max ?? Infinity)} m`),
        ),
      ]),
      this.#section('Image', this.#imageButtons(entity, sensor)),
    );
    this.#addEditors(entity.id, name, 'sensor');
  }

  // Parts of the panel -----------------------------------------------------------------------------------------------

  /**
   * @param {import('libgz/icons.js').IconName} image
   * @param {string} name
   * @param {string} note
   * @param {number} [entity] whose actions it has
   * @param {() => void} [back]
   */
  #head(image, name, note, entity, back) {
    const { workplace } = this;
    const { actions, store } = workplace;
    const tools = [];
    if (entity !== undefined) {
      for (const action of [actions.focus, actions.follow, actions.remove].filter(isOffered)) {
        const button = element(
          'button',
          { type: 'button', class: 'tool', 'aria-label': labelOf(action), title: `${labelOf(action)} (${keyName(action.keys?.[0] ?? '')})`, on: { click: () => action.act() } },
          icon(iconOf(action)),
        );
        tools.push(button);
        if (action.on) this.live.push(() => button.setAttribute('aria-pressed', String(action.on?.() ?? false)));
      }
      tools.push(
        menuButton(
          element('button', { type: 'button', class: 'tool', 'aria-label': `More for ${name}`, title: 'More' }, icon('more')),
          name,
          () => entityMenu(workplace, entity),
        ),
      );
    } else if (back)
      tools.push(element('button', { type: 'button', class: 'tool', 'aria-label': 'To the model', title: 'To the model', on: { click: back } }, icon('up')));
    const watching =
      entity !== undefined && store.connected && !store.control
        ? element('p', { class: 'hint', text: workplace.whyWatching })
        : null;
    return element(
      'div',
      { class: 'inspector-head' },
      element('div', { class: 'inspector-title' }, icon(image), element('div', {}, element('h2', { text: name, title: name }), element('small', { text: note })), element('div', { class: 'tools' }, tools)),
      watching,
    );
  }

  /**
   * @param {string} title
   * @param {import('libgz/dom.js').Child[]} rows
   * @param {boolean} [closed] whether it is always folded at first
   */
  #section(title, rows, closed = false) {
    const some = rows.filter(Boolean);
    const body = element('div', { class: 'section-body' }, some);
    const root = element(
      'details',
      { class: 'section', 'data-section': title },
      element('summary', {}, icon('right'), title),
      body,
    );
    root.open = !closed && !this.folded.has(title);
    root.addEventListener('toggle', () => {
      this.#wantFields();
      if (closed) return;
      if (root.open) this.folded.delete(title);
      else this.folded.add(title);
      remember('inspector.folded', [...this.folded]);
    });
    show(root, some.length > 0);
    return root;
  }

  /**
   * @param {HTMLElement} section
   * @param {Node[]} rows
   * @param {boolean} [first]
   */
  #extend(section, rows, first = false) {
    const body = section.querySelector('.section-body');
    if (first) body?.prepend(...rows);
    else body?.append(...rows);
    show(section, Boolean(body?.children.length));
  }

  /**
   * A number that can be dragged into a plot.
   * @param {Series} series
   * @param {number} digits
   * @param {string} [name] in the row
   * @param {string} [unit] if it is shown in another one
   * @param {(value: number) => number} [shown] the value in that unit
   */
  #value(series, digits, name = series.label, unit = series.unit, shown = (value) => value) {
    const figure = element('output', { class: 'figure' });
    this.live.push(() => setText(figure, fixed(shown(this.workplace.sampler.read(series.key)), digits)));
    return plottable(this.workplace, series, element('span', { class: 'name', text: name, title: name }), figure, unit);
  }

  /**
   * A pose that is only shown, with its angles in degrees as where poses are edited.
   * @param {(name: string) => Series} key
   */
  #shownPose(key) {
    const rows = POSES.map((name, place) =>
      place < 3 ? this.#value(key(name), 3, name) : this.#value(key(name), 1, name, 'deg', degrees),
    );
    return this.#section('Pose', rows);
  }

  /** @param {string} name @param {() => string} value */
  #text(name, value) {
    const text = element('span', { class: 'text-value' });
    const update = () => setText(text, value());
    update();
    this.live.push(update);
    return element('div', { class: 'property' }, element('span', { class: 'name', text: name, title: name }), text);
  }

  /** @param {string} name @param {string} label @param {() => void} act */
  #link(name, label, act) {
    return element(
      'div',
      { class: 'property' },
      element('span', { class: 'name', text: name }),
      element('button', { type: 'button', class: 'link', text: label, on: { click: act } }),
    );
  }

  /**
   * @param {number} number
   * @param {Entity} entity
   * @param {(name: string) => Series} key
   */
  #pose(number, entity, key) {
    const { workplace } = this;
    const { store } = workplace;
    const editable = store.control && store.abilities.has('move') && entity.kind !== 'joints';
    if (!editable) return this.#shownPose(key);
    /** @type {HTMLInputElement[]} */
    const inputs = [];
    const present = () => {
      const pose = store.entityPose(number);
      if (!pose) return null;
      const turns = anglesOf([pose[3] ?? 1, pose[4] ?? 0, pose[5] ?? 0, pose[6] ?? 0]).map(degrees);
      return [pose[0] ?? 0, pose[1] ?? 0, pose[2] ?? 0, ...turns];
    };
    const commit = (/** @type {number} */ place) => {
      const values = present();
      const value = Number(inputs[place]?.value.replace(',', '.'));
      if (!values || !inputs[place]) return;
      if (!Number.isFinite(value) || inputs[place].value.trim() === '') {
        inputs[place].setAttribute('aria-invalid', 'true');
        return;
      }
      inputs[place].removeAttribute('aria-invalid');
      values[place] = value;
      const [x = 0, y = 0, z = 0, roll = 0, pitch = 0, yaw = 0] = values;
      const turn = quaternionOf(radians(roll), radians(pitch), radians(yaw));
      void workplace.ask('move', '-', { name: entity.id, pose: [x, y, z, ...turn] });
    };
    const rows = POSES.map((name, place) => {
      const id = newId('pose');
      const digits = place < 3 ? 3 : 1;
      const input = element('input', {
        id,
        type: 'text',
        inputmode: 'decimal',
        autocomplete: 'off',
        class: 'figure',
        on: {
          change: () => commit(place),
          keydown: (/** @type {KeyboardEvent} */ event) => {
            event.stopPropagation();
            if (event.key === 'Enter') input.blur();
            if (event.key === 'Escape') {
              input.value = fixed(present()?.[place] ?? NaN, digits);
              input.blur();
            }
            const way = { ArrowUp: 1, ArrowDown: -1 }[event.key];
            if (!way) return;
            event.preventDefault();
            input.value = fixed(Number(input.value) + way * (place < 3 ? (event.shiftKey ? 1 : 0.1) : event.shiftKey ? 45 : 5), digits);
            commit(place);
          },
          focus: () => input.select(),
        },
      });
      inputs.push(input);
      this.live.push(() => {
        if (document.activeElement === input) return;
        const text = fixed(present()?.[place] ?? NaN, digits);
        if (input.value !== text) input.value = text;
      });
      return plottable(
        workplace,
        key(name),
        element('label', { for: id, class: 'name', text: name }),
        input,
        place < 3 ? 'm' : 'deg',
      );
    });
    return this.#section('Pose', rows);
  }

  /**
   * @param {number} number
   * @param {import('libgz/store.js').Part['kind']} kind
   * @param {string} name
   * @param {string} label
   * @param {{ row: number, kind: string } | null} [joint] whose value is shown beside
   */
  #partRow(number, kind, name, label, joint = null) {
    const { store } = this.workplace;
    const button = element(
      'button',
      { type: 'button', class: 'row-button', on: { click: () => store.select({ entity: number, part: { kind, name } }) } },
      icon(kind === 'joint' ? 'joint' : 'link'),
      element('span', { text: label, title: label }),
    );
    if (joint && joint.row >= 0) {
      const figure = element('output', { class: 'figure' });
      const unit = joint.kind === 'prismatic' || joint.kind === 'slider' ? 'm' : 'rad';
      this.live.push(() => setText(figure, `${fixed(store.state?.joints[4 * joint.row] ?? NaN, 3)} ${unit}`));
      button.append(figure);
    }
    return button;
  }

  /**
   * @param {number} number
   * @param {Entity} entity
   * @param {import('libgz/store.js').Sensor} sensor
   */
  #sensorRow(number, entity, sensor) {
    const { store } = this.workplace;
    return element(
      'div',
      { class: 'row' },
      element(
        'button',
        { type: 'button', class: 'row-button', on: { click: () => store.select({ entity: number, part: { kind: 'sensor', name: sensor.name ?? '' } }) } },
        icon('sensor'),
        element('span', { text: sensor.name || sensor.kind }),
        sensor.name && element('small', { text: sensor.kind }),
      ),
      this.#imageButtons(entity, sensor),
    );
  }

  /**
   * @param {Entity} entity
   * @param {import('libgz/store.js').Sensor} sensor
   */
  #imageButtons(entity, sensor) {
    const { images } = this.workplace;
    return images.ofSensor(entity, sensor).map(({ name, label }) =>
      element(
        'button',
        { type: 'button', class: 'text', 'aria-label': `Image of ${label}`, on: { click: () => images.toggle(name, label) } },
        icon('image'),
        'Image',
      ),
    );
  }

  /**
   * An interface, whose fields are made when it is opened.
   * @param {string} name
   * @param {Field[]} fields
   */
  #interface(name, fields) {
    if (!fields.length) return element('div', { class: 'property', 'data-interface': name }, element('span', { class: 'whole', text: name, title: name }));
    return this.#group(name, '', () => fields.flatMap((field) => this.#fieldRows(field)), { 'data-interface': name });
  }

  /**
   * Rows below a name, which are made when it is opened. Which ones are open is remembered.
   * @param {string} name
   * @param {string} note
   * @param {() => Node[]} rows
   * @param {Record<string, string>} [marks] of the element
   */
  #group(name, note, rows, marks = {}) {
    const place = element('div', {});
    const root = element('details', { class: 'group', ...marks }, element('summary', {}, icon('right'), element('span', { text: name, title: name }), element('small', { text: note })), place);
    const open = () => {
      if (root.open && !place.childElementCount) fill(place, ...rows());
      if (root.open) this.opened.add(name);
      else this.opened.delete(name);
      this.#wantFields();
      this.refresh();
    };
    root.addEventListener('toggle', open);
    if (this.opened.has(name)) {
      root.open = true;
      open();
    }
    return root;
  }

  /** @param {Field} field @returns {HTMLElement[]} */
  #fieldRows({ of, label, unit, whole, count }) {
    const digits = whole ? 0 : 3;
    const series = (/** @type {number} */ place) => {
      const name = label.replace('#', String(place));
      return { key: keyOf('field', `${of}.${name}`), label: name, unit };
    };
    if (count === undefined) return [this.#value(series(0), digits)];
    const places = Array.from({ length: count }, (_, place) => place);
    if (count <= FEW) return places.map((place) => this.#value(series(place), digits));
    if (count <= MANY) return [this.#group(label.replace('#', ''), String(count), () => places.map((place) => this.#value(series(place), digits)))];
    return [this.#chosen(series, label, count, digits)];
  }

  /**
   * One number of a large array, which the user chooses.
   * @param {(place: number) => Series} series
   * @param {string} label
   * @param {number} count
   * @param {number} digits
   */
  #chosen(series, label, count, digits) {
    const input = element('input', { type: 'number', class: 'figure place', min: '0', max: String(count - 1), value: String(count >> 1), 'aria-label': `Place in ${label.replace('[#]', '')}` });
    const holder = element('div', {});
    const choose = () => {
      const place = Math.min(Math.max(Math.round(Number(input.value) || 0), 0), count - 1);
      const row = this.#value(series(place), digits);
      row.querySelector('.name')?.replaceWith(element('span', { class: 'name' }, label.split('#')[0], input, label.split('#')[1]));
      fill(holder, row);
      this.#wantFields();
      this.refresh();
    };
    input.addEventListener('change', () => {
      choose();
      input.focus();
    });
    input.addEventListener('keydown', (event) => event.stopPropagation());
    choose();
    return holder;
  }

  /** The keys of the fields whose values are shown. */
  fields() {
    const rows = [...this.root.querySelectorAll('[data-series]')].filter((row) => !row.closest('details:not([open])'));
    const keys = rows.map((row) => JSON.parse(row.getAttribute('data-series') ?? '[]'));
    return keys.filter(([kind]) => kind === 'field').map(([, key]) => String(key));
  }

  #wantFields() {
    this.workplace.store.want('fields', [...new Set([...(this.workplace.plots?.fields() ?? []), ...this.fields()])]);
  }

  /** The numbers of topics and plugins, which are read where they are plotted. @param {string} name of the entity; empty for the world */
  #addProbes(name) {
    const { workplace, builds } = this;
    if (!workplace.store.control || !workplace.store.abilities.has('probes')) return;
    void workplace.ask('probes', '-', { name }).then((/** @type {{ key: string, label: string, group: string }[] | undefined} */ answer) => {
      if (this.builds !== builds || !Array.isArray(answer)) return;
      /** @type {Map<string, Series[]>} */
      const groups = new Map();
      for (const { key, label, group } of answer) {
        const some = groups.get(group) ?? [];
        groups.set(group, some);
        some.push({ key: keyOf('field', key), label: `${group.replace(/^\w+ /, '')} ${label}`, unit: '' });
      }
      for (const [group, some] of groups) {
        // There may be many: the rows are made when the section is opened.
        const place = element('div', {});
        const section = this.#section(group, [place], true);
        section.addEventListener('toggle', () => {
          if (place.childElementCount) return;
          fill(place, some.map((series) => this.#value(series, 3, series.label.split(' ').at(-1))));
          this.#wantFields();
          this.refresh();
        });
        this.root.append(section);
      }
    });
  }

  /** The values of the interfaces' fields. @param {Entity} entity */
  #addFields(entity) {
    const { workplace } = this;
    const { store } = workplace;
    if (!store.abilities.has('fields')) return;
    const { builds } = this;
    void workplace.ask('fields', entity.id).then((/** @type {Field[] | undefined} */ answer) => {
      if (this.builds !== builds || !Array.isArray(answer) || !answer.length) return;
      for (const row of this.root.querySelectorAll('[data-interface]')) {
        const name = row.getAttribute('data-interface') ?? '';
        row.replaceWith(this.#interface(name, answer.filter(({ of }) => of === name)));
      }
      this.#wantFields();
      this.refresh();
    });
  }

  /**
   * Fields for all that the server can change of a thing.
   * @param {string} name of the entity; empty for the world
   * @param {string} [part]
   * @param {string} [kind] of the part
   */
  #addEditors(name, part, kind) {
    const { builds } = this;
    this.edited = editors(this.workplace, { name, part, kind }).then((groups) => {
      if (this.builds !== builds) return;
      const sections = groups.map(({ title, rows }) => this.#section(title, rows));
      const after = this.root.querySelector('[data-section=Properties]');
      if (after && part === undefined) after.after(...sections);
      else this.root.append(...sections);
    });
  }
}

/**
 * A row of a value that can be plotted: by dragging it, or by its button.
 *
 * @param {import('libgz/workplace.js').Workplace} workplace
 * @param {Series} series
 * @param {HTMLElement} name
 * @param {HTMLElement} value
 * @param {string} [unit] if it is shown in another one
 */
function plottable(workplace, series, name, value, unit = series.unit) {
  const typed = value instanceof HTMLInputElement; // its text is selected by dragging
  name.draggable = typed;
  return element(
    'div',
    {
      class: 'property plottable',
      draggable: !typed,
      'data-series': series.key,
      on: {
        dragstart: (/** @type {DragEvent} */ event) => {
          event.dataTransfer?.setData(DRAGGED, JSON.stringify(series));
          event.dataTransfer?.setData('text/plain', series.label);
          if (event.dataTransfer) event.dataTransfer.effectAllowed = 'copy';
          workplace.layout.openDock('plots');
        },
      },
    },
    name,
    value,
    element('span', { class: 'unit', text: unit }),
    element(
      'button',
      {
        type: 'button',
        class: 'small quiet',
        draggable: true,
        title: 'Plot',
        'aria-label': `Plot ${series.label}`,
        on: {
          click: () => {
            workplace.layout.openDock('plots');
            workplace.plots.add(series);
          },
        },
      },
      icon('plot'),
    ),
  );
}

/** @param {Element} row @returns {HTMLElement[]} */
const fieldsOf = (row) => [...row.querySelectorAll('input, select')].filter((one) => one instanceof HTMLElement);

/**
 * The ids of what an entity carries.
 * @param {import('libgz/store.js').Store} store
 * @param {number} number
 */
function carried(store, number) {
  return [...store.entities.values()].filter((entity) => entity.parent === number).map((entity) => entity.id);
}

/** @param {import('libgz/store.js').Shape} shape */
function shapeText(shape) {
  const sizes = Array.isArray(shape.size)
    ? shape.size.map((part) => short(part)).join(' × ')
    : shape.length !== undefined
      ? `r ${short(shape.radius ?? 0)}, ${short(shape.length)}`
      : shape.radius !== undefined
        ? `r ${short(shape.radius)}`
        : '';
  const notes = [!shape.visible && 'not visible', !shape.collides && 'does not collide'].filter(Boolean).join(', ');
  return [shape.kind, sizes && `${sizes} m`, notes].filter(Boolean).join(' · ');
}
