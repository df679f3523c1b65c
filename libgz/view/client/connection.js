// @ts-check
// Connection: the socket to the viewer. libgz/view/protocol.py describes the messages.

import { receive } from 'libgz/messages.js';

/** @typedef {import('libgz/store.js').Store} Store */

const RETRY = 500; // [ms] before the first new attempt; the next ones wait longer
const SLOWEST = 4000; // [ms]
const LOST = 'The connection to the viewer was lost. Connecting again …';
const CLOSED = 'This view is closed. Run its cell again to open it.';
const ALIVE = 1000; // [ms] between two signs of life while the page is shown

/** The socket; it connects again when it is lost. */
export class Connection {
  /** @param {Store} store @param {(() => any) | null} [makeSocket] what there is instead of a WebSocket */
  constructor(store, makeSocket = null) {
    this.store = store;
    this.makeSocket = makeSocket;
    /** @type {WebSocket | null} */
    this.socket = null;
    this.wait = RETRY;
    this.number = 0;
    /** @type {Map<number, {resolve: (value: any) => void, reject: (error: Error) => void}>} */
    this.asked = new Map();
    window.setInterval(() => document.visibilityState === 'visible' && this.send({ alive: 1 }), ALIVE);
    document.addEventListener('visibilitychange', () => this.send({ visible: document.visibilityState === 'visible' }));
  }

  async open() {
    const socket = (this.socket = /** @type {WebSocket} */ (this.makeSocket?.() ?? new WebSocket(socketAddress())));
    socket.binaryType = 'arraybuffer';
    /** @type {Promise<void>} one message after the other: some are unpacked first */
    let last = Promise.resolve();
    socket.addEventListener('open', () => {
      this.wait = RETRY;
      if (document.visibilityState !== 'visible') this.send({ visible: false });
    });
    socket.addEventListener('message', ({ data }) => {
      last = last.then(() => this.receive(data)).catch((error) => console.error(error));
    });
    socket.addEventListener('close', () => {
      if (this.socket !== socket) return;
      this.socket = null;
      for (const { reject } of this.asked.values()) reject(new Error('The connection to the viewer was lost.'));
      this.asked.clear();
      this.store.lose(this.makeSocket ? CLOSED : LOST);
      if (this.makeSocket) return;
      window.setTimeout(() => void this.open(), this.wait);
      this.wait = Math.min(1.5 * this.wait, SLOWEST);
    });
  }

  /** @param {string | ArrayBuffer} data */
  async receive(data) {
    if (typeof data === 'string') {
      const message = JSON.parse(data);
      if ('answer' in message) {
        const waiting = this.asked.get(message.answer);
        this.asked.delete(message.answer);
        if (message.error !== undefined) waiting?.reject(new Error(message.error));
        else waiting?.resolve(message.value ?? null);
        return;
      }
      this.store.learn(message);
    } else {
      await receive(this.store, data);
    }
  }

  /** Send a message; it is dropped without a connection. @param {object} message */
  send(message) {
    if (this.socket?.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(message));
  }

  /**
   * @param {string} verb
   * @param {string} argument
   * @param {object} content
   * @returns {Promise<any>}
   */
  ask(verb, argument, content) {
    return new Promise((resolve, reject) => {
      if (this.socket?.readyState !== WebSocket.OPEN) {
        reject(new Error('There is no connection to the viewer.'));
        return;
      }
      this.number += 1;
      this.asked.set(this.number, { resolve, reject });
      this.send({ ask: verb, number: this.number, argument, content });
    });
  }
}

function socketAddress() {
  const address = new URL('socket', location.href);
  address.protocol = location.protocol === 'https:' ? 'wss:' : 'ws:';
  address.search = address.hash = '';
  return address;
}
