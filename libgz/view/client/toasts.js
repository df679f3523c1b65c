// @ts-check
/**
 * Toasts: short messages that vanish by themselves.
 * @module
 */

import { element } from 'libgz/dom.js';
import { icon } from 'libgz/icons.js';

const MOST = 4;
const LASTS = { info: 5000, warning: 8000, error: 10000 }; // [ms]
const LONGEST = 500;

/** The corner of the page where messages appear. */
export class Toasts {
  constructor() {
    this.root = element('div', { class: 'toasts', role: 'status', 'aria-live': 'polite' });
  }

  /**
   * Show a message. The same one again only lasts longer.
   * @param {string} text
   * @param {'info' | 'warning' | 'error'} [level]
   */
  add(text, level = 'error') {
    const shown = text.slice(0, LONGEST);
    for (const old of [...this.root.children]) if (old.getAttribute('data-text') === shown) old.remove();
    while (this.root.children.length >= MOST) this.root.firstElementChild?.remove();
    const toast = element(
      'div',
      { class: `toast ${level}`, 'data-text': shown },
      icon(level),
      element('span', { text: shown }),
      element(
        'button',
        { type: 'button', class: 'small', 'aria-label': 'Dismiss', on: { click: () => toast.remove() } },
        icon('close'),
      ),
    );
    this.root.append(toast);
    window.setTimeout(() => toast.remove(), LASTS[level]);
  }
}
