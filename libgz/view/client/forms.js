// Forms: the geometry of shapes. Shapes of one form differ in place and scale only and share one geometry.

import {
  BufferAttribute,
  BufferGeometry,
  CapsuleGeometry,
  SphereGeometry,
} from "three";

/** @typedef {import("libgz/assets.js").Arrays} Arrays */

/**
 * @typedef {object} Form
 * @property {string} key distinguishes it from others
 * @property {BufferGeometry} geometry
 * @property {[number, number, number]} scale of the geometry, to the shape's sizes
 * @property {boolean} [both] whether it is seen from both sides
 */

const SEGMENTS = 32; // of a full turn
const PLANE = 4000; // [m] side of what stands for an infinite plane
const CREASE = Math.cos((40 * Math.PI) / 180); // edges that are steeper stay sharp
const UNIT = /** @type {[number, number, number]} */ ([1, 1, 1]);

/** @type {Map<string, BufferGeometry>} */
const built = new Map();

/**
 * @param {string} key
 * @param {() => BufferGeometry} build
 */
export function once(key, build) {
  let geometry = built.get(key);
  if (!geometry) {
    geometry = build();
    built.set(key, geometry);
  }
  return geometry;
}

/** Free geometries that no shape of the present scene has. @param {Set<string>} used */
export function forget(used) {
  for (const [key, geometry] of built) {
    if (used.has(key)) continue;
    geometry.dispose();
    built.delete(key);
  }
}

/**
 * The form of a shape of the scene; null for kinds without one.
 * @param {any} shape docs/observer.md describes it
 * @param {(reference: any) => Arrays | null} data the arrays that a shape refers to, if they have arrived
 * @returns {Form | null}
 */
export function formOf(shape, data) {
  switch (shape.kind) {
    case "box":
      return { key: "box", geometry: once("box", box), scale: [shape.size[0], shape.size[1], shape.size[2]] };
    case "sphere":
      return { key: "sphere", geometry: once("sphere", sphere), scale: [shape.radius, shape.radius, shape.radius] };
    case "cylinder":
      return {
        key: "cylinder",
        geometry: once("cylinder", cylinder),
        scale: [shape.radius, shape.radius, shape.length],
      };
    case "capsule": {
      const key = `capsule ${shape.radius} ${shape.length}`;
      return { key, geometry: once(key, () => capsule(shape.radius, shape.length)), scale: UNIT };
    }
    case "wheel": {
      const key = `wheel ${shape.radius} ${shape.tire_radius}`;
      return { key, geometry: once(key, () => wheel(shape.radius, shape.tire_radius)), scale: UNIT };
    }
    case "plane": {
      const size = shape.texture ? shape.texture.size : [1, 1];
      const key = `plane ${shape.normal} ${shape.altitude} ${size}`;
      return { key, geometry: once(key, () => plane(shape.normal, shape.altitude, size)), scale: UNIT };
    }
    case "mesh": {
      const arrays = data(shape.data);
      if (!arrays || !arrays.triangles.length) return null;
      const size = shape.texture ? shape.texture.size : [2, 2];
      const key = `mesh ${shape.data.file} ${arrays.texture_coordinates ? "" : size}`;
      return { key, geometry: once(key, () => mesh(arrays, size)), scale: UNIT, both: true };
    }
    case "heightfield": {
      const arrays = data(shape.data);
      if (!arrays) return null;
      const size = shape.texture ? shape.texture.size : [2, 2];
      const key = `heights ${shape.data.file} ${shape.size} ${size}`;
      return { key, geometry: once(key, () => heightfield(arrays, shape.size, size)), scale: UNIT };
    }
    default:
      return null;
  }
}

/**
 * @param {ArrayLike<number>} positions
 * @param {ArrayLike<number>} normals
 * @param {ArrayLike<number> | null} texcoords
 * @param {ArrayLike<number>} indices
 */
function geometryOf(positions, normals, texcoords, indices) {
  const geometry = new BufferGeometry();
  const count = positions.length / 3;
  geometry.setAttribute("position", new BufferAttribute(Float32Array.from(positions), 3));
  geometry.setAttribute("normal", new BufferAttribute(Float32Array.from(normals), 3));
  geometry.setAttribute("uv", new BufferAttribute(Float32Array.from(texcoords ?? new Float32Array(2 * count)), 2));
  geometry.setIndex(new BufferAttribute(count > 65535 ? Uint32Array.from(indices) : Uint16Array.from(indices), 1));
  return geometry;
}

