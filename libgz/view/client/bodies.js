// Bodies: all shapes of the scene, as instances of forms, moved by the table of states.

import { Box3, Color, Group, InstancedMesh, Matrix4, Mesh, MeshLambertMaterial, Quaternion, Vector3 } from "three";
import { isDevice, piecesOf } from "libgz/finish.js";
import { forget, formOf } from "libgz/forms.js";
import { lookOf, SEEN_THROUGH } from "libgz/materials.js";

/** @typedef {import("libgz/assets.js").Assets} Assets */
/** @typedef {import("libgz/store.js").Store} Store */
/** @typedef {import("libgz/forms.js").Form} Form */
/** @typedef {import("libgz/materials.js").Showing} Showing */

/**
 * One shape that is shown.
 * @typedef {object} Instance
 * @property {number} entity number of it
 * @property {number} row of its body, -1 for a global pose
 * @property {any} shape of the scene
 * @property {number[]} pose in its body
 * @property {[number, number, number]} scale
 * @property {Batch} batch
 * @property {number} index in it
 * @property {boolean} ground whether it is an infinite plane, which nobody selects or frames
 */

/**
 * @typedef {object} Batch
 * @property {import("three").BufferGeometry} geometry
 * @property {import("three").Material} material
 * @property {boolean} shadows
 * @property {Instance[]} instances
 * @property {Color[]} colors
 * @property {InstancedMesh} mesh
 */

const NOT_SHOWN = new Set(["light", "frustum", "ray", "dome", "other"]);
const FLESH = new Vector3(0.3, 0.3, 0.3); // [m] around a bone
const STILL = 3e-5; // [m], and of quaternions: what nobody sees of bodies that tremble at rest
const DUSK = 0.3; // how bright plain ground is in the dark theme
const TERRAIN = 40; // [m] from which a mesh casts no shadows: they would cost more than they show
const position = new Vector3(), rotation = new Quaternion(), scale = new Vector3();
const frame = new Matrix4(), own = new Matrix4();

/** Shows all bodies. */
export class Bodies {
  /** @param {Store} store @param {Assets} assets */
  constructor(store, assets) {
    this.store = store;
    this.assets = assets;
    this.group = new Group();
    /** @type {Batch[]} */
    this.batches = [];
    /** @type {Instance[]} */
    this.instances = [];
    /** @type {Map<number, Instance[]>} of each entity */
    this.of = new Map();
    /** @type {Map<string, import("three").Material>} */
    this._materials = new Map();
    this._shown = new Float32Array(0);
    /** @type {Map<number, number[]>} rows of the bones of each actor */
    this.bones = new Map();
  }

  /**
   * Show the shapes of the scene as the switches want them. States before this call do not count.
   * @param {{fine: boolean, dark: boolean}} way physically based shading, and the dark theme
   */
  build({ fine, dark }) {
    const { store } = this, scene = store.scene;
    /** @type {Map<string, Batch>} */
    const batches = new Map();
    /** @type {Map<string, import("three").Material>} */
    const materials = new Map();
    this.instances = [];
    this.of = new Map();
    /** @type {Set<string>} */
    const used = new Set();
    for (const [entity, body] of bodiesOf(scene)) {
      if (entity.number && store.isOn("hidden", entity.number)) continue;
      const showing = {
        fine,
        wireframe: store.isOn("wireframe", entity.number),
        collisions: store.isOn("collisions", entity.number),
        transparent: store.isOn("transparent", entity.number),
        skins: store.isOn("skins") && isDevice(scene, entity),
      };
      // An infinite plane of a classic world has a flat mesh beside it, which is seen.
      const plane = body.shapes.find((/** @type {any} */ shape) => shape.kind === "plane");
      for (const shape of body.shapes) {
        const ground = shape.kind === "plane" || (plane && shape.kind === "mesh");
        const shown = ground && shape !== plane && !shape.texture ? infinite(shape, plane) : shape;
        const way = ground ? { ...showing, wireframe: false, collisions: false, transparent: false } : showing;
        for (const part of this._parts(shown, way)) {
          if (![...part.scale, ...part.pose].every(Number.isFinite)) continue;
          used.add(part.form.key);
          const look = part.material ?? lookOf(part.shape ?? shape, this.assets, way, part.form);
          if (ground && dark && !shape.texture) look.color = look.color.clone().multiplyScalar(DUSK);
          const shadows = shape.cast_shadows && look.opacity === 1 && shape.kind !== "plane";
          const key = `${part.form.key}|${look.key}|${shadows}`;
          let batch = batches.get(key);
          if (!batch) {
            const material = this._materials.get(look.key) ?? materials.get(look.key) ?? look.make();
            materials.set(look.key, material);
            batch = /** @type {Batch} */ (/** @type {unknown} */ ({ geometry: part.form.geometry, material, shadows, instances: [], colors: [] }));
            batches.set(key, batch);
          }
          const instance = {
            entity: entity.number,
            row: shown.kind === "plane" ? -1 : body.row,
            shape,
            pose: part.pose,
            scale: part.scale,
            batch,
            index: batch.instances.length,
            ground: Boolean(ground),
          };
          batch.instances.push(instance);
          batch.colors.push(look.color);
          this.instances.push(instance);
          const found = this.of.get(entity.number);
          if (found) found.push(instance);
          else this.of.set(entity.number, [instance]);
        }
      }
    }
    for (const { mesh } of this.batches) mesh.dispose();
    this.group.clear();
    this.batches = [...batches.values()];
    for (const batch of this.batches) this._make(batch);
    for (const [key, material] of this._materials) if (!materials.has(key)) material.dispose();
    this._materials = materials;
    forget(used);
    this._shown = new Float32Array(0);
    this.move();
  }

