// @ts-check
/**
 * Time line: where a log is, or the last minute of a world that records it.
 * @module
 */

import { RECORDED } from 'libgz/actions.js';
import { newest } from 'libgz/controls.js';
import { element, setText, show } from 'libgz/dom.js';
import { clock, fixed } from 'libgz/format.js';
import { icon } from 'libgz/icons.js';

const HOLD = 500; // [ms] the slider is the user's after each move

/** The strip below the view. */
export class Timeline {
  /** @param {import('libgz/workplace.js').Workplace} workplace */
  constructor(workplace) {
    this.workplace = workplace;
    this.recording = false;
    this.since = 0; // sim time [s] at which recording began
    this.moved = -Infinity;
    this.recordButton = element(
      'button',
      { type: 'button', class: 'text record', 'aria-pressed': 'false', 'aria-label': `Record ${RECORDED} s`, title: `Keep the last ${RECORDED} s, to rewind to them`, on: { click: () => this.record(!this.recording) } },
      icon('record'),
      element('span', { text: `Record ${RECORDED} s` }),
    );
    this.slider = element('input', { type: 'range', min: -RECORDED, max: 0, step: 0.5, value: '0', 'aria-label': 'Time line' });
    this.place = element('output', { class: 'figure' });
    this.end = element('output', { class: 'figure' });
    this.rewindButton = element(
      'button',
      { type: 'button', class: 'text', 'aria-label': 'Rewind to there', title: 'Rewind to there', on: { click: () => this.#rewind() } },
      icon('rewind'),
      element('span', { text: 'Rewind to there' }),
    );
    this.root = element(
      'div',
      { class: 'timeline', role: 'group', 'aria-label': 'Time line' },
      this.recordButton,
      this.place,
      this.slider,
      this.end,
      this.rewindButton,
    );
    const seek = newest((/** @type {number} */ moment) => workplace.ask('seek', moment.toFixed(3)));
    const go = () => {
      this.moved = performance.now();
      if (this.isLog) seek(Number(this.slider.value));
      this.#update();
    };
    this.slider.addEventListener('input', go);
    this.slider.addEventListener('keydown', (event) => {
      if (/^(Arrow|Page|Home|End)/.test(event.key)) event.stopPropagation();
      if (!this.isLog || !/^(Home|End)$/.test(event.key)) return;
      // The slider may be at that end, and the log be elsewhere meanwhile: no input event would come then.
      event.preventDefault();
      this.slider.value = event.key === 'Home' ? this.slider.min : this.slider.max;
      go();
    });
    for (const event of ['hello', 'state', 'status']) workplace.store.addEventListener(event, () => this.refresh());
    this.refresh();
  }

  /** Whether a log is played. */
  get isLog() {
    return this.workplace.store.abilities.has('seek') && Boolean(this.workplace.store.log);
  }

  /**
   * Whether the server keeps the last minute.
   * @param {boolean} on
   */
  record(on) {
    this.recording = on;
    this.since = this.workplace.store.state?.simTime ?? 0;
    void this.workplace.ask('keep', on ? String(RECORDED) : '0').then((answer) => {
      if (answer === undefined) this.recording = !on;
      this.#show();
    });
    this.#show();
  }

  #show() {
    this.refresh();
    this.workplace.toolbar.refresh();
  }

  #rewind() {
    const back = -Number(this.slider.value);
    if (back <= 0) return;
    void this.workplace.ask('rewind', String(back));
    this.slider.value = '0';
    this.#update();
  }

  refresh() {
    const { store } = this.workplace;
    const { log } = store;
    const able = (/** @type {string} */ verb) => store.control && store.abilities.has(verb);
    show(this.root, this.isLog || able('keep'));
    show(this.recordButton, !this.isLog);
    show(this.rewindButton, !this.isLog);
    this.slider.disabled = this.isLog ? !able('seek') : !this.recording;
    this.rewindButton.disabled = !this.recording;
    this.recordButton.setAttribute('aria-pressed', String(this.recording));
    if (this.isLog && log) {
      this.slider.min = String(log.begin);
      this.slider.max = String(Math.max(log.end, log.begin + 0.01));
      this.slider.step = 'any';
      if (performance.now() - this.moved > HOLD) this.slider.value = String(store.state?.simTime ?? log.time);
    } else {
      const now = store.state?.simTime ?? 0;
      if (now < this.since) this.since = now; // a reset, or back in time
    }
    this.#update();
  }

  #update() {
    const value = Number(this.slider.value);
    const { log } = this.workplace.store;
    const text = this.isLog ? clock(value) : this.recording ? (value ? `${fixed(value, 1)} s` : 'now') : '';
    setText(this.place, text);
    this.slider.setAttribute('aria-valuetext', text);
    setText(this.end, this.isLog && log ? clock(log.end) : '');
    show(this.end, this.isLog);
  }
}
