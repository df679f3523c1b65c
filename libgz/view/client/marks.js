// Marks: what is shown beside the scene itself, each behind a switch, for one model or for all: sensors, mechanics, names.

import {
  BufferAttribute,
  BufferGeometry,
  CanvasTexture,
  Color,
  DoubleSide,
  DynamicDrawUsage,
  Group,
  InstancedInterleavedBuffer,
  InterleavedBufferAttribute,
  Matrix4,
  Mesh,
  MeshBasicMaterial,
  PlaneGeometry,
  Sprite,
  SpriteMaterial,
  SRGBColorSpace,
  TextureLoader,
  Vector2,
  Vector3,
} from "three";
import { LineMaterial } from "three/addons/lines/LineMaterial.js";
import { LineSegments2 } from "three/addons/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/addons/lines/LineSegmentsGeometry.js";
import { placed } from "libgz/bodies.js";

/** @typedef {import("libgz/assets.js").Assets} Assets */
/** @typedef {import("libgz/bodies.js").Bodies} Bodies */
/** @typedef {import("libgz/store.js").Store} Store */

const COLORS = {
  lasers: 0x3c78ff,
  sonars: 0xffaa28,
  frusta: 0x8a4fd0,
  contacts: 0xe62828,
  forces: 0x18a86b,
  axes: 0xd0239a,
  masses: 0xf2c200,
  inertia: 0xb46cff,
  boxes: 0x8a929c,
  trails: 0xf07800,
};
const RED = 0xe5383b, GREEN = 0x2a9d3f, BLUE = 0x2f6fed;
const CONE = (7.5 * Math.PI) / 180; // half angle of a sonar's cone, where nothing says it
const LONGEST_FRUSTUM = 2; // [m]
const SCREEN = 0.5; // [m] before a camera, where its image is shown
const LONGEST_RAY = 30; // [m] of a ray that meets nothing
const RAYS = 181; // most that are shown of one scan
const TRAIL = 600; // points
const TRAIL_STEP = 0.02; // [m] between two of them
const FORCE = 0.01; // [m/N] of an arrow
const LONGEST_FORCE = 1; // [m]

const MOST_NAMES = 60; // shown at a time
const STILL = 1e-4; // [m] and shares of colours: what nobody sees

const matrix = new Matrix4(), inner = new Matrix4(), a = new Vector3(), b = new Vector3();

/**
 * Write numbers into an array; returns whether any of them was another one before.
 * @param {Float32Array} array @param {number} at @param {number[]} values
 */
function put(array, at, values) {
  let changed = false;
  for (let i = 0; i < values.length; i++) {
    if (Math.abs(array[at + i] - values[i]) <= STILL) continue;
    array[at + i] = values[i];
    changed = true;
  }
  return changed;
}

/** What is made of pieces whose number changes. */
class Counted {
  /** @param {Mesh | LineSegments2} mesh that shows them */
  constructor(mesh) {
    this.mesh = mesh;
    this.mesh.frustumCulled = false;
    this.mesh.raycast = () => {};
    this.count = 0;
    this._shown = -1;
    this._changed = true;
  }

  clear() {
    this.count = 0;
  }

  /** Show what was added; returns whether it is something else than before. */
  show() {
    const changed = this._changed || this.count !== this._shown;
    this._changed = false;
    this._shown = this.count;
    this.mesh.visible = this.count > 0;
    if (changed && this.count) this._send();
    return changed;
  }

  /** @param {Float32Array} array @param {number} at @param {number[]} values */
  _put(array, at, values) {
    if (put(array, at, values)) this._changed = true;
  }

  /** Bring the buffers of the mesh up to date. */
  _send() {}
}

/** Line segments. */
class Lines extends Counted {
  /** @param {number} color @param {number} width [px] @param {boolean} over what is in front of them */
  constructor(color, width, over = false) {
    const material = new LineMaterial({ color: 0xffffff, vertexColors: true, linewidth: width, transparent: true, depthTest: !over });
    super(new LineSegments2(new LineSegmentsGeometry(), material));
    this.color = new Color(color);
    this.material = material;
    this.material.toneMapped = false;
    this.mesh.renderOrder = over ? 20 : 5;
    this._capacity = 0;
    this._grow(64);
  }