  /** @param {Batch} batch */
  _make(batch) {
    const mesh = new InstancedMesh(batch.geometry, batch.material, batch.instances.length);
    mesh.frustumCulled = false;
    mesh.castShadow = batch.shadows && !isTerrain(batch);
    mesh.receiveShadow = batch.material.opacity === 1;
    mesh.renderOrder = batch.instances.some(({ ground }) => ground) ? 1 : 0; // last: most of it is hidden
    mesh.userData.batch = batch;
    batch.colors.forEach((color, i) => mesh.setColorAt(i, color));
    batch.mesh = mesh;
    this.group.add(mesh);
  }

  /**
   * What a shape looks like: forms, with places and perhaps materials of their own.
   * @param {any} shape
   * @param {Showing} showing
   * @returns {{form: Form, pose: number[], scale: [number, number, number], material?: import("libgz/materials.js").Look, shape?: any}[]}
   */
  _parts(shape, showing) {
    const wanted = showing.collisions ? shape.collides : shape.visible;
    if (!wanted || NOT_SHOWN.has(shape.kind) || (shape.bones && !showing.collisions)) return [];
    if (!showing.collisions) {
      if (shape.hidden_by_skins && (shape.hidden_by_skin === null || this.assets.skin(shape.hidden_by_skin))) return [];
      const skin = shape.skin && this.assets.skin(shape.skin.file);
      if (skin) return skinParts(skin, shape, showing);
    }
    const [sx, sy, sz] = showing.collisions ? [1, 1, 1] : shape.scale;
    const pieces = showing.skins && !showing.collisions && !showing.wireframe && piecesOf(shape);
    if (pieces) return pieces.map(({ form, paint }) => ({ form, pose: shape.pose, scale: [sx, sy, sz], shape: painted(shape, paint) }));
    const form = formOf(shape, (reference) => this.assets.arrays(reference));
    if (!form) return [];
    const [x, y, z] = form.scale;
    return [{ form, pose: shape.pose, scale: [x * sx, y * sy, z * sz] }];
  }

  /** Move everything to where it is in the present state. Returns whether anything has moved. */
  move() {
    const { state } = this.store;
    const table = state?.bodies ?? new Float32Array(0), columns = state?.bodyColumns ?? 16;
    const rows = Math.floor(table.length / columns), all = this._shown.length !== 7 * rows;
    if (all) this._shown = new Float32Array(7 * rows).fill(NaN);
    const shown = this._shown;
    const changed = new Uint8Array(rows);
    let moved = all;
    for (let row = 0; row < rows; row++) {
      for (let k = 0; k < 7; k++) {
        const value = table[columns * row + k];
        if (!(Math.abs(shown[7 * row + k] - value) <= STILL)) changed[row] = 1;
      }
      if (!changed[row]) continue;
      for (let k = 0; k < 7; k++) shown[7 * row + k] = table[columns * row + k];
      moved = true;
    }
    if (!moved) return false;
    for (const { mesh } of this.batches) mesh.userData.moved = false;
    for (const instance of this.instances) {
      const { row, batch } = instance;
      if (row >= 0 && row < rows ? !changed[row] : !all) continue;
      this.matrix(instance, own);
      own.toArray(batch.mesh.instanceMatrix.array, 16 * instance.index);
      batch.mesh.userData.moved = true;
    }
    for (const { mesh } of this.batches) {
      if (!mesh.userData.moved) continue;
      mesh.instanceMatrix.needsUpdate = true;
      mesh.boundingSphere = null; // rays of the pointer find it at its new place
    }
    return true;
  }

  /** Where an instance is. @param {Instance} instance @param {Matrix4} into */
  matrix(instance, into) {
    placed(instance.pose, 0, into, instance.scale);
    const body = this.store.bodyPose(instance.row);
    return body ? into.premultiply(placed(body, 0, frame)) : into;
  }