/** A box of side 1; each face carries the whole texture, upright on the sides. */
function box() {
  const positions = [], normals = [], texcoords = [], indices = [];
  for (let axis = 0; axis < 3; axis++) {
    for (const sign of [1, -1]) {
      const n = [0, 0, 0], t = [0, 0, 0];
      n[axis] = sign;
      t[axis === 2 ? 1 : 2] = 1;
      const s = [t[1] * n[2] - t[2] * n[1], t[2] * n[0] - t[0] * n[2], t[0] * n[1] - t[1] * n[0]];
      const first = positions.length / 3;
      for (const [u, v] of [[0, 0], [1, 0], [1, 1], [0, 1]]) {
        for (let i = 0; i < 3; i++) positions.push((n[i] + (2 * u - 1) * s[i] + (2 * v - 1) * t[i]) / 2);
        normals.push(...n);
        texcoords.push(u, v);
      }
      indices.push(first, first + 1, first + 2, first, first + 2, first + 3);
    }
  }
  return geometryOf(positions, normals, texcoords, indices);
}

/**
 * A box with round edges.
 * @param {number[]} size [m]
 * @param {number} edge radius of the edges [m]
 */
export function boxWithRoundEdges(size, edge) {
  // Each face is a grid of directions, of which one half belongs to one end of each side: between the halves it is flat.
  const steps = 3, turns = Array.from({ length: steps + 1 }, (_, i) => Math.tan((Math.PI / 4) * (i / steps)));
  const along = [...turns.map((t) => [-1, -t]).reverse(), ...turns.map((t) => [1, t])];
  const positions = [], normals = [], indices = [];
  for (let axis = 0; axis < 3; axis++) {
    for (const end of [-1, 1]) {
      const first = positions.length / 3, u = (axis + 1) % 3, v = (axis + 2) % 3;
      for (const [vEnd, vTurn] of along) {
        for (const [uEnd, uTurn] of along) {
          const ends = [0, 0, 0], normal = [0, 0, 0], length = Math.hypot(1, uTurn, vTurn);
          [ends[axis], ends[u], ends[v]] = [end, uEnd, vEnd];
          [normal[axis], normal[u], normal[v]] = [end / length, uTurn / length, vTurn / length];
          for (let i = 0; i < 3; i++) positions.push(ends[i] * (size[i] / 2 - edge) + edge * normal[i]);
          normals.push(...normal);
        }
      }
      const row = along.length;
      for (let j = 0; j + 1 < row; j++) {
        for (let i = 0; i + 1 < row; i++) {
          const a = first + j * row + i, [b, d] = end > 0 ? [a + 1, a + row] : [a + row, a + 1];
          indices.push(a, b, a + row + 1, a, a + row + 1, d);
        }
      }
    }
  }
  return geometryOf(positions, normals, null, indices);
}

/** A sphere of radius 1, its poles on z; the texture runs once around. */
function sphere() {
  return new SphereGeometry(1, SEGMENTS, SEGMENTS / 2).rotateX(Math.PI / 2);
}

/** @param {number} radius @param {number} length without the caps */
function capsule(radius, length) {
  return new CapsuleGeometry(radius, Math.max(length, 1e-6), SEGMENTS / 4, SEGMENTS).rotateX(Math.PI / 2);
}

/**
 * A profile revolved about z, from the bottom up: rows of [radius, height, normal outwards, normal upwards, t].
 * @param {number[][]} rows
 * @param {{positions: number[], normals: number[], texcoords: number[], indices: number[]}} into
 */
function revolve(rows, into) {
  const first = into.positions.length / 3;
  for (const [radius, height, outward, upward, t] of rows) {
    for (let i = 0; i <= SEGMENTS; i++) {
      const angle = (2 * Math.PI * i) / SEGMENTS, cos = Math.cos(angle), sin = Math.sin(angle);
      into.positions.push(radius * cos, radius * sin, height);
      into.normals.push(outward * cos, outward * sin, upward);
      into.texcoords.push(i / SEGMENTS, t);
    }
  }
  const row = SEGMENTS + 1;
  for (let j = 0; j + 1 < rows.length; j++) {
    for (let i = 0; i < SEGMENTS; i++) {
      const a = first + j * row + i;
      into.indices.push(a, a + 1, a + row + 1, a, a + row + 1, a + row);
    }
  }
}

const empty = () => ({
  positions: /** @type {number[]} */ ([]),
  normals: /** @type {number[]} */ ([]),
  texcoords: /** @type {number[]} */ ([]),
  indices: /** @type {number[]} */ ([]),
});

/** A cylinder of radius and length 1 along z; the side carries the texture, the ends are plain. */
function cylinder() {
  const parts = empty();
  revolve([[1, -0.5, 1, 0, 0], [1, 0.5, 1, 0, 1]], parts);
  revolve([[1, 0.5, 0, 1, 0], [0, 0.5, 0, 1, 0]], parts);
  revolve([[0, -0.5, 0, -1, 0], [1, -0.5, 0, -1, 0]], parts);
  return geometryOf(parts.positions, parts.normals, parts.texcoords, parts.indices);
}