  /** @param {number} capacity segments */
  _grow(capacity) {
    const places = new Float32Array(6 * capacity), colors = new Float32Array(6 * capacity);
    if (this._places) {
      places.set(this._places.array);
      colors.set(/** @type {InstancedInterleavedBuffer} */ (this._colors).array);
    }
    this._places = new InstancedInterleavedBuffer(places, 6, 1).setUsage(DynamicDrawUsage);
    this._colors = new InstancedInterleavedBuffer(colors, 6, 1).setUsage(DynamicDrawUsage);
    this.mesh.geometry.dispose();
    const geometry = new LineSegmentsGeometry();
    geometry.setAttribute("instanceStart", new InterleavedBufferAttribute(this._places, 3, 0));
    geometry.setAttribute("instanceEnd", new InterleavedBufferAttribute(this._places, 3, 3));
    geometry.setAttribute("instanceColorStart", new InterleavedBufferAttribute(this._colors, 3, 0));
    geometry.setAttribute("instanceColorEnd", new InterleavedBufferAttribute(this._colors, 3, 3));
    this.mesh.geometry = geometry;
    this._capacity = capacity;
  }

  /** @param {Vector3} from @param {Vector3} to @param {Color} color */
  add(from, to, color = this.color) {
    if (this.count === this._capacity) this._grow(2 * this._capacity);
    const at = 6 * this.count++, places = [from.x, from.y, from.z, to.x, to.y, to.z];
    this._put(/** @type {any} */ (this._places).array, at, places);
    const colors = [color.r, color.g, color.b, color.r, color.g, color.b];
    this._put(/** @type {any} */ (this._colors).array, at, colors);
  }

  _send() {
    /** @type {LineSegmentsGeometry} */ (this.mesh.geometry).instanceCount = this.count;
    for (const buffer of [this._places, this._colors]) /** @type {InstancedInterleavedBuffer} */ (buffer).needsUpdate = true;
  }
}

/** Triangles that can be seen through. */
class Faces extends Counted {
  /** @param {number} color @param {number} opacity */
  constructor(color, opacity) {
    super(new Mesh(new BufferGeometry(), new MeshBasicMaterial({ color, transparent: true, opacity, side: DoubleSide, depthWrite: false, toneMapped: false })));
    this.mesh.renderOrder = 4;
    this._places = new Float32Array(9 * 256);
  }

  /** @param {Vector3} p @param {Vector3} q @param {Vector3} r */
  add(p, q, r) {
    if (9 * (this.count + 1) > this._places.length) {
      const larger = new Float32Array(2 * this._places.length);
      larger.set(this._places);
      this._places = larger;
    }
    this._put(this._places, 9 * this.count++, [p.x, p.y, p.z, q.x, q.y, q.z, r.x, r.y, r.z]);
  }

  _send() {
    let places = /** @type {BufferAttribute | undefined} */ (this.mesh.geometry.getAttribute("position"));
    if (!places || places.array !== this._places) {
      this.mesh.geometry.dispose();
      places = new BufferAttribute(this._places, 3).setUsage(DynamicDrawUsage);
      this.mesh.geometry = new BufferGeometry().setAttribute("position", places);
    }
    this.mesh.geometry.setDrawRange(0, 3 * this.count);
    places.needsUpdate = true;
  }
}

/** Shows marks of the present state. */
export class Marks {
  /** @param {Store} store @param {Bodies} bodies @param {Assets} assets @param {() => void} changed */
  constructor(store, bodies, assets, changed) {
    this.store = store;
    this.changed = changed;
    this.bodies = bodies;
    this.assets = assets;
    this.group = new Group();
    this.lines = {
      lasers: new Lines(COLORS.lasers, 1),
      sonars: new Lines(COLORS.sonars, 1),
      frusta: new Lines(COLORS.frusta, 1.5),
      contacts: new Lines(COLORS.contacts, 3, true),
      forces: new Lines(COLORS.forces, 3, true),
      axes: new Lines(COLORS.axes, 3, true),
      masses: new Lines(COLORS.masses, 2.5, true),
      inertia: new Lines(COLORS.inertia, 1.5, true),
      frames: new Lines(RED, 2.5, true),
      boxes: new Lines(COLORS.boxes, 1.2),
      trails: new Lines(COLORS.trails, 2.5),
    };
    this.faces = { lasers: new Faces(COLORS.lasers, 0.16), sonars: new Faces(COLORS.sonars, 0.16) };
    for (const { mesh } of [...Object.values(this.lines), ...Object.values(this.faces)]) this.group.add(mesh);
    this._names = new Group();
    this._screens = new Group();
    this.group.add(this._names, this._screens);
    /** @type {Map<number, Vector3[]>} */
    this._past = new Map();
    this._steps = 0;
    /** @type {string | null} name of the only part that is shown */
    this._only = null;
    /** @type {Map<number, number>} body -> row */
    this._rows = new Map();
    this._ink = "#1b1f24";
    this._paper = "rgba(255,255,255,0.82)";
  }

