// Stage: the 3D view. It shows the store's scene and state, and renders only when something has changed.

import {
  Box3,
  NeutralToneMapping,
  PCFShadowMap,
  Plane,
  Raycaster,
  Scene,
  Vector2,
  Vector3,
  WebGLRenderer,
} from "three";
import { Assets } from "libgz/assets.js";
import { Bodies, bodiesOf } from "libgz/bodies.js";
import { Cameras } from "libgz/cameras.js";
import { Ground } from "libgz/ground.js";
import { Handles } from "libgz/handles.js";
import { Lights } from "libgz/lights.js";
import { Marks } from "libgz/marks.js";
import { Occlusion } from "libgz/occlusion.js";
import { Outline } from "libgz/outline.js";
import { isSoftware, Quality } from "libgz/quality.js";
import { Skins } from "libgz/skins.js";
import { Sky } from "libgz/sky.js";

/** @typedef {import("libgz/store.js").Store} Store */

const CLICK = 5; // [px] that the pointer may move between press and release of a click
const HOVER = 40; // [ms] that the pointer rests before what is under it is looked for
const REST = 500; // [ms] without changes until a still image is refined
const NEAREST = 0.02, FARTHEST = 2500; // [m] around what is looked at that shadows cover
const LARGE = 15; // [m] from which a flat mesh is ground
const SWITCHES_OF_SHAPES = ["hidden", "wireframe", "collisions", "transparent", "skins"];

/** The 3D view. */
export class Stage {
  /**
   * @param {HTMLElement} parent
   * @param {Store} store
   * @param {{quality?: string | null}} options "best" or "fast" instead of what the page chooses
   */
  constructor(parent, store, { quality = null } = {}) {
    this.parent = parent;
    this.store = store;
    this.canvas = document.createElement("canvas");
    this.canvas.className = "stage-canvas";
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute("aria-label", "3D view");
    parent.append(this.canvas);
    const context = document.createElement("canvas").getContext("webgl2");
    if (!context) {
      parent.textContent = "The 3D view needs WebGL 2, which this browser does not have or has switched off.";
      throw new Error(parent.textContent);
    }
    const software = isSoftware(context);
    context.getExtension("WEBGL_lose_context")?.loseContext(); // browsers allow few at a time
    this.renderer = new WebGLRenderer({
      canvas: this.canvas,
      antialias: !software || quality === "best",
      powerPreference: "high-performance",
    });
    this.renderer.toneMapping = NeutralToneMapping;
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = PCFShadowMap;
    this.renderer.shadowMap.autoUpdate = false;
    this.renderer.info.autoReset = true;
    this.quality = new Quality(software, quality);
    this.software = software;

    this.assets = new Assets();
    this.bodies = new Bodies(store, this.assets);
    this.skins = new Skins(store, this.assets, this.bodies);
    this.lights = new Lights(store);
    this.sky = new Sky();
    this.ground = new Ground();
    this.outline = new Outline(this.bodies, this.skins);
    this.occlusion = new Occlusion();
    this.cameras = new Cameras(this.canvas, store, this.bodies, () => this.invalidate());
    this.marks = new Marks(store, this.bodies, this.assets, () => this.invalidate());
    this.handles = new Handles(this.cameras, this.canvas, store, () => this.invalidate());
    this.scene = new Scene();
    this.scene.add(
      this.bodies.group, this.skins.group, this.lights.group, this.sky.mesh, this.ground.mesh, this.ground.relief,
      this.marks.group, this.handles.group,
    );

    /** Whether a complete frame of the world has been shown. */
    this.ready = false;
    /** Files of the scene: how many have arrived, and how many there are. */
    this.progress = { done: 0, total: 0 };
    this._dirty = true;
    this._frame = 0;
    this._changed = 0; // [ms] when something last changed
    this._refined = false;
    this._outdated = false; // whether there is another level than the last frame was rendered with
    this._built = false; // whether the shapes of the present scene are shown
    this._loading = 0;
    this._loaded = false; // what the scene names has been loaded
    this._world = ""; // that the camera is placed for
    this._begins = false; // whether that is still to be done
    this._former = store.state; // the state when the scene came, which is that of another scene
    this._empty = false; // whether nothing moves in it
    this._shapes = ""; // the switches that the shapes are shown by
    this._fine = this.quality.level.fine;
    this._level = 0; // [m] of the ground
    this._applyLevel();
    this._listen();
    new ResizeObserver(() => this._resize()).observe(parent);
    this._resize();
    this._show();
  }

  // Events of the store -----------------------------------------------------------------------------------------------

