// @ts-check
/**
 * Keys of the whole page.
 * @module
 */

import { isUsable } from 'libgz/actions.js';

/** @typedef {import('libgz/actions.js').Action} Action */

const PRESSED = 'button, summary, a, [role=tab], input[type=checkbox]'; // by Space and Enter

/** Listens to keys, but not while a user types. */
export class Keys {
  /** @param {import('libgz/workplace.js').Workplace} workplace */
  constructor(workplace) {
    this.workplace = workplace;
    /** @type {Map<string, Action>} */
    this.table = new Map();
    for (const action of Object.values(workplace.actions)) for (const key of action.keys ?? []) this.table.set(key, action);
    // What the pointer has pressed does not keep the focus: the next key is meant for the world.
    window.addEventListener('click', (event) => event.detail > 0 && release(event.target), true);
    window.addEventListener('keydown', (event) => this.#down(event));
    window.addEventListener('keyup', (event) => this.workplace.drive.release(event.key));
  }

  /** @param {KeyboardEvent} event */
  #down(event) {
    const { drive, store } = this.workplace;
    const target = /** @type {HTMLElement} */ (event.target);
    if (document.querySelector('dialog[open]') || isTyping(target)) return;
    const command = event.ctrlKey || event.metaKey;
    // A control with the focus answers to these itself.
    if ((event.key === ' ' || event.key === 'Enter') && target.closest(PRESSED)) return;
    const onPad = target === drive.pad;
    if (!command && !event.altKey && (!event.shiftKey || event.key.length === 1) && drive.press(event.key, onPad)) {
      event.preventDefault();
      return;
    }
    const action = this.table.get(nameOf(event));
    if (action) {
      if (event.repeat && !action.hold) return;
      event.preventDefault();
      if (isUsable(action)) action.act();
    }
    if (store.control && !command && event.key.length === 1) store.pressKey(event.key.charCodeAt(0));
  }
}

/** @param {EventTarget | null} target */
function release(target) {
  const control = target instanceof Element ? target.closest(PRESSED) : null;
  if (control instanceof HTMLElement && !control.closest('.menu, dialog')) control.blur();
}

/** @param {HTMLElement} target */
const isTyping = (target) =>
  target.isContentEditable ||
  target.tagName === 'TEXTAREA' ||
  target.tagName === 'SELECT' ||
  (target instanceof HTMLInputElement && !['checkbox', 'radio', 'button', 'color', 'range'].includes(target.type));

/**
 * The name of a key with its modifiers, as in the table of actions.
 * @param {KeyboardEvent} event
 */
function nameOf(event) {
  const letter = /^[a-z]$/i.test(event.key);
  const key = event.key === ' ' ? 'Space' : letter ? event.key.toUpperCase() : event.key;
  const parts = [];
  if (event.ctrlKey || event.metaKey) parts.push('Ctrl');
  if (event.altKey) parts.push('Alt');
  if (event.shiftKey && (letter || key.length > 1)) parts.push('Shift');
  return [...parts, key].join('+');
}
