// Assets: the files that a scene names, as the server or the page itself gives them: arrays, images and skins.

import {
  RepeatWrapping,
  SRGBColorSpace,
  Texture,
} from "three";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";

/**
 * The arrays of a mesh, height field, bundle of rays or bones, by their names in the scene.
 * @typedef {Record<string, any> & {shapes: Record<string, number[]>}} Arrays
 */

/** Keeps what was loaded, by address; addresses name the content. */
export class Assets {
  constructor() {
    /** @type {Map<string, Promise<any>>} */
    this._asked = new Map();
    /** @type {Map<string, any>} what has arrived; null for what cannot be read */
    this._here = new Map();
    /** @type {Record<string, string>} file -> address */
    this.addresses = {};
    this._loader = new GLTFLoader();
  }

  /** How many of the files asked for have arrived, and how many were asked for. */
  get progress() {
    return [this._here.size, this._asked.size];
  }

  /**
   * The arrays that the scene refers to; null if they have not arrived or cannot be read.
   * @param {any} reference
   * @returns {Arrays | null}
   */
  arrays(reference) {
    return this._found(`arrays ${reference.file}`);
  }

  /** @param {string} file @returns {Texture | null} */
  texture(file) {
    return this._found(`image ${this.addresses[file]}`);
  }

  /** @param {string} file @returns {import("three").Group | null} */
  skin(file) {
    return this._found(`skin ${this.addresses[file]}`);
  }

  /** @param {string} key */
  _found(key) {
    return this._here.get(key) ?? null;
  }

  /**
   * Load all files that a scene names and that are not there yet.
   * @param {any} scene
   * @param {() => void} arrived called after each of them
   */
  async load(scene, arrived) {
    this.addresses = scene.assets ?? {};
    /** @type {Promise<any>[]} */
    const waiting = [];
    const ask = (/** @type {string} */ key, /** @type {string | undefined} */ address, /** @type {Function} */ get) => {
      if (!address) return;
      let asked = this._asked.get(key);
      if (!asked) {
        asked = get(address)
          .catch((/** @type {Error} */ problem) => {
            console.warn(`${key}: ${problem.message}`);
            return null;
          })
          .then((/** @type {any} */ found) => {
            this._here.set(key, found);
          });
        this._asked.set(key, /** @type {Promise<any>} */ (asked));
      }
      waiting.push(/** @type {Promise<any>} */ (asked).then(arrived));
    };
    const image = (/** @type {string | null | undefined} */ file) => {
      if (file) ask(`image ${this.addresses[file]}`, this.addresses[file], readTexture);
    };
    const data = (/** @type {any} */ reference) => {
      if (!reference) return;
      ask(`arrays ${reference.file}`, this.addresses[reference.file], (/** @type {string} */ address) =>
        readArrays(address, reference.arrays));
    };
    for (const shape of shapesOf(scene)) {
      data(shape.data);
      if (shape.bones) data(shape.bones.data);
      if (shape.texture) image(shape.texture.file);
      for (const file of Object.values(shape.pbr ?? {})) if (typeof file === "string") image(file);
      for (const file of [shape.skin?.file, shape.hidden_by_skin]) {
        if (file) {
          ask(`skin ${this.addresses[file]}`, this.addresses[file], async (/** @type {string} */ address) =>
            (await this._loader.loadAsync(address)).scene);
        }
      }
    }
    for (const entity of scene.entities) for (const sensor of entity.sensors) data(sensor.data);
    if (scene.sky) image(scene.sky.texture);
    await Promise.all(waiting);
  }
}

/** All shapes of a scene. @param {any} scene */
function* shapesOf(scene) {
  for (const entity of scene.entities) for (const body of entity.bodies) yield* body.shapes;
  for (const body of scene.others) yield* body.shapes;
}

/** @param {string} address */
async function fetched(address) {
  const answer = await fetch(address);
  if (!answer.ok) throw new Error(`${answer.status} ${answer.statusText}`);
  return answer;
}

/**
 * @param {string} address
 * @param {Record<string, {type: string, shape: number[], offset: number}>} table
 * @returns {Promise<Arrays>}
 */
async function readArrays(address, table) {
  const bytes = await (await fetched(address)).arrayBuffer();
  /** @type {Arrays} */
  const arrays = { shapes: {} };
  for (const [name, { type, shape, offset }] of Object.entries(table)) {
    const count = shape.reduce((product, size) => product * size, 1);
    arrays[name] = type === "uint32" ? new Uint32Array(bytes, offset, count) : new Float32Array(bytes, offset, count);
    arrays.shapes[name] = shape;
  }
  return arrays;
}

/** @param {string} address */
async function readTexture(address) {
  const image = await createImageBitmap(await (await fetched(address)).blob(), { imageOrientation: "flipY" });
  return textureOf(image);
}

/** @param {ImageBitmap} image turned upside down */
function textureOf(image) {
  const texture = new Texture(image);
  texture.flipY = false;
  texture.colorSpace = SRGBColorSpace;
  texture.wrapS = texture.wrapT = RepeatWrapping;
  texture.anisotropy = 8;
  texture.needsUpdate = true;
  return texture;
}

/** The image that a mesh has beside its triangles, as a texture. @param {Arrays} arrays */
export function ownTexture(arrays) {
  if (!arrays.image || arrays.texture) return arrays.texture ?? null;
  const [height, width, depth] = arrays.shapes.image;
  const pixels = new Uint8ClampedArray(4 * width * height).fill(255);
  for (let i = 0; i < width * height; i++) {
    for (let k = 0; k < Math.min(depth, 4); k++) pixels[4 * i + k] = arrays.image[depth * i + k];
  }
  const canvas = document.createElement("canvas");
  canvas.width = width;
  canvas.height = height;
  /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d")).putImageData(new ImageData(pixels, width, height), 0, 0);
  const texture = new Texture(canvas);
  texture.colorSpace = SRGBColorSpace;
  texture.wrapS = texture.wrapT = RepeatWrapping;
  texture.needsUpdate = true;
  arrays.texture = texture;
  return texture;
}

/** A column of an image as colours from its top to its bottom, 0 to 1. @param {Texture} texture @param {number} share */
export function columnOf(texture, share) {
  const image = /** @type {ImageBitmap} */ (texture.image);
  const canvas = document.createElement("canvas");
  canvas.width = 1;
  canvas.height = image.height;
  const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d", { willReadFrequently: true }));
  const column = Math.min(Math.floor((share % 1) * image.width), image.width - 1);
  context.drawImage(image, column, 0, 1, image.height, 0, 0, 1, image.height);
  const pixels = context.getImageData(0, 0, 1, image.height).data;
  /** @type {number[][]} */
  const colors = [];
  for (let i = 0; i < image.height; i++) colors.unshift([pixels[4 * i], pixels[4 * i + 1], pixels[4 * i + 2]].map((c) => c / 255));
  return colors; // the bitmap is upside down
}