  _listen() {
    const { store } = this;
    const on = (/** @type {string} */ name, /** @type {(event: any) => void} */ act) => store.addEventListener(name, act);
    on("scene", () => this._load());
    on("state", () => this._move());
    on("selection", () => this._choose());
    on("switches", () => this._switch());
    on("theme", () => this._rebuild());
    on("handles", () => this.handles.choose());
    on("follow", () => this.invalidate());
    on("hover", () => this._choose());
    on("view", (event) => {
      this.cameras.touched = true;
      this.cameras.show(event.detail ?? store.viewed);
    });
    for (const name of ["ranges", "images", "contacts"]) on(name, () => this.marks.refresh() && this.invalidate());
    const { canvas } = this;
    /** @type {{x: number, y: number} | null} */
    let pressed = null;
    canvas.addEventListener("pointerdown", (event) => {
      pressed = event.button === 0 ? { x: event.clientX, y: event.clientY } : null;
      canvas.focus({ preventScroll: true });
    });
    canvas.addEventListener("pointerup", (event) => {
      const still = pressed && Math.hypot(event.clientX - pressed.x, event.clientY - pressed.y) < CLICK;
      pressed = null;
      if (still && !this.handles.busy) this._click(event.clientX, event.clientY);
    });
    canvas.addEventListener("dblclick", (event) => {
      const hit = this.pick(event.clientX, event.clientY);
      if (hit?.entity) this.cameras.focus(hit.entity);
    });
    let looking = 0, rest = HOVER;
    canvas.addEventListener("pointermove", (event) => {
      const { clientX: x, clientY: y } = event;
      clearTimeout(looking);
      if (event.pointerType !== "mouse" || event.buttons) return;
      looking = window.setTimeout(() => {
        const begin = performance.now();
        this._hover(x, y);
        rest = Math.max(HOVER, 3 * (performance.now() - begin)); // of large meshes less often
      }, rest);
    });
    canvas.addEventListener("pointerleave", () => {
      clearTimeout(looking);
      this._point(null);
    });
    canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
    canvas.addEventListener("webglcontextrestored", () => this._rebuild());
  }

  /** Load what the scene names, then show it. Until then the former scene stays. */
  async _load() {
    const { store } = this, { scene } = store;
    if (!scene) return;
    const turn = ++this._loading;
    this._former = store.state;
    await this.assets.load(scene, () => {
      const [done, total] = this.assets.progress;
      this.progress = { done, total };
      store.dispatchEvent(new Event("progress"));
    });
    if (turn !== this._loading) return;
    this._loaded = true;
    if (store.state) this._build();
  }

  /** Show the scene, which has been loaded, and its state. */
  _build() {
    const { scene } = this.store;
    this._built = true;
    this._rebuild();
    const world = `${scene.era} ${scene.world}`, empty = !this.cameras.hasMovers;
    const first = this._empty && !empty && !this.cameras.touched; // something was put into an empty world
    this._empty = empty;
    this._begins ||= world !== this._world || first;
    this._world = world;
    this._begin();
    this.invalidate();
  }

  /** Place the camera for another world, once there is a state with all that is in its scene. */
  _begin() {
    if (!this._begins || this.store.state === this._former) return;
    this._begins = false;
    this.cameras.begin(this.lights.towards, (eye, place, radius) => this._sees(eye, place, radius));
  }

  _rebuild() {
    if (!this._built || !this.store.scene) return;
    this._show();
    this.bodies.build({ fine: this.quality.level.fine, dark: this.store.theme === "dark" });
    this.skins.build();
    this.marks.build();
    this._ground();
    this._choose();
    this.invalidate(true);
  }

  /** The sky, the grid and the lights, which depend on scene and theme. */
  _show() {
    const { store } = this, theme = store.theme === "dark" ? "dark" : "light";
    const scene = this._built ? store.scene : null;
    this.scene.fog = this.sky.show(scene, this.assets, theme);
    if (scene) {
      const { fine } = this.quality.level;
      this.lights.build(this.sky.zenith, fine);
      this.sky.turn(this.lights.towards);
      this.scene.environment = fine ? this.sky.reflection(this.renderer) : null;
      this.scene.environmentIntensity = 0.42;
    }
    this.ground.show(theme, this._level);
    this.marks.theme(theme);
    this.renderer.setClearColor(this.sky.horizon);
    this.parent.style.background = `#${this.sky.horizon.getHexString()}`;
    this.invalidate(true);
  }

