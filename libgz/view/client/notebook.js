// @ts-check
// Notebook: runs in a notebook's page. It shows the page in a frame of its own, and passes messages on to the kernel.

/**
 * @typedef {{view: string, page?: string, text?: string, asset?: string, kind?: string, end?: boolean, closed?: boolean}} Content
 * @typedef {object} Model of anywidget
 * @property {(name: string) => any} get
 * @property {(content: object) => void} send
 * @property {(event: 'msg:custom', hear: (content: Content, buffers: DataView[]) => void) => void} on
 * @property {(event: 'msg:custom', hear: (content: Content, buffers: DataView[]) => void) => void} off
 */

/** @param {{model: Model, el: HTMLElement}} place */
function render({ model, el }) {
  const view = Array.from(crypto.getRandomValues(new Uint32Array(4)), String).join('-');
  const { port1, port2 } = new MessageChannel();
  const frame = document.createElement('iframe');
  frame.setAttribute('sandbox', 'allow-scripts allow-downloads'); // it reaches nothing of the notebook
  frame.title = 'libgz';
  Object.assign(frame.style, { width: model.get('width'), height: `${model.get('height')}px`, border: '0' });
  frame.addEventListener('load', () => frame.contentWindow?.postMessage('libgz', '*', [port2]), { once: true });
  /** @param {Content} content @param {DataView[]} buffers */
  const hear = (content, buffers) => {
    if (content.view !== view) return;
    const [found] = buffers ?? [];
    const data = found && found.buffer.slice(found.byteOffset, found.byteOffset + found.byteLength);
    if (content.page !== undefined) {
      frame.srcdoc = content.page;
      el.append(frame);
    } else port1.postMessage({ ...content, data });
  };
  /** Send a message; the page learns that its kernel has ended. @param {object} message */
  const send = (message) => {
    try {
      model.send({ view, ...message });
    } catch {
      port1.postMessage({ closed: true });
    }
  };
  const leave = () => send({ close: true });
  port1.onmessage = ({ data }) => send(data);
  model.on('msg:custom', hear);
  window.addEventListener('pagehide', leave);
  send({ open: true });
  return () => {
    window.removeEventListener('pagehide', leave);
    model.off('msg:custom', hear);
    leave();
  };
}

export default { render };