/** @param {number} radius @param {number} tire radius of the tire's tube */
function wheel(radius, tire) {
  const parts = empty();
  const ring = Math.max(radius - tire, 0), hub = 0.8 * radius, rows = [];
  for (let i = 0; i <= 24; i++) {
    const angle = -Math.PI + (2 * Math.PI * i) / 24;
    rows.push([
      ring + tire * Math.cos(angle),
      tire * Math.sin(angle),
      Math.cos(angle),
      Math.sin(angle),
      (angle / Math.PI + 1) / 2,
    ]);
  }
  revolve(rows, parts);
  revolve([[hub, 0.8 * tire, 0, 1, 0], [0, 0.8 * tire, 0, 1, 0]], parts);
  revolve([[0, -0.8 * tire, 0, -1, 0], [hub, -0.8 * tire, 0, -1, 0]], parts);
  return geometryOf(parts.positions, parts.normals, parts.texcoords, parts.indices);
}

/**
 * A large part of an infinite plane; texture coordinates follow the world's axes as far as the plane is level.
 * @param {number[]} normal
 * @param {number} altitude
 * @param {number[]} size [m] of one image
 */
function plane(normal, altitude, size) {
  const length = Math.hypot(...normal) || 1;
  const n = normal.map((part) => part / length);
  let across = Math.abs(n[1]) < 0.9 ? [n[2], 0, -n[0]] : [1, 0, 0];
  const wide = Math.hypot(...across) || 1;
  across = across.map((part) => part / wide);
  const up = [n[1] * across[2] - n[2] * across[1], n[2] * across[0] - n[0] * across[2], n[0] * across[1] - n[1] * across[0]];
  // A grid, not two triangles: light and texture coordinates keep their precision near the middle.
  const cells = [-1, -0.1, -0.01, 0, 0.01, 0.1, 1].map((share) => (share * PLANE) / 2);
  const positions = [], normals = [], texcoords = [], indices = [];
  for (const v of cells) {
    for (const u of cells) {
      for (let i = 0; i < 3; i++) positions.push(n[i] * altitude + across[i] * u + up[i] * v);
      normals.push(...n);
      texcoords.push(u / (size[0] || 1), v / (size[1] || 1));
    }
  }
  const row = cells.length;
  for (let j = 0; j + 1 < row; j++) {
    for (let i = 0; i + 1 < row; i++) {
      const a = j * row + i;
      indices.push(a, a + 1, a + row + 1, a, a + row + 1, a + row);
    }
  }
  return geometryOf(positions, normals, texcoords, indices);
}

/**
 * @param {Arrays} arrays `heights`, rows along +y, columns along +x
 * @param {number[]} extent
 * @param {number[]} size [m] of one image
 */
function heightfield(arrays, extent, size) {
  const [rows, columns] = arrays.shapes.heights, heights = arrays.heights;
  const positions = new Float32Array(3 * rows * columns), normals = new Float32Array(3 * rows * columns);
  const texcoords = new Float32Array(2 * rows * columns), indices = new Uint32Array(6 * (rows - 1) * (columns - 1));
  const dx = extent[0] / (columns - 1), dy = extent[1] / (rows - 1);
  for (let j = 0, k = 0; j < rows; j++) {
    for (let i = 0; i < columns; i++, k++) {
      const x = -extent[0] / 2 + i * dx, y = -extent[1] / 2 + j * dy;
      positions.set([x, y, heights[k]], 3 * k);
      texcoords.set([x / (size[0] || 1), y / (size[1] || 1)], 2 * k);
      const west = i ? 1 : 0, east = i + 1 < columns ? 1 : 0, south = j ? columns : 0, north = j + 1 < rows ? columns : 0;
      const sx = (heights[k + east] - heights[k - west]) / (dx * (east + west || 1));
      const sy = (heights[k + north] - heights[k - south]) / (dy * ((south ? 1 : 0) + (north ? 1 : 0) || 1));
      const length = Math.hypot(sx, sy, 1);
      normals.set([-sx / length, -sy / length, 1 / length], 3 * k);
    }
  }
  for (let j = 0, k = 0; j + 1 < rows; j++) {
    for (let i = 0; i + 1 < columns; i++, k += 6) {
      const a = j * columns + i;
      indices.set([a, a + 1, a + columns + 1, a, a + columns + 1, a + columns], k);
    }
  }
  return geometryOf(positions, normals, texcoords, indices);
}

/**
 * A triangle mesh; without normals of its own it is smooth at shallow edges and sharp at steep ones, and without texture
 * coordinates its texture is projected from above.
 * @param {Arrays} arrays `vertices`, `triangles`, and perhaps `normals`, `texture_coordinates`, `colors`
 * @param {number[]} size [m] of one image
 */