  /** @param {"light" | "dark"} theme */
  theme(theme) {
    this._ink = theme === "dark" ? "#eef2f7" : "#1b1f24";
    this._paper = theme === "dark" ? "rgba(23,25,29,0.78)" : "rgba(255,255,255,0.82)";
    for (const sprite of this._names.children) disposeSprite(/** @type {Sprite} */ (sprite));
    this._names.clear();
  }

  /** Take up a scene. */
  build() {
    this._rows.clear();
    const { scene } = this.store;
    for (const entity of scene.entities) for (const body of entity.bodies) this._rows.set(body.id, body.row);
    this.refresh();
  }

  /** Bring all marks that are on up to date; returns whether any has changed. */
  refresh() {
    const { store } = this, { scene } = store;
    if (!scene || !store.state) return false;
    for (const mark of [...Object.values(this.lines), ...Object.values(this.faces)]) mark.clear();
    /** @type {Set<string>} */
    const ranges = new Set(), images = new Set();
    for (const entity of scene.entities) {
      const on = (/** @type {string} */ name) => store.isOn(name, entity.number) && !store.isOn("hidden", entity.number);
      const part = store.selection?.entity === entity.number ? store.selection.part : undefined;
      this._only = null;
      if (on("lasers")) this._lasers(entity, ranges);
      if (on("sonars")) this._sonars(entity, ranges);
      if (on("frusta")) this._frusta(entity, images);
      if (on("axes")) this._axes(entity);
      if (on("masses")) this._masses(entity);
      if (on("inertia")) this._inertia(entity);
      if (on("frames")) this._frames(entity);
      if (on("boxes")) this._box(entity);
      if (on("trails")) this._trail(entity);
      else this._past.delete(entity.number);
      // What is selected of a model shows itself.
      this._only = part?.name ?? null;
      if (part?.kind === "joint" && !on("axes")) this._axes(entity);
      if (part?.kind === "body" && !on("frames")) this._frames(entity);
      if (part?.kind === "sensor" && !on("lasers")) this._lasers(entity, ranges);
      if (part?.kind === "sensor" && !on("sonars")) this._sonars(entity, ranges);
      if (part?.kind === "sensor" && !on("frusta")) this._frusta(entity, images);
    }
    this._contacts();
    this._steps = store.state.steps;
    this._want("ranges", ranges);
    this._want("images", images);
    this._keepScreens(images);
    const shown = [...Object.values(this.lines), ...Object.values(this.faces)].map((mark) => mark.show());
    return this._name() || shown.some((changed) => changed);
  }

  /** Subscribe to what the marks show. @param {string} channel @param {Set<string>} names */
  _want(channel, names) {
    const wanted = [...names].sort(), key = `_wanted_${channel}`, self = /** @type {any} */ (this);
    if (String(self[key] ?? "") === String(wanted)) return;
    self[key] = wanted;
    this.store.want(channel, wanted, "stage");
  }

  /** Let marks that have a size in pixels know the size of the view. @param {any} camera @param {any} renderer */
  face(camera, renderer) {
    const size = renderer.getSize(new Vector2());
    for (const { material } of Object.values(this.lines)) material.resolution.copy(size);
    this._height = size.y;
    const far = this._farthest(camera.position);
    for (const sprite of this._names.children) {
      sprite.visible = sprite.position.distanceToSquared(camera.position) <= far;
      // As many pixels high on each screen, nearer or farther.
      const share = (2 * Math.tan((camera.fov * Math.PI) / 360)) / Math.max(size.y, 1);
      sprite.scale.set(sprite.userData.width * share, sprite.userData.height * share, 1);
    }
  }

