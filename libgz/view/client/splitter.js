// @ts-check
/**
 * Splitter: the edge between two panels, moved by a pointer or by the arrow keys.
 * @module
 */

import { element, onDrag } from 'libgz/dom.js';
import { recall, remember } from 'libgz/settings.js';

/**
 * A splitter that sets a size, which is remembered, as the variable `--NAME` of an element's style.
 *
 * @param {HTMLElement} root
 * @param {object} choice
 * @param {string} choice.name
 * @param {string} choice.label for screen readers
 * @param {'left' | 'right' | 'bottom'} choice.side of the window at which the panel is
 * @param {number} choice.size at first [px]
 * @param {number} choice.least [px]
 * @param {() => number} choice.most [px]
 * @returns {HTMLElement}
 */
export function splitter(root, { name, label, side, size, least, most }) {
  const upright = side !== 'bottom';
  let now = recall(`size.${name}`, size);
  const edge = element('div', {
    class: `splitter ${upright ? 'upright' : 'level'}`,
    role: 'separator',
    tabindex: 0,
    'aria-label': label,
    'aria-orientation': upright ? 'vertical' : 'horizontal',
    'aria-valuemin': least,
  });
  /** @param {number} wanted */
  const set = (wanted) => {
    now = Math.round(Math.max(Math.min(wanted, most()), least));
    root.style.setProperty(`--${name}`, `${now}px`);
    edge.setAttribute('aria-valuenow', String(now));
    edge.setAttribute('aria-valuemax', String(Math.round(most())));
  };
  set(now);
  window.addEventListener('resize', () => set(recall(`size.${name}`, size)));
  onDrag(edge, (event) => {
    if (event.button !== 0) return undefined;
    const [start, at] = [now, upright ? event.clientX : event.clientY];
    return {
      move: (moved) => {
        const way = (upright ? moved.clientX : moved.clientY) - at;
        set(start + (side === 'left' ? way : -way));
      },
      end: () => remember(`size.${name}`, now),
    };
  });
  edge.addEventListener('dblclick', () => {
    set(size);
    remember(`size.${name}`, now);
  });
  edge.addEventListener('keydown', (event) => {
    const steps = { left: ['ArrowLeft', 'ArrowRight'], right: ['ArrowRight', 'ArrowLeft'], bottom: ['ArrowDown', 'ArrowUp'] };
    const way = steps[side].indexOf(event.key);
    if (way < 0) return;
    event.preventDefault();
    event.stopPropagation();
    set(now + (way ? 16 : -16));
    remember(`size.${name}`, now);
  });
  return edge;
}