function mesh(arrays, size) {
  const geometry = new BufferGeometry();
  const { vertices, triangles, normals, texture_coordinates: texcoords, colors } = arrays;
  /** @type {ArrayLike<number>} */
  let corners = triangles;
  if (normals) {
    geometry.setAttribute("position", new BufferAttribute(new Float32Array(vertices), 3));
    geometry.setAttribute("normal", new BufferAttribute(new Float32Array(normals), 3));
    geometry.setIndex(new BufferAttribute(new Uint32Array(triangles), 1));
  } else {
    const flat = new Float32Array(3 * triangles.length);
    for (let i = 0; i < triangles.length; i++) {
      for (let k = 0; k < 3; k++) flat[3 * i + k] = vertices[3 * triangles[i] + k];
    }
    geometry.setAttribute("position", new BufferAttribute(flat, 3));
    geometry.setAttribute("normal", new BufferAttribute(cornerNormals(vertices, triangles), 3));
    corners = Uint32Array.from({ length: triangles.length }, (_, i) => triangles[i]);
  }
  const count = geometry.getAttribute("position").count;
  const at = normals ? (/** @type {number} */ i) => i : (/** @type {number} */ i) => corners[i];
  const uv = new Float32Array(2 * count);
  for (let i = 0; i < count; i++) {
    const v = at(i);
    uv[2 * i] = texcoords ? texcoords[2 * v] : vertices[3 * v] / (size[0] || 1);
    uv[2 * i + 1] = texcoords ? texcoords[2 * v + 1] : vertices[3 * v + 1] / (size[1] || 1);
  }
  geometry.setAttribute("uv", new BufferAttribute(uv, 2));
  if (colors) {
    const width = arrays.shapes.colors[1], shades = new Float32Array(3 * count);
    for (let i = 0; i < count; i++) {
      for (let k = 0; k < 3; k++) shades[3 * i + k] = Math.max(colors[width * at(i) + k], 0) ** 2.2;
    }
    geometry.setAttribute("color", new BufferAttribute(shades, 3));
  }
  return geometry;
}

/**
 * The normal of each triangle's corners: the mean of the faces that meet there at shallow angles, weighted by area.
 * @param {ArrayLike<number>} vertices
 * @param {ArrayLike<number>} triangles
 */
function cornerNormals(vertices, triangles) {
  const faces = triangles.length / 3, areas = new Float32Array(3 * faces), units = new Float32Array(3 * faces);
  for (let f = 0; f < faces; f++) {
    const [a, b, c] = [3 * triangles[3 * f], 3 * triangles[3 * f + 1], 3 * triangles[3 * f + 2]];
    const ux = vertices[b] - vertices[a], uy = vertices[b + 1] - vertices[a + 1], uz = vertices[b + 2] - vertices[a + 2];
    const vx = vertices[c] - vertices[a], vy = vertices[c + 1] - vertices[a + 1], vz = vertices[c + 2] - vertices[a + 2];
    const x = uy * vz - uz * vy, y = uz * vx - ux * vz, z = ux * vy - uy * vx, length = Math.hypot(x, y, z) || 1;
    areas.set([x, y, z], 3 * f);
    units.set([x / length, y / length, z / length], 3 * f);
  }
  // Vertices at one place are one: many files repeat them for each triangle.
  /** @type {Map<string, number>} */
  const places = new Map();
  const count = vertices.length / 3, place = new Uint32Array(count);
  for (let v = 0; v < count; v++) {
    const key = `${vertices[3 * v]},${vertices[3 * v + 1]},${vertices[3 * v + 2]}`;
    const found = places.get(key);
    place[v] = found ?? places.size;
    if (found === undefined) places.set(key, place[v]);
  }
  const starts = new Uint32Array(places.size + 1), meeting = new Uint32Array(triangles.length);
  for (let i = 0; i < triangles.length; i++) starts[place[triangles[i]] + 1]++;
  for (let p = 0; p < places.size; p++) starts[p + 1] += starts[p];
  const next = starts.slice();
  for (let i = 0; i < triangles.length; i++) meeting[next[place[triangles[i]]]++] = Math.floor(i / 3);
  const normals = new Float32Array(3 * triangles.length);
  for (let i = 0; i < triangles.length; i++) {
    const own = 3 * Math.floor(i / 3), p = place[triangles[i]];
    let x = 0, y = 0, z = 0;
    for (let k = starts[p]; k < starts[p + 1]; k++) {
      const other = 3 * meeting[k];
      const dot = units[own] * units[other] + units[own + 1] * units[other + 1] + units[own + 2] * units[other + 2];
      if (dot < CREASE) continue;
      x += areas[other];
      y += areas[other + 1];
      z += areas[other + 2];
    }
    const length = Math.hypot(x, y, z);
    if (length > 0) normals.set([x / length, y / length, z / length], 3 * i);
    else normals.set([0, 0, 1], 3 * i);
  }
  return normals;
}