  /** How far from the eye names are shown, squared [m²]: of many, the nearest. @param {Vector3} eye */
  _farthest(eye) {
    const { children } = this._names;
    if (children.length <= MOST_NAMES) return Infinity;
    return children.map(({ position }) => position.distanceToSquared(eye)).sort((one, other) => one - other)[MOST_NAMES - 1];
  }

  /** Where a body is. @param {number} body 0 for the world @param {Matrix4} into @returns {Matrix4 | null} */
  _frame(body, into) {
    if (body === 0) return into.identity();
    const pose = this.store.bodyPose(this._rows.get(body) ?? -1);
    return pose && placed(pose, 0, into);
  }

  /** The parts of a model that are shown. @param {any[]} parts */
  _wanted(parts) {
    return this._only === null ? parts : parts.filter((part) => part.name === this._only);
  }

  // Sensors -----------------------------------------------------------------------------------------------------------

  /** @param {any} entity @param {Set<string>} wanted */
  _lasers(entity, wanted) {
    for (const sensor of this._wanted(entity.sensors)) {
      if (sensor.kind === "rays") {
        const served = entity.interfaces.find((/** @type {any} */ one) => one.type === "laser" || one.type === "fiducial");
        const frame = served && this._frame(sensor.body, matrix), rays = this.assets.arrays(sensor.data)?.rays;
        if (!frame || !rays?.length) continue;
        const name = `laser.${served.id}`, count = rays.length / 7;
        if (served.type === "laser") wanted.add(name);
        const ranges = this.store.ranges.get(name);
        this._fan(frame, count, (i, start, end) => {
          start.fromArray(rays, 7 * i);
          let reach = rays[7 * i + 6];
          if (ranges && ranges.length > 1 && count > 1) {
            reach = Math.min(ranges[Math.round((i * (ranges.length - 1)) / (count - 1))], reach);
          }
          end.fromArray(rays, 7 * i + 3).multiplyScalar(reach).add(start);
        });
      } else if (sensor.rays) {
        const frame = this._frame(sensor.body, matrix);
        if (!frame) continue;
        frame.multiply(placed(sensor.pose, 0, inner));
        const name = sensorName(entity, sensor);
        wanted.add(name);
        const ranges = this.store.ranges.get(name);
        for (const { min, max, horizontal: flat, vertical: upright } of sensor.rays) {
          const count = Math.min(Math.max(flat.samples, 2), RAYS);
          const tilts = upright ? [...new Set([upright.min_angle ?? 0, upright.max_angle ?? 0])] : [0];
          for (const tilt of tilts) {
            this._fan(frame, count, (i, start, end) => {
              const angle = (flat.min_angle ?? 0) + (((flat.max_angle ?? 0) - (flat.min_angle ?? 0)) * i) / (count - 1);
              let reach = Math.min(max ?? 10, LONGEST_RAY);
              if (ranges && ranges.length > 1 && tilts.length === 1) {
                const seen = ranges[Math.round((i * (ranges.length - 1)) / (count - 1))];
                if (seen >= 0) reach = Math.min(seen, reach);
              }
              start.set(Math.cos(angle) * Math.cos(tilt), Math.sin(angle) * Math.cos(tilt), Math.sin(tilt));
              end.copy(start).multiplyScalar(Math.max(reach, min ?? 0));
              start.multiplyScalar(min ?? 0);
            });
          }
        }
      }
    }
  }

  /**
   * A surface between rays, and every few a line.
   * @param {Matrix4} frame
   * @param {number} count
   * @param {(i: number, start: Vector3, end: Vector3) => void} ray
   */
  _fan(frame, count, ray) {
    const step = Math.max(1, Math.floor(count / (RAYS - 1))), every = Math.max(1, Math.round(count / 24));
    let [start, end, last, lastEnd] = [new Vector3(), new Vector3(), new Vector3(), new Vector3()];
    let first = true;
    for (let i = 0; i < count; i += step) {
      ray(i, start, end);
      start.applyMatrix4(frame);
      end.applyMatrix4(frame);
      if (!first) {
        this.faces.lasers.add(last, lastEnd, end);
        if (start.distanceToSquared(last) > 1e-8) this.faces.lasers.add(last, end, start);
        this.lines.lasers.add(lastEnd, end);
      }
      if (i % every < step) this.lines.lasers.add(start, end);
      [start, last, end, lastEnd] = [last, start, lastEnd, end];
      first = false;
    }
  }