  /** Where the ground is, for the camera and the grid. */
  _ground() {
    /** @type {number[]} */
    const levels = [];
    /** @type {{heights: any, shape: number[], size: number[], x: number, y: number, z: number}[]} */
    const fields = [];
    for (const [, body] of bodiesOf(this.store.scene)) {
      for (const shape of body.shapes) {
        if (shape.kind === "plane" && shape.normal[2] > 0.99) levels.push(shape.altitude);
        if (shape.kind === "heightfield") {
          const arrays = this.assets.arrays(shape.data);
          const box = this.bodies.bounds([]);
          for (const instance of this.bodies.instances) {
            if (instance.shape !== shape) continue;
            const { geometry } = instance.batch;
            if (!geometry.boundingBox) geometry.computeBoundingBox();
            box.union(/** @type {Box3} */ (geometry.boundingBox).clone().applyMatrix4(this.bodies.matrix(instance, instance.batch.mesh.matrix.clone())));
          }
          if (arrays && !box.isEmpty()) {
            const middle = box.getCenter(new Vector3());
            const least = arrays.heights.reduce((/** @type {number} */ a, /** @type {number} */ b) => Math.min(a, b), Infinity);
            fields.push({ heights: arrays.heights, shape: arrays.shapes.heights, size: shape.size, x: middle.x, y: middle.y, z: box.min.z - least });
          }
        }
      }
    }
    const hills = this.bodies.batches.filter(isHilly).map(({ mesh }) => mesh);
    const ray = new Raycaster(), down = new Vector3(0, 0, -1);
    this._level = levels.length ? Math.max(...levels) : 0;
    const level = levels.length ? this._level : -Infinity;
    this.cameras.groundAt = (x, y) => {
      let height = level;
      for (const field of fields) {
        const [rows, columns] = field.shape;
        const i = ((x - field.x) / field.size[0] + 0.5) * (columns - 1), j = ((y - field.y) / field.size[1] + 0.5) * (rows - 1);
        if (i < 0 || j < 0 || i > columns - 1 || j > rows - 1) continue;
        const a = Math.floor(i), b = Math.floor(j), a2 = Math.min(a + 1, columns - 1), b2 = Math.min(b + 1, rows - 1);
        const around = [[b, a], [b, a2], [b2, a], [b2, a2]].map(([row, column]) => field.heights[row * columns + column]);
        height = Math.max(height, field.z + Math.max(...around));
      }
      ray.set(new Vector3(x, y, 1e4), down);
      for (const { point } of ray.intersectObjects(hills, false)) height = Math.max(height, point.z);
      return height;
    };
    this.ground.cover([...hills, ...this.bodies.batches.filter(isField).map(({ mesh }) => mesh)]);
    this.ground.relief.visible = this.store.isOn("grid");
    this.ground.mesh.visible = this.store.isOn("grid") && (levels.length > 0 || !(fields.length || hills.length));
    this.ground.show(this.store.theme === "dark" ? "dark" : "light", this._level);
  }

  _move() {
    if (this._loaded && !this._built) this._build();
    if (!this._built) return;
    const moved = this.bodies.move();
    if (moved) {
      this.skins.move();
      this.lights.move();
      this.handles.follow();
    }
    this._begin();
    const marked = this.marks.refresh();
    if (moved || marked) this.invalidate(moved);
  }

  _switch() {
    const { store } = this;
    const entities = store.scene?.entities ?? [];
    const shapes = JSON.stringify(SWITCHES_OF_SHAPES.map((name) =>
      [store.isOn(name), entities.filter((/** @type {any} */ e) => store.isOn(name, e.number)).map((/** @type {any} */ e) => e.number)]));
    this.lights.shadows = store.isOn("shadows");
    if (shapes !== this._shapes) {
      this._shapes = shapes;
      this._rebuild();
    }
    if (this._built) this._ground();
    this.marks.refresh();
    this.invalidate(true);
  }

  _choose() {
    const { selection } = this.store;
    const chosen = selection ? this.bodies.family(selection.entity) : [];
    const { hover } = this.store, pointed = hover === null ? [] : this.bodies.family(hover);
    /** @type {number | null} row of the part that is selected */
    let row = null;
    if (selection?.part?.kind === "body") {
      const entity = this.store.entities.get(selection.entity);
      row = entity?.bodies.find((/** @type {any} */ body) => body.name === selection.part?.name)?.row ?? null;
    }
    if (this.marks.refresh()) this.invalidate();
    this.outline.set(chosen, pointed, row === null ? undefined : (instance) => instance.row === row);
    this.handles.choose();
    this.invalidate();
  }

  // The pointer -------------------------------------------------------------------------------------------------------