  /**
   * The box around entities, along the world's axes; empty without shapes.
   * @param {Iterable<number>} numbers
   */
  bounds(numbers) {
    const box = new Box3(), part = new Box3(), matrix = new Matrix4();
    for (const number of numbers) {
      for (const instance of this.of.get(number) ?? []) {
        if (instance.ground) continue;
        const { geometry } = instance.batch;
        if (!geometry.boundingBox) geometry.computeBoundingBox();
        part.copy(/** @type {Box3} */ (geometry.boundingBox)).applyMatrix4(this.matrix(instance, matrix));
        box.union(part);
      }
      for (const row of this.bones.get(number) ?? []) {
        const pose = this.store.bodyPose(row);
        if (pose) box.union(part.setFromCenterAndSize(position.set(pose[0], pose[1], pose[2]), FLESH));
      }
    }
    return box;
  }

  /** An entity, and all that is attached to it or nested in it. @param {number} number */
  family(number) {
    const found = [number];
    for (const one of found) {
      for (const entity of this.store.scene?.entities ?? []) {
        if (entity.parent === one && !found.includes(entity.number)) found.push(entity.number);
      }
    }
    return found;
  }
}

/** @param {any} scene @returns {Generator<[any, any]>} each body with its entity */
export function* bodiesOf(scene) {
  for (const entity of scene.entities) for (const body of entity.bodies) yield [entity, body];
  for (const body of scene.others) yield [{ number: 0, static: true }, body];
}

/**
 * The matrix of a pose: position, quaternion w, x, y, z.
 * @param {ArrayLike<number>} pose
 * @param {number} start where it begins
 * @param {Matrix4} into
 * @param {ArrayLike<number>} factors
 */
export function placed(pose, start, into, factors = [1, 1, 1]) {
  position.set(pose[start], pose[start + 1], pose[start + 2]);
  rotation.set(pose[start + 4], pose[start + 5], pose[start + 6], pose[start + 3]);
  return into.compose(position, rotation, scale.set(factors[0], factors[1], factors[2]));
}

/** A shape in another paint. @param {any} shape @param {{color: number[], roughness: number, metalness: number}} paint */
function painted(shape, { color, roughness, metalness }) {
  return { ...shape, material: { ...shape.material, diffuse: [...color, 1] }, pbr: { roughness, metalness } };
}

/** A flat mesh of a classic world's ground, as large as the plane that things stand on. @param {any} mesh @param {any} plane */
function infinite(mesh, plane) {
  const { normal, altitude } = plane;
  return { ...mesh, kind: "plane", normal, altitude, pose: [0, 0, 0, 1, 0, 0, 0], scale: [1, 1, 1] };
}

/** @param {Batch} batch */
function isTerrain(batch) {
  const { geometry } = batch;
  if (batch.instances[0].shape.kind === "heightfield") return false;
  if (!geometry.boundingBox) geometry.computeBoundingBox();
  const size = /** @type {Box3} */ (geometry.boundingBox).getSize(new Vector3());
  return batch.instances[0].shape.kind === "mesh" && Math.max(size.x, size.y, size.z) > TERRAIN;
}

/**
 * The meshes of a skin's file in place of a shape.
 * @param {import("three").Group} skin
 * @param {any} shape
 * @param {Showing} showing
 */
function skinParts(skin, shape, showing) {
  const matrix = placed(shape.skin.pose, 0, new Matrix4(), shape.skin.scale).premultiply(placed(shape.pose, 0, frame));
  matrix.decompose(position, rotation, scale);
  const pose = [position.x, position.y, position.z, rotation.w, rotation.x, rotation.y, rotation.z];
  /** @type {{form: Form, pose: number[], scale: [number, number, number], material: import("libgz/materials.js").Look}[]} */
  const parts = [];
  skin.traverse((node) => {
    if (!(node instanceof Mesh)) return;
    const { geometry, material } = node;
    parts.push({
      form: { key: `skin ${geometry.uuid}`, geometry, scale: [1, 1, 1] },
      pose,
      scale: [scale.x, scale.y, scale.z],
      material: {
        key: `skin ${material.uuid} ${JSON.stringify(showing)}`,
        color: new Color(1, 1, 1),
        opacity: showing.transparent ? SEEN_THROUGH : material.opacity,
        make: () => skinMaterial(material, showing),
      },
    });
  });
  return parts;
}

/** @param {import("three").MeshStandardMaterial} material of a file @param {Showing} showing */
function skinMaterial(material, showing) {
  const { color, map, vertexColors, side } = material;
  const common = { color, map, vertexColors, side, wireframe: showing.wireframe };
  const opacity = showing.transparent ? SEEN_THROUGH : material.opacity;
  const made = showing.fine ? material.clone() : new MeshLambertMaterial(common);
  return Object.assign(made, { wireframe: showing.wireframe, opacity, transparent: opacity < 1, depthWrite: opacity === 1 });
}