  /** @param {any} entity @param {Set<string>} wanted */
  _sonars(entity, wanted) {
    for (const served of entity.interfaces) {
      if (served.type !== "sonar" && served.type !== "ir") continue;
      const name = `${served.type}.${served.id}`;
      wanted.add(name);
      const ring = this.store.rings?.get(name), pose = this.store.entityPose(entity.number);
      if (!ring || !pose) continue;
      placed(pose, 0, matrix);
      ring.positions.forEach((/** @type {number[]} */ at, /** @type {number} */ i) => {
        const half = ring.directions[i] / 2, reach = ring.ranges[i];
        if (!(reach > 0)) return;
        placed([...at, Math.cos(half), 0, 0, Math.sin(half)], 0, inner).premultiply(matrix);
        this._cone(inner, reach, reach * Math.tan(CONE));
      });
    }
    for (const sensor of this._wanted(entity.sensors)) {
      if (!sensor.cones?.length) continue;
      const frame = this._frame(sensor.body, matrix);
      if (!frame) continue;
      frame.multiply(placed(sensor.pose, 0, inner));
      const name = sensorName(entity, sensor);
      wanted.add(name);
      const seen = this.store.ranges.get(name)?.[0];
      for (const cone of sensor.cones) {
        const reach = seen !== undefined && seen >= 0 ? Math.min(seen, cone.max ?? 1) : cone.max ?? 1;
        this._cone(frame, reach, (cone.radius * reach) / (cone.max || 1));
      }
    }
  }

  /** A cone along x. @param {Matrix4} frame @param {number} length @param {number} radius [m] */
  _cone(frame, length, radius) {
    const tip = new Vector3().applyMatrix4(frame);
    /** @type {Vector3[]} */
    const rim = [];
    for (let i = 0; i < 16; i++) {
      const angle = (Math.PI * i) / 8;
      rim.push(new Vector3(length, radius * Math.cos(angle), radius * Math.sin(angle)).applyMatrix4(frame));
    }
    rim.forEach((point, i) => {
      this.faces.sonars.add(tip, point, rim[(i + 1) % 16]);
      this.lines.sonars.add(point, rim[(i + 1) % 16]);
    });
  }

  /** @param {any} entity @param {Set<string>} wanted */
  _frusta(entity, wanted) {
    for (const sensor of this._wanted(entity.sensors)) {
      const cameras = sensor.kind === "camera" && "fov" in sensor ? [sensor] : sensor.cameras ?? [];
      cameras.forEach((/** @type {any} */ camera, /** @type {number} */ i) => {
        const frame = this._frame(sensor.body, matrix);
        if (!frame) return;
        frame.multiply(placed(sensor.pose, 0, inner));
        if (camera !== sensor) frame.multiply(placed(camera.pose, 0, inner));
        const half = Math.tan(Math.min(camera.fov, 3) / 2), upright = half / Math.max(camera.aspect || 1, 1e-3);
        const depth = Math.min(camera.far ?? LONGEST_FRUSTUM, LONGEST_FRUSTUM);
        const tip = new Vector3().applyMatrix4(frame);
        const corners = [[1, 1], [-1, 1], [-1, -1], [1, -1]].map(([y, z]) =>
          new Vector3(depth, depth * half * y, depth * upright * z).applyMatrix4(frame));
        corners.forEach((corner, k) => {
          this.lines.frusta.add(tip, corner);
          this.lines.frusta.add(corner, corners[(k + 1) % 4]);
        });
        const name = imageName(entity, sensor);
        if (!name || i > 0) return;
        wanted.add(name);
        this._screen(name, frame, half, upright);
      });
    }
  }