  /**
   * What is under a pixel of the window: the entity's number, 0 for none, and the place.
   * @param {number} x @param {number} y
   */
  pick(x, y) {
    const box = this.canvas.getBoundingClientRect();
    const at = new Vector2(((x - box.left) / box.width) * 2 - 1, 1 - ((y - box.top) / box.height) * 2);
    const ray = new Raycaster();
    ray.setFromCamera(at, this.cameras.camera);
    const hits = ray.intersectObjects([...this.bodies.group.children, ...this.skins.group.children], false);
    for (const { object, instanceId, point, distance } of hits) {
      const instance = object.userData.batch?.instances[instanceId ?? 0];
      const number = instance ? (instance.ground ? 0 : instance.entity) : object.userData.entity ?? 0;
      if (number && this.store.isOn("locked", number)) continue;
      return { entity: number, row: instance?.row ?? -1, point, distance };
    }
    return null;
  }

  /**
   * Whether nothing is before a ball.
   * @param {Vector3} eye
   * @param {Vector3} place its middle
   * @param {number} radius [m]
   */
  _sees(eye, place, radius) {
    const way = place.clone().sub(eye), ray = new Raycaster(eye, way.clone().normalize(), 0, Math.max(way.length() - radius, 0));
    return !ray.intersectObjects(this.bodies.group.children, false).length;
  }

  /** @param {number} x @param {number} y */
  _click(x, y) {
    const number = this.pick(x, y)?.entity ?? 0;
    this.store.select(number ? { entity: number } : null);
  }

  /** @param {number} x @param {number} y */
  _hover(x, y) {
    this._point(this.handles.busy ? null : this.pick(x, y)?.entity || null);
  }

  /** @param {number | null} number */
  _point(number) {
    if (number === this.store.hover) return;
    this.canvas.style.cursor = number === null ? "" : "pointer";
    this.store.setHover(number);
  }

  /**
   * A place on the ground under a pixel of the window; without one, free ground near the middle of the view.
   * @param {number} [x] @param {number} [y]
   * @returns {[number, number, number]}
   */
  place(x, y) {
    const box = this.canvas.getBoundingClientRect();
    const hit = this.pick(x ?? box.left + box.width / 2, y ?? box.top + box.height / 2);
    const ray = new Raycaster();
    ray.setFromCamera(
      new Vector2(x === undefined ? 0 : ((x - box.left) / box.width) * 2 - 1, y === undefined ? 0 : 1 - ((y - box.top) / box.height) * 2),
      this.cameras.camera,
    );
    const level = this._level;
    const point = x !== undefined && hit && hit.distance < 500 ? hit.point : new Vector3();
    if (x === undefined || !hit || hit.distance >= 500) {
      const found = ray.ray.intersectPlane(new Plane(new Vector3(0, 0, 1), -level), point);
      if (!found || point.distanceTo(this.cameras.camera.position) > 200) point.copy(this.cameras.controls.target).setZ(level);
    }
    if (x === undefined) this._free(point);
    const height = this.cameras.groundAt(point.x, point.y);
    return [point.x, point.y, Math.max(point.z, Number.isFinite(height) ? height : point.z)];
  }

  /** Move a point aside, in growing rings, until nothing is near it. @param {Vector3} point */
  _free(point) {
    const start = point.clone(), boxes = [];
    for (const number of this.bodies.of.keys()) {
      const box = this.bodies.bounds([number]);
      const size = box.getSize(new Vector3());
      if (!box.isEmpty() && Math.max(size.x, size.y) < 30) boxes.push(box.expandByScalar(0.5));
    }
    for (let ring = 0; ring < 12; ring++) {
      for (let i = 0; i < Math.max(6 * ring, 1); i++) {
        const angle = (2 * Math.PI * i) / Math.max(6 * ring, 1);
        point.set(start.x + 0.6 * ring * Math.cos(angle), start.y + 0.6 * ring * Math.sin(angle), start.z);
        if (!boxes.some((box) => box.containsPoint(point.clone().setZ(Math.max(box.min.z, Math.min(box.max.z, point.z + 0.2)))))) return;
      }
    }
    point.copy(start);
  }

  // Frames ------------------------------------------------------------------------------------------------------------

  /** Let a frame follow. @param {boolean} shadows whether shadows have changed, too */
  invalidate(shadows = false) {
    this._dirty = true;
    this._changed = performance.now();
    if (shadows) this.renderer.shadowMap.needsUpdate = true;
    if (!this._frame) this._frame = requestAnimationFrame((now) => this._tick(now));
  }

