// @ts-check
// Messages: unpacks binary messages, those of the socket and those of a recording. libgz/view/protocol.py packs them.

/** @typedef {import('libgz/store.js').Store} Store */

const STATE = 1, IMAGE = 2, SCENE = 3;
const HEAD = 64; // [byte] of a state

/**
 * Pass a binary message on to the store.
 * @param {Store} store
 * @param {ArrayBuffer} data
 */
export async function receive(store, data) {
  const kind = new DataView(data).getUint32(0, true);
  if (kind === STATE) store.setState(stateOf(data));
  else if (kind === IMAGE) store.setImage(...imageOf(data));
  else if (kind === SCENE) store.setScene(JSON.parse(await unpacked(data, 4)));
}

/** @param {ArrayBuffer} data @returns {import('libgz/store.js').State} */
function stateOf(data) {
  const [, revision, paused, bodies, bodyColumns, joints, jointColumns] = new Uint32Array(data, 0, 8);
  const [steps, simTime, pauseTime, realTime] = new Float64Array(data, 32, 4);
  return {
    steps,
    simTime,
    pauseTime,
    realTime,
    paused: paused === 1,
    revision,
    bodyColumns,
    jointColumns,
    bodies: new Float32Array(data, HEAD, bodies * bodyColumns),
    joints: new Float32Array(data, HEAD + 4 * bodies * bodyColumns, joints * jointColumns),
  };
}

/** @param {ArrayBuffer} data @returns {[string, Blob]} */
function imageOf(data) {
  const length = new DataView(data).getUint32(4, true);
  const name = new TextDecoder().decode(new Uint8Array(data, 8, length));
  return [name, new Blob([new Uint8Array(data, 8 + length)], { type: 'image/jpeg' })];
}

/**
 * The text of a message that is packed by zlib.
 * @param {ArrayBuffer} data
 * @param {number} offset
 */
export async function unpacked(data, offset) {
  const stream = new Blob([new Uint8Array(data, offset)]).stream().pipeThrough(new DecompressionStream('deflate'));
  return new Response(stream).text();
}
