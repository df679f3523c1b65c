// @ts-check
// Recording: plays the states that a page has in itself, instead of a connection to a viewer.

import { receive } from 'libgz/messages.js';

/** @typedef {import('libgz/store.js').Store} Store */

/** A run that is played in a loop, from the moment its scene is shown. */
export class Recording {
  /**
   * @param {Store} store
   * @param {string} text JSON: title, switches, assets, and moments: [time, messages by key] each
   * @param {() => boolean} ready whether the world is shown: until then the run waits
   */
  constructor(store, text, ready) {
    this.store = store;
    this.ready = ready;
    const { title, switches, assets, moments } = JSON.parse(text);
    /** @type {string} */
    this.title = title;
    /** @type {[number, Record<string, string>][]} */
    this.moments = moments;
    this.begin = moments[0]?.[0] ?? 0;
    this.end = moments.at(-1)?.[0] ?? 0;
    /** @type {Record<string, string>} */
    this.assets = assets;
    /** @type {string[]} */
    this.switches = switches;
    this.time = this.begin;
    this.place = 0;
    this.speed = 1;
    this.paused = false;
    this.before = performance.now();
  }

  async open() {
    const { store } = this;
    store.assetsHere = Object.fromEntries(
      Object.entries(this.assets).map(([name, data]) => [name, URL.createObjectURL(new Blob([bytesOf(data)]))]),
    );
    for (const name of this.switches) store.setSwitch(name, true);
    store.learn({
      hello: { title: this.title, abilities: ['seek', 'pause', 'speed', 'step'] },
      control: { here: true, other: false, canAsk: false },
    });
    await this.seek(this.begin);
    for (;;) {
      await new Promise((resolve) => requestAnimationFrame(resolve));
      const now = performance.now(), passed = Math.min(now - this.before, 250) / 1000;
      this.before = now;
      if (this.paused || !this.ready()) continue;
      this.time += this.speed * passed;
      if (this.time > this.end + 1) await this.seek(this.begin);
      else await this.play();
    }
  }

  /** Show all that has happened up to now. */
  async play() {
    let { place } = this;
    while (place < this.moments.length && this.moments[place][0] <= this.time + 1e-9) place += 1;
    /** @type {Record<string, string>} the last message of each key */
    const last = {};
    for (const [, messages] of this.moments.slice(this.place, place)) {
      for (const [key, message] of Object.entries(messages)) {
        delete last[key]; // a state stays behind its scene
        last[key] = message;
      }
    }
    this.place = place;
    for (const message of Object.values(last)) {
      if (message.startsWith('{')) this.store.learn(JSON.parse(message));
      else await receive(this.store, bytesOf(message).buffer);
    }
    this.showTime();
  }

  /** @param {number} time */
  async seek(time) {
    if (time < this.time || time === this.begin) this.place = 0;
    this.time = time;
    await this.play();
  }

  showTime() {
    const time = Math.min(this.time, this.end);
    this.store.learn({ status: { text: '', level: '' }, log: { begin: this.begin, end: this.end, time, speed: this.speed } });
  }

  send() {}

  /** @param {string} verb @param {string} argument */
  async ask(verb, argument) {
    const next = this.moments[this.place]?.[0];
    if (verb === 'seek') await this.seek(Math.min(Math.max(Number(argument), this.begin), this.end));
    else if (verb === 'speed') this.speed = Number(argument);
    else if (verb === 'step' && next !== undefined) await this.seek(next);
    else if (verb === 'pause') {
      this.paused = argument === 'on';
      if (this.store.state) this.store.setState({ ...this.store.state, paused: this.paused });
    }
    return null;
  }
}

/** @param {string} text in base64 */
function bytesOf(text) {
  return Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
}