  /** @param {number} now [ms] */
  _tick(now) {
    this._frame = 0;
    if (!this._dirty) {
      const idle = performance.now() - this._changed > REST;
      if (idle && !this._refined) this._refine();
      else if (!this._refined) this._frame = requestAnimationFrame((time) => this._tick(time));
      return;
    }
    this._dirty = false;
    if (this._refined || this._outdated) {
      this._refined = this._outdated = false;
      this._applyLevel(); // which empties the canvas, until it is rendered below
      this._dirty = false;
    }
    const begin = performance.now();
    const gliding = this.cameras.update(now);
    this._render();
    if (this._built) {
      if (this.quality.measures) {
        this._wait();
        if (this.ready && this.quality.count(performance.now() - begin)) {
          this._outdated = true;
          this.invalidate();
        }
      }
      if (!this.ready) {
        this.ready = true;
        performance.mark("libgz-ready");
        this.store.dispatchEvent(new Event("progress"));
      }
    }
    if (gliding) this.invalidate();
    else if (!this._frame) this._frame = requestAnimationFrame((time) => this._tick(time));
  }

  /** @param {boolean} still whether there is time for all that a frame can have */
  _render(still = false) {
    const { camera, controls } = this.cameras;
    this.ground.follow(camera.position, this.renderer.getPixelRatio());
    this.sky.reach(this.cameras.distance);
    const radius = Math.min(Math.max(1.4 * this.cameras.distance, NEAREST), FARTHEST);
    if (this.lights.cover(camera.position, controls.target, radius)) this.renderer.shadowMap.needsUpdate = true;
    this.marks.face(camera, this.renderer);
    this.renderer.render(this.scene, camera);
    if (this._built && this.lights.shadows && (still || this.quality.level.fine)) {
      const reach = Math.min(0.09 * this.cameras.distance, 2);
      this.occlusion.render(this.renderer, this.scene, camera, [this.bodies.group, this.skins.group], reach);
    }
    this.outline.render(this.renderer, camera);
  }

  /** Wait until the last frame is complete: reading a pixel of it does. */
  _wait() {
    const gl = this.renderer.getContext();
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
  }

  /** Render a still image once more, with smooth edges and all shadows, where moving ones have none. */
  _refine() {
    this._refined = true;
    if (!this._built || this.quality.fixed || this.renderer.getContext().getContextAttributes()?.antialias) return;
    this.renderer.setPixelRatio(this.quality.still(this._ratio()));
    this.lights.resize(2048, true);
    this.renderer.shadowMap.needsUpdate = true;
    this._render(true);
  }

  _ratio() {
    return Math.min(window.devicePixelRatio, 2) * Math.min(this.quality.level.pixels, 1);
  }

  /** Do as the quality's level says. */
  _applyLevel() {
    const { level } = this.quality;
    this.renderer.setPixelRatio(this._ratio());
    this.lights.resize(level.shadows, level.soft);
    if (level.fine !== this._fine) {
      this._fine = level.fine;
      this._rebuild();
    }
    this.invalidate(true);
  }

  _resize() {
    const { clientWidth: width, clientHeight: height } = this.parent;
    if (!width || !height) return;
    this.renderer.setSize(width, height); // which empties the canvas
    this.cameras.resize(width, height);
    this.invalidate();
    if (this._built) {
      cancelAnimationFrame(this._frame);
      this._tick(performance.now());
    }
  }

  /** An image of the view, as it is. @returns {Promise<Blob>} PNG */
  screenshot() {
    const former = this.renderer.getPixelRatio();
    this.renderer.setPixelRatio(Math.max(2, window.devicePixelRatio));
    this._render(true);
    return new Promise((resolve, reject) => {
      this.canvas.toBlob((blob) => (blob ? resolve(blob) : reject(new Error("the browser gave no image"))), "image/png");
      this.renderer.setPixelRatio(former);
      this.invalidate();
    });
  }
}

/** @param {any} batch */
const isField = ({ instances: [{ shape }] }) => shape.kind === "heightfield";

/** Whether a batch is ground that is no plane: a large mesh, small enough to look for the place below the camera. @param {any} batch */
function isHilly(batch) {
  const [{ shape, ground }] = batch.instances, { geometry } = batch;
  if (shape.kind !== "mesh" || ground || batch.instances.length > 4) return false;
  if (!geometry.boundingBox) geometry.computeBoundingBox();
  const size = geometry.boundingBox.getSize(new Vector3());
  const triangles = (geometry.index ?? geometry.getAttribute("position")).count / 3;
  return Math.min(size.x, size.y) > LARGE && size.z < 0.5 * Math.min(size.x, size.y) && triangles < 60000;
}
