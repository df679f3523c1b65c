// The stage alone, over worlds that the tests serve.
import { Quality } from "libgz/quality.js";
import { Stage } from "libgz/stage.js";
import { Store } from "libgz/store.js";

const store = new Store();
const asked = [];
store.link = { send() {}, async ask(...words) { asked.push(words); return null; } };
store.control = true;
store.abilities = new Set(["move", "hold", "contacts"]);
store.theme = "light";
const stage = new Stage(document.getElementById("stage"), store, { quality: new URLSearchParams(location.search).get("quality") });

async function state(scene) {
  const found = await (await fetch("state.json")).json();
  store.setState({
    ...found, revision: scene.revision, bodyColumns: 16, jointColumns: 4, bodies: Float32Array.from(found.bodies), joints: new Float32Array(),
  });
}

/** Show the world that is served now, from the scene to the first frame. */
async function show() {
  const scene = await (await fetch("scene.json")).json();
  scene.world = `${scene.world} ${Math.random()}`; // another one: the camera begins again
  store.select(null);
  store.setScene(scene);
  await state(scene);
  while (!stage.ready || stage._begins || stage._world !== `${scene.era} ${scene.world}`) await frames(1);
  await frames(3);
}

/** Show what has come into the world: its scene comes before a state that has it. */
async function added() {
  const scene = await (await fetch("scene.json")).json();
  store.setScene({ ...scene, world: store.scene.world });
  await frames(1);
  await state(store.scene);
  await frames(3);
}

/** Wait for frames. */
async function frames(count = 3) {
  for (let i = 0; i < count; i++) {
    stage.invalidate();
    await new Promise((resolve) => { requestAnimationFrame(() => { setTimeout(resolve, 0); }); });
  }
}

const { bodies, cameras, handles, marks, skins } = stage;

/** What the tests ask. */
const ask = {
  /** The ends of a mark's lines. */
  ends(name) {
    const { _places, count } = marks.lines[name];
    return Array.from(_places.array.subarray(0, 6 * count));
  },
  sonar: () => store.scene.entities.flatMap((one) => one.interfaces).find(({ type }) => type === "sonar").id,
  /** Where a point of the arrow along x of the handles is in the page [px]. */
  arrow() {
    const point = handles.grip.position.clone(), { camera } = cameras;
    point.x += 0.12 * handles.controls.size * camera.position.distanceTo(point);
    point.project(camera);
    return [((point.x + 1) / 2) * innerWidth, ((1 - point.y) / 2) * innerHeight];
  },
  bounds(name) {
    const { min, max } = bodies.bounds(bodies.family(store.ids.get(name)));
    return [min.toArray(), max.toArray()];
  },
  /** Of each shape: model, opacity, whether it casts shadows. */
  looks: () => bodies.instances.map(({ entity, batch }) => [store.entities.get(entity).id, batch.material.opacity, batch.shadows]),
  /** Where vertices of the first actor's skin are. */
  skin(vertices) {
    const { mesh } = skins.skins[0], place = mesh.position.clone();
    return vertices.map((i) => mesh.getVertexPosition(i, place).toArray());
  },
  async screenshot() {
    const image = await createImageBitmap(await stage.screenshot());
    return [image.width, image.height];
  },
  /** The level after frames that take a time [ms]. */
  level(software, time) {
    const quality = new Quality(software, null);
    for (let i = 0; i < 60; i++) quality.count(time);
    return quality.index;
  },
};

/** Show the present state of the world that is served. */
async function present() {
  await state(store.scene);
  await frames(1);
}

Object.assign(window, { ask, libgz: { store, stage }, asked, show, added, frames, state: present });
