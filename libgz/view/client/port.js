// @ts-check
// Port: what a page in a notebook has instead of a WebSocket. notebook.js holds its other end.

/** Like a WebSocket, as far as `Connection` needs it; the files of a scene come over it, too. */
export class Port extends EventTarget {
  /** @param {import('libgz/store.js').Store} store */
  constructor(store) {
    super();
    /** @type {number} */
    this.readyState = WebSocket.CONNECTING;
    this.binaryType = 'arraybuffer';
    /** @type {MessagePort | undefined} */
    this.port = undefined;
    store.assetsHere = {};
    window.addEventListener('message', ({ data, ports }) => {
      const [port] = ports;
      if (data !== 'libgz' || !port || this.port) return;
      this.port = port;
      this.readyState = WebSocket.OPEN;
      port.onmessage = (event) => this.#hear(store, event.data);
      this.dispatchEvent(new Event('open'));
    });
  }

  /**
   * @param {import('libgz/store.js').Store} store
   * @param {{text?: string, asset?: string, kind?: string, end?: boolean, closed?: boolean, data?: ArrayBuffer}} message
   */
  #hear(store, { text, asset, kind, end, closed, data }) {
    if (closed) {
      this.readyState = WebSocket.CLOSED;
      this.dispatchEvent(new Event('close'));
    } else if (end) requestAnimationFrame(() => this.port?.postMessage({ shown: true }));
    else if (asset !== undefined && data) {
      store.assetsHere = { ...store.assetsHere, [asset]: URL.createObjectURL(new Blob([data], { type: kind })) };
    } else this.dispatchEvent(new MessageEvent('message', { data: text ?? data }));
  }

  /** @param {string} text */
  send(text) {
    this.port?.postMessage({ text });
  }
}
