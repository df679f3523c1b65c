// @ts-check
/**
 * Editors: fields for attributes that the server declares, with their types, units and limits.
 * @module
 */

import { element, newId } from 'libgz/dom.js';
import { capitalized, hexOf, partsOf, short as shortest, shownUnit } from 'libgz/format.js';

const PLACES = new Set(['xyz', 'rpy', 'pose']);
const NOTHING = 1e-11; // what is smaller is shown as zero

/**
 * @typedef {object} Attribute
 * @property {string} key
 * @property {string} label
 * @property {string} [group]
 * @property {'number' | 'integer' | 'vector' | 'bool' | 'choice' | 'text' | 'color' | 'include'} type `include`: the file
 *   that the others are in
 * @property {any} value
 * @property {string} [unit]
 * @property {number} [low]
 * @property {number} [high]
 * @property {string[]} [options]
 * @property {string} [help]
 * @property {boolean} [above] whether `low` itself is not allowed
 * @property {string} [reason] why it cannot be changed
 * @property {string} [file] in which it is, and
 * @property {number} [line] where there; 0: it is not given
 *
 * @typedef {object} Subject what the attributes are of
 * @property {string} name of the entity; empty for the world
 * @property {string} [part]
 * @property {string} [kind] of the part
 */

/**
 * The groups of fields of a thing; none where the server has no such ability.
 *
 * @param {import('libgz/workplace.js').Workplace} workplace
 * @param {Subject} subject
 * @returns {Promise<{ title: string, rows: HTMLElement[] }[]>}
 */
export async function editors(workplace, subject) {
  const { store } = workplace;
  if (!store.control || !store.abilities.has('attributes')) return [];
  /** @type {Attribute[]} */
  let attributes;
  try {
    attributes = (await store.ask('attributes', '-', subject)) ?? [];
  } catch (error) { // it can be looked at all the same
    const reason = error instanceof Error ? error.message : String(error);
    return [{ title: 'Attributes', rows: [element('p', { class: 'note', text: `They cannot be edited here: ${reason}` })] }];
  }
  /** @type {Map<string, HTMLElement[]>} */
  const groups = new Map();
  for (const attribute of attributes) {
    if (isPlace(workplace, subject, attribute)) continue;
    const title = capitalized(attribute.group || 'attributes');
    const rows = groups.get(title) ?? [];
    groups.set(title, rows);
    rows.push(...(attribute.type === 'include' ? included(workplace, subject, attribute) : [row(workplace, subject, attribute)]));
  }
  return [...groups].map(([title, rows]) => ({ title, rows }));
}

/**
 * Whether an attribute is the place of a model in the world, which the section of its pose shows as it is now.
 *
 * @param {import('libgz/workplace.js').Workplace} workplace
 * @param {Subject} subject
 * @param {Attribute} attribute
 */
function isPlace({ store }, { name, part }, { key }) {
  if (!name || part || !PLACES.has(key) || !store.abilities.has('move')) return false;
  return !store.entities.has(store.entities.get(store.ids.get(name) ?? 0)?.parent ?? 0);
}

/**
 * Where a model is from that the file of the world includes, and the offer to write it into that file.
 *
 * @param {import('libgz/workplace.js').Workplace} workplace
 * @param {Subject} subject
 * @param {Attribute} attribute
 */
function included(workplace, subject, { value }) {
  const { store } = workplace;
  const copy = async () => {
    const answer = await workplace.ask('embed', '-', { name: subject.name });
    if (answer) workplace.inspector.build();
  };
  return [
    element('p', { class: 'note' }, 'From ', element('code', { text: String(value) }), '. The world sets its name, its pose, and whether it is static; all else is in that file.'),
    store.abilities.has('embed') && element('button', { type: 'button', class: 'text', text: 'Copy into this world', title: 'Write the model into the file of the world in the place of the include, so that all of it can be edited here', on: { click: copy } }),
    element('p', { class: 'note' }, 'Or edit the file itself: ', element('code', { text: `libgz edit ${value}` })),
  ].filter((made) => made instanceof HTMLElement);
}

/**
 * @param {import('libgz/workplace.js').Workplace} workplace
 * @param {Subject} subject
 * @param {Attribute} attribute
 */