  /** A camera's last image, before it. @param {string} name @param {Matrix4} frame @param {number} half @param {number} upright */
  _screen(name, frame, half, upright) {
    const address = this.store.images.get(name);
    if (!address) return;
    let screen = /** @type {Mesh<PlaneGeometry, MeshBasicMaterial> | undefined} */ (this._screens.getObjectByName(name));
    if (!screen) {
      screen = new Mesh(new PlaneGeometry(1, 1), new MeshBasicMaterial({ side: DoubleSide, toneMapped: false }));
      screen.name = name;
      screen.matrixAutoUpdate = false;
      screen.raycast = () => {};
      screen.visible = false;
      this._screens.add(screen);
    }
    if (screen.userData.address !== address) {
      screen.userData.address = address;
      const shown = screen;
      new TextureLoader().load(address, (texture) => {
        texture.colorSpace = SRGBColorSpace;
        shown.material.map?.dispose();
        shown.material.needsUpdate = !shown.material.map;
        shown.material.map = texture;
        shown.visible = true;
        this.changed();
      });
    }
    // From an image's axes, right and up, to a camera's, which looks along x.
    inner.set(0, 0, 1, SCREEN, -2 * SCREEN * half, 0, 0, 0, 0, 2 * SCREEN * upright, 0, 0, 0, 0, 0, 1);
    screen.matrix.multiplyMatrices(frame, inner);
  }

  /** @param {Set<string>} names */
  _keepScreens(names) {
    for (const child of [...this._screens.children]) {
      if (names.has(child.name)) continue;
      const screen = /** @type {Mesh<PlaneGeometry, MeshBasicMaterial>} */ (child);
      screen.material.map?.dispose();
      screen.material.dispose();
      screen.geometry.dispose();
      screen.removeFromParent();
      this.changed();
    }
  }

  // Mechanics ---------------------------------------------------------------------------------------------------------

  _contacts() {
    const { store } = this;
    const global = ["contacts", "forces"].map((name) => store.isOn(name));
    const per = (/** @type {string} */ name) => store.scene.entities.some((/** @type {any} */ e) => store.isOn(name, e.number));
    const wanted = global[0] || global[1] || per("contacts") || per("forces");
    this._want("contacts", new Set(wanted ? ["*"] : []));
    if (!wanted) return;
    for (const contact of store.contacts ?? []) {
      const { position, normal, force, entities } = contact;
      const on = (/** @type {string} */ name) =>
        entities?.length ? entities.some((/** @type {number} */ number) => store.isOn(name, number)) : store.isOn(name);
      a.fromArray(position);
      if (on("contacts")) {
        const arms = 0.02;
        for (const axis of [0, 1, 2]) {
          b.copy(a).setComponent(axis, a.getComponent(axis) - arms);
          this.lines.contacts.add(b, b.clone().setComponent(axis, a.getComponent(axis) + arms));
        }
        this.lines.contacts.add(a, b.fromArray(normal).multiplyScalar(0.12).add(a));
      }
      if (force && on("forces")) {
        b.fromArray(force).multiplyScalar(FORCE).clampLength(0, LONGEST_FORCE).add(a);
        this._arrow(this.lines.forces, a, b);
      }
    }
  }

  /** @param {Lines} lines @param {Vector3} from @param {Vector3} to @param {Color} [color] */
  _arrow(lines, from, to, color) {
    lines.add(from, to, color);
    const along = to.clone().sub(from), length = along.length();
    if (length < 1e-6) return;
    along.divideScalar(length);
    const side = new Vector3(0, 0, 1).cross(along);
    if (side.lengthSq() < 1e-4) side.set(1, 0, 0);
    side.normalize();
    const head = Math.min(0.25 * length, 0.05);
    for (const sign of [1, -1]) {
      lines.add(to, to.clone().addScaledVector(along, -head).addScaledVector(side, 0.5 * sign * head), color);
    }
  }

  /** @param {any} entity */
  _axes(entity) {
    for (const joint of this._wanted(entity.joints)) {
      const frame = this._frame(joint.frame, matrix);
      if (!frame) continue;
      for (const axis of joint.axes) {
        a.fromArray(joint.anchor).applyMatrix4(frame);
        b.fromArray(axis).normalize().multiplyScalar(0.22).add(new Vector3().fromArray(joint.anchor)).applyMatrix4(frame);
        this._arrow(this.lines.axes, a, b.clone());
        const back = a.clone().lerp(b, -0.35);
        this.lines.axes.add(a, back);
      }
    }
  }

