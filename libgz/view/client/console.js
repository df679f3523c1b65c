// @ts-check
/**
 * Console: warnings and errors of worlds, models and plugins as they happen.
 * @module
 */

import { element, fill, setText, show, throttled } from 'libgz/dom.js';
import { clock } from 'libgz/format.js';
import { icon } from 'libgz/icons.js';

/** @typedef {import('libgz/store.js').Message} Message */

const LEVELS = /** @type {const} */ (['error', 'warning', 'info']);
const LABELS = { error: 'Errors', warning: 'Warnings', info: 'Notes' };
const MOST_ROWS = 500;
const PERIOD = 150; // [ms]

/** The list of messages. */
export class Console {
  /** @param {import('libgz/workplace.js').Workplace} workplace */
  constructor(workplace) {
    this.workplace = workplace;
    const { store } = workplace;
    /** @type {Set<string>} */
    this.levels = new Set(LEVELS);
    this.seen = -1;
    this.cleared = -1;
    this.rendered = '';
    this.badge = element('span', { class: 'badge', hidden: true });
    this.filter = element('input', { type: 'search', placeholder: 'Filter', 'aria-label': 'Filter messages', on: { input: () => this.draw() } });
    this.rows = element('div', { class: 'messages', role: 'log', 'aria-label': 'Messages', tabindex: 0 });
    this.toggles = LEVELS.map((level) => {
      const count = element('span', { text: '0' });
      const button = element(
        'button',
        {
          type: 'button',
          class: `text level ${level}`,
          'aria-pressed': 'true',
          'aria-label': LABELS[level],
          title: LABELS[level],
          on: {
            click: () => {
              if (!this.levels.delete(level)) this.levels.add(level);
              button.setAttribute('aria-pressed', String(this.levels.has(level)));
              this.draw();
            },
          },
        },
        icon(level),
        count,
      );
      return { level, button, count };
    });
    this.root = element(
      'div',
      { class: 'panel-body console-panel' },
      element(
        'div',
        { class: 'bar' },
        element('div', { class: 'search' }, icon('search'), this.filter),
        this.toggles.map(({ button }) => button),
        element(
          'button',
          { type: 'button', class: 'tool', title: 'Clear', 'aria-label': 'Clear the console', on: { click: () => this.#clear() } },
          icon('trash'),
        ),
      ),
      this.rows,
    );
    store.addEventListener('messages', throttled(() => this.draw(), PERIOD));
    store.addEventListener('layout', () => this.draw());
    store.want('console', ['*']);
    this.draw();
  }

  #clear() {
    this.cleared = this.workplace.store.messages.at(-1)?.number ?? -1;
    this.draw();
  }

  draw() {
    const messages = this.workplace.store.messages.filter((message) => message.number > this.cleared);
    const last = messages.at(-1)?.number ?? -1;
    for (const { level, count } of this.toggles)
      setText(count, String(messages.filter((message) => message.level === level).length));
    if (this.root.offsetParent !== null) this.seen = Math.max(this.seen, last);
    const unseen = messages.filter((message) => message.number > this.seen && message.level !== 'info');
    setText(this.badge, unseen.length > 99 ? '99+' : String(unseen.length));
    this.badge.className = `badge ${unseen.some((message) => message.level === 'error') ? 'error' : 'warning'}`;
    show(this.badge, unseen.length > 0);
    const wanted = this.filter.value.trim().toLowerCase();
    const shown = messages.filter(
      (message) =>
        this.levels.has(message.level) &&
        (!wanted || `${message.text} ${message.file ?? ''} ${message.source ?? ''}`.toLowerCase().includes(wanted)),
    );
    const key = JSON.stringify([last, shown.length, wanted, [...this.levels]]);
    if (key === this.rendered) return;
    this.rendered = key;
    const atEnd = this.rows.scrollTop + this.rows.clientHeight > this.rows.scrollHeight - 30;
    fill(
      this.rows,
      shown.length ? shown.slice(-MOST_ROWS).map(row) : element('p', { class: 'hint', text: messages.length ? 'No message matches.' : 'No messages: the world runs without warnings.' }),
    );
    if (atEnd) this.rows.scrollTop = this.rows.scrollHeight;
  }
}

/** @param {Message} message */
function row(message) {
  const place = message.file ? `${message.file}${message.line ? `:${message.line}` : ''}` : '';
  return element(
    'div',
    { class: `message ${message.level}` },
    icon(message.level),
    element('span', { class: 'message-time figure', text: message.time === undefined || message.time === null ? '' : clock(message.time) }),
    element('span', { class: 'message-text' }, message.source && element('b', { text: `${message.source}: ` }), message.text),
    place && element('code', { text: place, title: place }),
  );
}
