// @ts-check
/**
 * Menus that open at a button or where the pointer is.
 * @module
 */

import { element, fill } from 'libgz/dom.js';
import { icon } from 'libgz/icons.js';

/**
 * An entry of a menu. With `checked` it is a check box and leaves the menu open; `choice` makes it one of several.
 *
 * @typedef {object} Entry
 * @property {string} [label]
 * @property {import('libgz/icons.js').IconName} [icon]
 * @property {boolean} [checked]
 * @property {boolean} [choice]
 * @property {boolean} [disabled]
 * @property {boolean} [danger]
 * @property {string} [hint] such as the key that does the same
 * @property {string} [heading] a heading instead of an entry
 * @property {boolean} [line] a line instead of an entry
 * @property {HTMLElement} [content] any control instead of an entry
 * @property {() => void} [action]
 */

/** @type {{ close: (back: boolean) => void, owner: Element | null } | null} */
let open = null;

/**
 * Open a menu.
 *
 * @param {Element | { x: number, y: number }} place the button that it belongs to, or a point of the window [px]
 * @param {() => Entry[]} entries called again after each click, as check boxes change
 * @param {string} label for screen readers
 */
export function openMenu(place, entries, label) {
  const owner = place instanceof Element ? place : null;
  const again = open !== null && owner !== null && open.owner === owner;
  open?.close(false);
  if (again) return;
  const former = document.activeElement;
  const list = element('div', { class: 'menu', role: 'menu', 'aria-label': label, tabindex: -1 });

  /** @param {boolean} back whether the focus returns */
  const close = (back) => {
    list.remove();
    open = null;
    owner?.setAttribute('aria-expanded', 'false');
    document.removeEventListener('pointerdown', outside, true);
    window.removeEventListener('resize', gone);
    if (back && former instanceof HTMLElement) former.focus();
  };
  const gone = () => close(false);
  /** @param {PointerEvent} event */
  const outside = (event) => {
    const target = /** @type {Node} */ (event.target);
    if (!list.contains(target) && !owner?.contains(target)) close(false);
  };
  const items = () =>
    /** @type {HTMLElement[]} */ ([...list.querySelectorAll('[role^=menuitem]:not(:disabled), input, select')]);

  const draw = () => {
    const place = items().indexOf(/** @type {HTMLElement} */ (document.activeElement));
    fill(list, ...entries().map((entry) => row(entry, draw, close)));
    if (place >= 0) items()[place]?.focus();
  };
  list.addEventListener('keydown', (event) => {
    const all = items();
    const here = all.indexOf(/** @type {HTMLElement} */ (document.activeElement));
    /** @type {Record<string, number>} */
    const places = { ArrowDown: here + 1, ArrowUp: here < 0 ? all.length - 1 : here - 1, Home: 0, End: all.length - 1 };
    const target = /** @type {HTMLElement} */ (event.target);
    if (event.key === 'Escape' || event.key === 'Tab') close(true);
    else if (event.key in places && target.tagName !== 'INPUT' && target.tagName !== 'SELECT')
      all[((places[event.key] ?? 0) + all.length) % all.length]?.focus();
    else if (target.tagName === 'BUTTON' && event.key.length === 1 && event.key !== ' ') {
      const letter = event.key.toLowerCase();
      const order = [...all.slice(here + 1), ...all.slice(0, here + 1)];
      order.find((item) => item.textContent?.trim().toLowerCase().startsWith(letter))?.focus();
    } else {
      event.stopPropagation();
      return;
    }
    event.preventDefault();
    event.stopPropagation();
  });
  draw();
  document.body.append(list);
  put(list, place);
  open = { close, owner };
  owner?.setAttribute('aria-expanded', 'true');
  document.addEventListener('pointerdown', outside, true);
  window.addEventListener('resize', gone);
  (items()[0] ?? list).focus({ preventScroll: true });
}

/**
 * @param {Entry} entry
 * @param {() => void} draw
 * @param {(back: boolean) => void} close
 */
function row(entry, draw, close) {
  if (entry.line) return element('hr', { role: 'separator' });
  if (entry.heading) return element('div', { class: 'menu-heading', role: 'presentation', text: entry.heading });
  if (entry.content) return entry.content;
  const checks = entry.checked !== undefined;
  const role = checks ? (entry.choice ? 'menuitemradio' : 'menuitemcheckbox') : 'menuitem';
  return element(
    'button',
    {
      type: 'button',
      role,
      'aria-checked': checks ? String(entry.checked) : null,
      class: entry.danger ? 'danger' : null,
      disabled: entry.disabled,
      tabindex: -1,
      on: {
        click: () => {
          if (!checks || entry.choice) close(true);
          entry.action?.();
          if (checks && !entry.choice) draw();
        },
      },
    },
    element('span', { class: 'menu-mark' }, checks ? entry.checked && icon('check') : entry.icon && icon(entry.icon)),
    element('span', { class: 'menu-label', text: entry.label }),
    entry.hint && element('kbd', { text: entry.hint, 'aria-hidden': 'true' }),
  );
}

/**
 * Place a menu below its button, or where there is space.
 * @param {HTMLElement} list
 * @param {Element | { x: number, y: number }} place
 */
function put(list, place) {
  const box =
    place instanceof Element
      ? place.getBoundingClientRect()
      : { left: place.x, right: place.x, top: place.y, bottom: place.y, width: 0 };
  const [width, height] = [list.offsetWidth, list.offsetHeight];
  const left = Math.min(box.left, window.innerWidth - width - 8);
  const below = box.bottom + 4;
  const top = below + height <= window.innerHeight - 8 ? below : Math.max(box.top - height - 4, 8);
  list.style.left = `${Math.max(left, 8)}px`;
  list.style.top = `${top}px`;
}

/**
 * A button that opens a menu.
 *
 * @param {HTMLElement} button
 * @param {string} label
 * @param {() => Entry[]} entries
 */
export function menuButton(button, label, entries) {
  button.setAttribute('aria-haspopup', 'menu');
  button.setAttribute('aria-expanded', 'false');
  button.addEventListener('click', () => openMenu(button, entries, label));
  return button;
}