  /** @param {any} entity */
  _masses(entity) {
    const { state } = this.store, columns = state.bodyColumns ?? 16;
    if (columns < 10) return;
    for (const body of entity.bodies) {
      if (body.static || body.row < 0 || columns * (body.row + 1) > state.bodies.length) continue;
      a.fromArray(state.bodies, columns * body.row + 7);
      for (const axis of [0, 1, 2]) {
        b.copy(a).setComponent(axis, a.getComponent(axis) - 0.05);
        this.lines.masses.add(b, b.clone().setComponent(axis, a.getComponent(axis) + 0.05));
      }
    }
  }

  /** Boxes of even density with the masses and inertias of the bodies. @param {any} entity */
  _inertia(entity) {
    const { state } = this.store, columns = state.bodyColumns ?? 16;
    for (const body of entity.bodies) {
      const frame = body.inertia && body.mass > 0 ? this._frame(body.id, matrix) : null;
      if (!frame || columns < 10) continue;
      const { values, axes } = principal(body.inertia), [x, y, z] = values;
      const sides = [y + z - x, x + z - y, x + y - z].map((sum) => Math.sqrt((6 * Math.max(sum, 0)) / body.mass) / 2);
      inner.makeBasis(axes[0], axes[1], axes[2]);
      frame.multiply(inner).setPosition(a.fromArray(state.bodies, columns * body.row + 7));
      this._edges(this.lines.inertia, (i) =>
        new Vector3(i & 1 ? sides[0] : -sides[0], i & 2 ? sides[1] : -sides[1], i & 4 ? sides[2] : -sides[2]).applyMatrix4(frame));
    }
  }

  /** @param {any} entity */
  _frames(entity) {
    for (const body of this._wanted(entity.bodies)) {
      const frame = this._frame(body.id, matrix);
      if (!frame) continue;
      a.setFromMatrixPosition(frame);
      [RED, GREEN, BLUE].forEach((color, axis) => {
        b.setFromMatrixColumn(frame, axis).multiplyScalar(0.15).add(a);
        this.lines.frames.add(a, b, new Color(color));
      });
    }
  }

  /** @param {any} entity */
  _box(entity) {
    const box = this.bodies.bounds([entity.number]);
    if (box.isEmpty()) return;
    this._edges(this.lines.boxes, (i) =>
      new Vector3(i & 1 ? box.max.x : box.min.x, i & 2 ? box.max.y : box.min.y, i & 4 ? box.max.z : box.min.z));
  }

  /** The twelve edges of a box. @param {Lines} lines @param {(i: number) => Vector3} corner by its bits x, y, z */
  _edges(lines, corner) {
    for (let i = 0; i < 8; i++) {
      for (const bit of [1, 2, 4]) if (!(i & bit)) lines.add(corner(i), corner(i | bit));
    }
  }

  /** Where a model that moves has been. @param {any} entity */
  _trail(entity) {
    if (entity.static || entity.parent || !entity.bodies.length) return;
    const { store } = this, pose = store.entityPose(entity.number);
    if (!pose) return;
    if (store.state.steps < this._steps) this._past.clear(); // a reset, or back in time
    let past = this._past.get(entity.number);
    if (!past) {
      past = [];
      this._past.set(entity.number, past);
    }
    const here = new Vector3(pose[0], pose[1], Math.max(pose[2], this.bodies.bounds([entity.number]).min.z + 0.03));
    if (!past.length || here.distanceTo(past[past.length - 1]) > TRAIL_STEP) past.push(here);
    if (past.length > TRAIL) past.shift();
    for (let i = 1; i < past.length; i++) this.lines.trails.add(past[i - 1], past[i]);
  }

  // Names -------------------------------------------------------------------------------------------------------------

