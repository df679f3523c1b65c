// @ts-check
/**
 * Windows that float over the view: moved by their title, resized by their corner.
 * @module
 */

import { element, onDrag } from 'libgz/dom.js';
import { icon } from 'libgz/icons.js';
import { recall, remember } from 'libgz/settings.js';

let highest = 1;

/** A window over the view. */
export class FloatingWindow {
  /**
   * @param {HTMLElement} area in which it stays
   * @param {object} choice
   * @param {string} choice.name under which its place is remembered
   * @param {string} choice.title
   * @param {HTMLElement} choice.content
   * @param {number} [choice.width] [px]
   * @param {(() => void) | null} [choice.closed] called when the user closes it; null: it cannot be closed
   * @param {boolean} [choice.resizable]
   */
  constructor(area, { name, title, content, width = 240, closed = null, resizable = false }) {
    this.area = area;
    this.name = name;
    const fold = element(
      'button',
      { type: 'button', class: 'small', 'aria-label': `Fold ${title}`, 'aria-expanded': 'true', on: { click: () => this.fold() } },
      icon('down'),
    );
    this.foldButton = fold;
    const bar = element(
      'div',
      { class: 'window-title' },
      fold,
      element('span', { class: 'window-name', text: title, title }),
      closed &&
        element(
          'button',
          { type: 'button', class: 'small', 'aria-label': `Close ${title}`, on: { click: () => { this.remove(); closed(); } } },
          icon('close'),
        ),
    );
    this.root = element('section', { class: 'window', 'aria-label': title }, bar, element('div', { class: 'window-content' }, content));
    this.root.style.width = `${recall(`window.${name}.width`, width)}px`;
    area.append(this.root);
    const [x = 12, y = 12] = recall(`window.${name}`, freePlace(area, this.root));
    this.put(x, y);
    this.front();
    this.root.addEventListener('pointerdown', () => this.front());
    onDrag(bar, (event) => this.#drag(event));
    if (resizable) this.#addCorner();
  }

  /** Show it before all others. */
  front() {
    this.root.style.zIndex = String((highest += 1));
  }

  fold() {
    const folded = this.root.classList.toggle('folded');
    this.foldButton.setAttribute('aria-expanded', String(!folded));
  }

  remove() {
    this.root.remove();
  }

  /**
   * Place it, inside its area.
   * @param {number} x
   * @param {number} y
   */
  put(x, y) {
    const most = { x: this.area.clientWidth - 80, y: this.area.clientHeight - 32 };
    this.x = Math.max(Math.min(x, most.x), 0);
    this.y = Math.max(Math.min(y, most.y), 0);
    this.root.style.left = `${this.x}px`;
    this.root.style.top = `${this.y}px`;
  }

  /** Move it by its bar. @param {PointerEvent} event */
  #drag(event) {
    if (event.button !== 0 || /** @type {Element} */ (event.target).closest('button')) return undefined;
    const [x, y] = [event.clientX - (this.x ?? 0), event.clientY - (this.y ?? 0)];
    return {
      move: (/** @type {PointerEvent} */ moved) => this.put(moved.clientX - x, moved.clientY - y),
      end: () => remember(`window.${this.name}`, [this.x, this.y]),
    };
  }

  #addCorner() {
    const corner = element('div', { class: 'window-corner', 'aria-hidden': 'true' });
    this.root.append(corner);
    onDrag(corner, (event) => {
      const width = this.root.offsetWidth - event.clientX;
      return {
        move: (moved) => {
          const most = this.area.clientWidth - (this.x ?? 0);
          this.root.style.width = `${Math.max(Math.min(width + moved.clientX, most), 140)}px`;
        },
        end: () => remember(`window.${this.name}.width`, this.root.offsetWidth),
      };
    });
  }
}

/**
 * A place below the other windows, or beside them.
 * @param {HTMLElement} area
 * @param {HTMLElement} own
 */
function freePlace(area, own) {
  const others = [...area.querySelectorAll('.window')].filter((one) => one !== own);
  const boxes = others.map((one) => /** @type {HTMLElement} */ (one));
  for (let x = 12; x < area.clientWidth - 160; x += 272) {
    const column = boxes.filter((box) => Math.abs(box.offsetLeft - x) < 260);
    const y = Math.max(...column.map((box) => box.offsetTop + Math.max(box.offsetHeight, 180) + 8), 12);
    if (y < area.clientHeight - 120) return [x, y];
  }
  return [12, 12];
}
