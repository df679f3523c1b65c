// Skins: meshes of actors, which their bones bend. The bones are bodies.

import { Bone, BufferAttribute, BufferGeometry, Color, DoubleSide, Group, Matrix4, MeshLambertMaterial, Skeleton, SkinnedMesh } from "three";
import { bodiesOf, placed } from "libgz/bodies.js";
import { SEEN_THROUGH, toned } from "libgz/materials.js";

/** @typedef {import("libgz/assets.js").Assets} Assets */
/** @typedef {import("libgz/store.js").Store} Store */

/** Shows the skins of all actors. */
export class Skins {
  /** @param {Store} store @param {Assets} assets @param {import("libgz/bodies.js").Bodies} bodies */
  constructor(store, assets, bodies) {
    this.store = store;
    this.bodies = bodies;
    this.assets = assets;
    this.group = new Group();
    /** @type {{mesh: SkinnedMesh, bones: Bone[], rows: number[], entity: number}[]} */
    this.skins = [];
  }

  build() {
    for (const { mesh } of this.skins) {
      mesh.geometry.dispose();
      mesh.skeleton.dispose();
      /** @type {MeshLambertMaterial} */ (mesh.material).dispose();
    }
    this.group.clear();
    this.skins = [];
    this.bodies.bones = new Map();
    const { store } = this;
    /** @type {Map<number, number>} */
    const rows = new Map();
    for (const [, body] of bodiesOf(store.scene)) rows.set(body.id, body.row);
    for (const [entity, body] of bodiesOf(store.scene)) {
      if (entity.number && (store.isOn("hidden", entity.number) || store.isOn("collisions", entity.number))) continue;
      for (const shape of body.shapes) if (shape.bones && shape.visible) this._add(shape, entity.number, rows);
    }
    this.move();
  }

  /** @param {any} shape @param {number} entity @param {Map<number, number>} rows of bodies */
  _add(shape, entity, rows) {
    const arrays = this.assets.arrays(shape.data), bent = this.assets.arrays(shape.bones.data);
    if (!arrays || !bent) return;
    const geometry = new BufferGeometry(), count = bent.rest.length / 3;
    geometry.setAttribute("position", new BufferAttribute(bent.rest, 3));
    geometry.setAttribute("skinIndex", new BufferAttribute(Uint16Array.from(bent.places), 4));
    geometry.setAttribute("skinWeight", new BufferAttribute(bent.weights, 4));
    if (arrays.texture_coordinates) geometry.setAttribute("uv", new BufferAttribute(arrays.texture_coordinates, 2));
    geometry.setIndex(new BufferAttribute(arrays.triangles, 1));
    geometry.computeVertexNormals();
    const bones = shape.bones.bodies.map(() => new Bone());
    const binds = bones.map((/** @type {Bone} */ _, /** @type {number} */ i) =>
      new Matrix4().fromArray(bent.inverse_binds, 16 * i).transpose());
    const map = shape.texture ? this.assets.texture(shape.texture.file) : null;
    const transparent = this.store.isOn("transparent", entity);
    const material = new MeshLambertMaterial({
      map,
      color: map ? new Color(1, 1, 1) : toned(shape.material.diffuse),
      side: DoubleSide,
      wireframe: this.store.isOn("wireframe", entity),
      transparent,
      opacity: transparent ? SEEN_THROUGH : 1,
    });
    const mesh = new SkinnedMesh(geometry, material);
    mesh.frustumCulled = false;
    mesh.castShadow = shape.cast_shadows;
    mesh.receiveShadow = true;
    mesh.userData.entity = entity;
    if (count) mesh.add(...bones);
    mesh.bind(new Skeleton(bones, binds), new Matrix4());
    this.group.add(mesh);
    const own = shape.bones.bodies.map((/** @type {number} */ body) => rows.get(body) ?? -1);
    this.bodies.bones.set(entity, own);
    this.skins.push({ mesh, bones, entity, rows: own });
  }

  /** Bend all skins as in the present state. */
  move() {
    for (const { mesh, bones, rows } of this.skins) {
      bones.forEach((bone, i) => {
        const pose = this.store.bodyPose(rows[i]);
        if (pose) placed(pose, 0, bone.matrix).decompose(bone.position, bone.quaternion, bone.scale);
      });
      Object.assign(mesh, { boundingSphere: null, boundingBox: null }); // rays of the pointer find it at its new place
    }
  }
}