  /** Names above models; returns whether they have changed. */
  _name() {
    const { store } = this;
    let changed = false;
    /** @type {Map<string, any>} */
    const wanted = new Map();
    for (const entity of store.scene.entities) {
      const ground = this.bodies.of.get(entity.number)?.every((one) => one.ground);
      if (store.isOn("names", entity.number) && !store.isOn("hidden", entity.number) && !ground) wanted.set(entity.id, entity);
    }
    for (const sprite of [...this._names.children]) {
      if (wanted.has(sprite.name)) continue;
      disposeSprite(/** @type {Sprite} */ (sprite));
      sprite.removeFromParent();
      changed = true;
    }
    for (const [name, entity] of wanted) {
      const box = this.bodies.bounds([entity.number]), pose = store.entityPose(entity.number);
      if (!pose) continue;
      let sprite = this._names.getObjectByName(name);
      if (!sprite) {
        sprite = this._sprite(name);
        this._names.add(sprite);
      }
      a.set(pose[0], pose[1], box.isEmpty() ? pose[2] : box.max.z + 0.06);
      if (a.distanceTo(sprite.position) <= STILL) continue;
      sprite.position.copy(a);
      changed = true;
    }
    return changed;
  }

  /** @param {string} text */
  _sprite(text) {
    const canvas = document.createElement("canvas"), ratio = 2, font = `${13 * ratio}px system-ui, sans-serif`;
    const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
    context.font = font;
    canvas.width = Math.min(Math.ceil(context.measureText(text).width) + 14 * ratio, 1024);
    canvas.height = 20 * ratio;
    context.font = font;
    context.fillStyle = this._paper;
    context.beginPath();
    context.roundRect(0, 0, canvas.width, canvas.height, 5 * ratio);
    context.fill();
    context.fillStyle = this._ink;
    context.textBaseline = "middle";
    context.fillText(text, 7 * ratio, canvas.height / 2 + 1);
    const map = new CanvasTexture(canvas);
    map.colorSpace = SRGBColorSpace;
    const sprite = new Sprite(new SpriteMaterial({ map, sizeAttenuation: false, depthTest: false, toneMapped: false, fog: false }));
    sprite.name = text;
    sprite.center.set(0.5, 0);
    sprite.renderOrder = 30;
    sprite.raycast = () => {};
    sprite.userData = { width: canvas.width / ratio, height: canvas.height / ratio };
    return sprite;
  }
}

/** @param {Sprite} sprite */
function disposeSprite(sprite) {
  sprite.material.map?.dispose();
  sprite.material.dispose();
}

/** ``model::link::sensor``. @param {any} entity @param {any} sensor */
function sensorName(entity, sensor) {
  const body = entity.bodies.find((/** @type {any} */ one) => one.id === sensor.body);
  return `${entity.id}::${body?.name ?? ""}::${sensor.name ?? ""}`;
}

/** The name of a camera's image: the id of its interface, or ``model::link::sensor``; empty for none. @param {any} entity @param {any} sensor */
function imageName(entity, sensor) {
  if ("name" in sensor) return sensorName(entity, sensor);
  return entity.interfaces.find((/** @type {any} */ one) => one.type === "camera")?.id ?? "";
}

/**
 * Principal values and axes of an inertia, by Jacobi's rotations.
 * @param {number[]} inertia Ixx, Iyy, Izz, Ixy, Ixz, Iyz [kg m²]
 */
function principal([xx, yy, zz, xy, xz, yz]) {
  const m = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]], v = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
  for (let sweep = 0; sweep < 12; sweep++) {
    for (const [p, q] of [[0, 1], [0, 2], [1, 2]]) {
      if (Math.abs(m[p][q]) < 1e-15) continue;
      const theta = (m[q][q] - m[p][p]) / (2 * m[p][q]);
      const t = (theta < 0 ? -1 : 1) / (Math.abs(theta) + Math.sqrt(theta * theta + 1));
      const c = 1 / Math.sqrt(t * t + 1), s = t * c;
      for (const row of m) [row[p], row[q]] = [c * row[p] - s * row[q], s * row[p] + c * row[q]];
      [m[p], m[q]] = [m[p].map((value, k) => c * value - s * m[q][k]), m[q].map((value, k) => s * m[p][k] + c * value)];
      for (const row of v) [row[p], row[q]] = [c * row[p] - s * row[q], s * row[p] + c * row[q]];
    }
  }
  return { values: [m[0][0], m[1][1], m[2][2]], axes: [0, 1, 2].map((k) => new Vector3(v[0][k], v[1][k], v[2][k])) };
}
