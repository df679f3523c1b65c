// Quality: how much work a frame is, chosen by the page itself from the time that frames take.

/**
 * @typedef {object} Level
 * @property {boolean} fine physically based shading
 * @property {number} pixels per pixel of the page, at most
 * @property {number} shadows size of their map; 0 for none
 * @property {boolean} soft whether there are soft shadows below things, too
 */

/** From the best to the cheapest. @type {Level[]} */
const LEVELS = [
  { fine: true, pixels: 2, shadows: 4096, soft: true },
  { fine: true, pixels: 1, shadows: 2048, soft: true },
  { fine: false, pixels: 1, shadows: 2048, soft: true },
  { fine: false, pixels: 0.8, shadows: 1024, soft: true },
  { fine: false, pixels: 0.7, shadows: 1024, soft: false },
  { fine: false, pixels: 0.6, shadows: 512, soft: false },
  { fine: false, pixels: 0.5, shadows: 0, soft: false },
];
const SLOW = 70; // [ms] of a frame that is too slow
const QUICK = 18; // [ms] of one that leaves time for a better level
const PATIENCE = 400; // [ms] that a still image may take
const SKIP = 3; // frames that do not count
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
    this._frames = 0;
    this._quick = 0; // rows of quick samples
    this._skipped = SKIP;
    this._best = this.index;
    this.time = 0; // [ms] of the last frame that was measured
  }

  /** Whether the time of the next frame is wanted: measuring makes the page wait for it. */
  get measures() {
    return this._frames++ < 10 * SAMPLES || this._frames % 10 === 0;
  }

  /** Pixels per pixel of the page of a still image, when moving ones have `ratio`. @param {number} ratio */
  still(ratio) {
    return Math.min(Math.max(ratio * Math.sqrt(PATIENCE / Math.max(this.time, 1)), 1), 2);
  }

  /** @returns {Level} */
  get level() {
    return LEVELS[this.index];
  }

  /** Count a frame; returns whether the level has changed. @param {number} time [ms] */
  count(time) {
    this.time = time;
    if (this.fixed || this._skipped-- > 0) return false; // the first frames of a level compile its shaders
    this._times.push(time);
    if (this._times.length < SAMPLES) return false;
    const median = this._times.sort((a, b) => a - b)[SAMPLES / 2];
    this._times = [];
    this._quick = median < QUICK ? this._quick + 1 : 0;
    const better = this._quick > 3 && this.index > this._best;
    const worse = median > SLOW && this.index < LEVELS.length - 1;
    if (!better && !worse) return false;
    this.index += better ? -1 : 1;
    this._quick = 0;
    this._skipped = SKIP;
    return true;
  }
}
