// Quality: how much work a frame is, chosen by the page itself from the time that frames take.

/**
 * @typedef {object} Level
 * @property {boolean} fine physically based shading
 * @property {number} pixels per pixel of the page, at most
 * @property {number} shadows size of their map; 0 for none
 */

/** From the best to the cheapest. @type {Level[]} */
const LEVELS = [
  { fine: true, pixels: 2, shadows: 4096 },
  { fine: true, pixels: 1, shadows: 2048 },
  { fine: false, pixels: 1, shadows: 2048 },
  { fine: false, pixels: 1, shadows: 1024 },
  { fine: false, pixels: 0.75, shadows: 1024 },
  { fine: false, pixels: 0.6, shadows: 0 },
  { fine: false, pixels: 0.45, shadows: 0 },
];
const SLOW = 45; // [ms] of a frame that is too slow
const SAMPLES = 6; // frames whose median decides

/** Whether a context renders on the processor. @param {WebGL2RenderingContext | WebGLRenderingContext} gl */
export function isSoftware(gl) {
  const info = gl.getExtension("WEBGL_debug_renderer_info");
  const name = info ? String(gl.getParameter(info.UNMASKED_RENDERER_WEBGL)) : "";
  return /swiftshader|llvmpipe|softpipe|software/i.test(name);
}

/** Lowers the level while frames are slow. */
export class Quality {
  /** @param {boolean} software @param {string | null} wanted "best" or "fast": what the user asked for, else null */
  constructor(software, wanted) {
    this.fixed = wanted !== null;
    this.index = wanted === "best" ? 1 : wanted === "fast" ? LEVELS.length - 1 : software ? 3 : 0;
    /** @type {number[]} */
    this._times = [];
  }

  /** @returns {Level} */
  get level() {
    return LEVELS[this.index];
  }

  /** Count a frame; returns whether the level has changed. @param {number} time [ms] */
  count(time) {
    if (this.fixed) return false;
    this._times.push(time);
    if (this._times.length < SAMPLES) return false;
    const median = this._times.sort((a, b) => a - b)[SAMPLES / 2];
    this._times = [];
    if (median < SLOW || this.index === LEVELS.length - 1) return false;
    this.index += 1;
    return true;
  }
}
