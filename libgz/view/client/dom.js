// @ts-check
/**
 * Elements of the page, made without markup: a text from a world is always a text.
 * @module
 */

/**
 * @typedef {Node | string | number | null | undefined | false} Child
 * @typedef {Record<string, unknown>} Attributes
 */

/**
 * A new element.
 *
 * Attributes are set as such, but for `class`; `on`, a record of listeners; `text`, its text; and what is a property of
 * controls (`value`, `checked`, `disabled`, `hidden`, `htmlFor`). An attribute that is null, undefined or false is left out.
 *
 * @template {keyof HTMLElementTagNameMap} Tag
 * @param {Tag} tag
 * @param {Attributes} [attributes]
 * @param {...(Child | Child[])} children
 * @returns {HTMLElementTagNameMap[Tag]}
 */
export function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) continue;
    if (name === 'class') made.className = String(value);
    else if (name === 'text') made.textContent = String(value);
    else if (name === 'on') {
      for (const [event, listener] of Object.entries(/** @type {Record<string, EventListener>} */ (value)))
        made.addEventListener(event, listener);
    } else if (PROPERTIES.has(name)) /** @type {any} */ (made)[name] = value;
    else made.setAttribute(name, value === true ? '' : String(value));
  }
  append(made, children);
  return made;
}

const PROPERTIES = new Set(['value', 'checked', 'disabled', 'hidden', 'htmlFor', 'draggable', 'indeterminate']);

/**
 * Append children; what is no node becomes a text.
 * @param {Element} parent
 * @param {(Child | Child[])[]} children
 */
export function append(parent, children) {
  for (const child of children.flat()) {
    if (child === null || child === undefined || child === false) continue;
    parent.append(child instanceof Node ? child : String(child));
  }
}

/**
 * Replace all children.
 * @param {Element} parent
 * @param {...(Child | Child[])} children
 */
export function fill(parent, ...children) {
  parent.replaceChildren();
  append(parent, children);
}

/**
 * Set a text if it is another one, so that pages at rest stay at rest.
 * @param {Node} node
 * @param {string} text
 */
export function setText(node, text) {
  if (node.textContent !== text) node.textContent = text;
}

/**
 * Show or hide an element.
 * @param {HTMLElement} node
 * @param {boolean} shown
 */
export function show(node, shown) {
  if (node.hidden === shown) node.hidden = !shown;
}

/**
 * Follow a pointer from where it is pressed on an element until it is released.
 * @param {HTMLElement} target
 * @param {(event: PointerEvent) => { move: (event: PointerEvent) => void, end?: () => void } | undefined} begin undefined
 *   for what is not to be followed
 */
export function onDrag(target, begin) {
  target.addEventListener('pointerdown', (event) => {
    const drag = begin(event);
    if (!drag) return;
    event.preventDefault();
    target.setPointerCapture(event.pointerId);
    target.addEventListener('pointermove', drag.move);
    const end = () => {
      target.removeEventListener('pointermove', drag.move);
      drag.end?.();
    };
    target.addEventListener('lostpointercapture', end, { once: true });
  });
}

let numbers = 0;

/**
 * An id that no other element of the page has, for labels.
 * @param {string} name
 */
export const newId = (name) => `${name}-${(numbers += 1)}`;

/**
 * Call a function at most once in a period, and once more after the last call.
 * @param {() => void} work
 * @param {number} period [ms]
 */
export function throttled(work, period) {
  let last = -Infinity;
  let timer = 0;
  return () => {
    const wait = last + period - performance.now();
    if (wait <= 0) {
      last = performance.now();
      work();
    } else if (!timer) {
      timer = window.setTimeout(() => {
        timer = 0;
        last = performance.now();
        work();
      }, wait);
    }
  };
}
