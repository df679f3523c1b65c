// @ts-check
/**
 * Tool: the button of an action.
 * @module
 */

import { iconOf, isOffered, isUsable, keyName, labelOf } from 'libgz/actions.js';
import { element, fill, show } from 'libgz/dom.js';
import { icon } from 'libgz/icons.js';

/** A button that says what its action does now, and whether it can. */
export class Tool {
  /**
   * @param {import('libgz/actions.js').Action} action
   * @param {string} [extra] classes
   */
  constructor(action, extra = '') {
    this.action = action;
    this.root = element('button', { type: 'button', class: `tool ${extra}`, on: { click: () => action.act() } });
    this.shown = '';
  }

  /** @param {boolean} [connected] */
  refresh(connected = true) {
    const { action, root } = this;
    const label = labelOf(action);
    const name = iconOf(action);
    show(root, isOffered(action));
    const disabled = !isUsable(action) || (!connected && Boolean(action.offered)); // others need no server
    if (root.disabled !== disabled) root.disabled = disabled;
    if (this.shown !== label + name) {
      this.shown = label + name;
      const key = action.keys?.[0];
      root.title = key ? `${label} (${keyName(key)})` : label;
      root.setAttribute('aria-label', label);
      fill(root, icon(name));
    }
    const on = action.on?.();
    if (on !== undefined) root.setAttribute('aria-pressed', String(on));
  }
}