function row(workplace, subject, attribute) {
  const id = newId('attribute');
  const { label, unit, low, high, above, help, file, line } = attribute;
  const editable = workplace.store.abilities.has('edit') && !attribute.reason;
  const limits = [low !== undefined && `${above ? 'more than' : 'at least'} ${short(low)}`, high !== undefined && `at most ${short(high)}`].filter(Boolean).join(', ');
  /** @param {unknown} value */
  const send = async (value) => {
    const answer = await workplace.ask('edit', '-', { ...subject, key: attribute.key, value });
    if (answer === undefined) write(attribute.value);
    else {
      attribute.value = answer?.value ?? value;
      if (answer?.name && !subject.part && answer.name !== subject.name) workplace.selectNamed([answer.name]);
    }
  };
  const { field, read, write } = fieldOf(id, attribute);
  for (const control of field.matches('input, select') ? [field] : field.querySelectorAll('input')) {
    if (!editable) control.setAttribute('disabled', '');
    control.addEventListener('change', () => {
      const value = read();
      const wrong = value === undefined || outside(value, low, high, above);
      if (wrong) control.setAttribute('aria-invalid', 'true');
      else {
        control.removeAttribute('aria-invalid');
        void send(value);
      }
    });
    control.addEventListener('keydown', (event) => event.stopPropagation());
  }
  return element(
    'div',
    { class: attribute.type === 'vector' && field.children.length > 2 ? 'property tall' : 'property', 'data-key': attribute.key, title: [help, limits, attribute.reason, line && `${file ?? ''}:${line}`].filter(Boolean).join(' — ') || null },
    element('label', { for: id, class: 'name', text: label }),
    field,
    element('span', { class: 'unit', text: shownUnit(unit ?? '') }),
  );
}

/** A number, without what is only rounding. @param {number} value */
const short = (value) => shortest(Math.abs(value) < NOTHING ? 0 : value);

/** @param {unknown} value @param {number} [low] @param {number} [high] @param {boolean} [above] */
const outside = (value, low = -Infinity, high = Infinity, above = false) =>
  [value].flat().some((part) => typeof part === 'number' && (part < low || part > high || (above && part === low)));

/**
 * @param {string} id
 * @param {Attribute} attribute
 * @returns {{ field: HTMLElement, read: () => unknown, write: (value: any) => void }} `read` gives undefined if it is no
 *   value of the type
 */
function fieldOf(id, { type, value, options, label }) {
  /** @param {string} text @param {boolean} [whole] */
  const number = (text, whole) => {
    const read = Number(text.replace(',', '.'));
    return text.trim() !== '' && Number.isFinite(read) && (!whole || Number.isInteger(read)) ? read : undefined;
  };
  if (type === 'bool') {
    const box = element('input', { id, type: 'checkbox', checked: Boolean(value) });
    return { field: box, read: () => box.checked, write: (shown) => (box.checked = Boolean(shown)) };
  }
  if (type === 'choice') {
    const list = element('select', { id }, (options ?? []).map((option) => element('option', { value: option, text: option })));
    list.value = String(value);
    return { field: list, read: () => list.value, write: (shown) => (list.value = String(shown)) };
  }
  if (type === 'color') {
    const parts = Array.isArray(value) ? value.map(Number) : [1, 1, 1];
    const box = element('input', { id, type: 'color', value: hexOf(parts) });
    return {
      field: box,
      write: (shown) => (box.value = hexOf(shown)),
      read: () => [...partsOf(box.value), ...parts.slice(3)],
    };
  }
  if (type === 'vector') {
    const boxes = (Array.isArray(value) ? value : []).map((part, i) =>
      element('input', { id: i ? null : id, type: 'text', inputmode: 'decimal', class: 'figure', value: short(Number(part)), 'aria-label': `${label} ${i + 1}` }),
    );
    return {
      field: element('div', { class: 'vector' }, boxes),
      write: (shown) => boxes.forEach((box, i) => (box.value = short(Number(shown[i])))),
      read: () => {
        const parts = boxes.map((box) => number(box.value));
        return parts.includes(undefined) ? undefined : parts;
      },
    };
  }
  const isText = type === 'text';
  const box = element('input', {
    id,
    type: 'text',
    inputmode: isText ? null : 'decimal',
    class: isText ? 'text-value' : 'figure',
    value: isText ? String(value ?? '') : short(Number(value)),
  });
  return {
    field: box,
    read: () => (isText ? box.value : number(box.value, type === 'integer')),
    write: (shown) => (box.value = isText ? String(shown ?? '') : short(Number(shown))),
  };
}
