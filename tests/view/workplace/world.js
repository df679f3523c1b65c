/** A world that moves by itself, for tests of the page around the view; `window.asked` has what users asked for. */

import { Workplace } from 'libgz/workplace.js';

const query = new URLSearchParams(location.search);
const VERBS = 'pause step reset speed keep rewind move delete insert catalogue write describe inventory light joint release contacts readings interfaces parts steer fields press';
const ROW = 16;

class World extends EventTarget {
  constructor() {
    super();
    this.control = query.get('watch') === null;
    this.abilities = new Set((query.get('verbs') ?? VERBS).split(' '));
    this.title = 'arena - libgz';
    this.connected = true;
    this.status = { text: '', level: '' };
    this.selection = this.hover = this.follow = null;
    this.handles = { mode: 'none', space: 'world', snap: false };
    this.theme = 'dark';
    this.robots = [{ label: 'robot1 (position)', entity: 'robot1' }, { label: 'rover (vel_cmd)', entity: 'rover' }];
    this.robot = 'robot1 (position)';
    this.controllers = { here: this.control, other: false, canAsk: false };
    this.asked = '';
    this.speeds = { linear: 0.4, angular: 0.8 };
    this.messages = [];
    this.overlays = [];
    this.images = new Map();
    this.series = new Map();
    this.log = null;
    this.on = new Set(['grid', 'shadows']);
    this.wants = {};
    this.views = [];
    this.drives = [];
    this.realTimeFactor = 1;
    this.stepRate = 50;
    this.entities = new Map();
    this.ids = new Map();
    this.bodies = new Map();
    this.build();
  }

  build() {
    const body = (id, name, kind = 'box') => ({
      id, name, row: id - 1, static: false,
      shapes: [{ id: id * 10, name: 'shape', kind, size: [0.4, 0.3, 0.2], collides: true, visible: true, material: { diffuse: [0.8, 0.4, 0.2, 1] } }],
    });
    const entity = (number, id, more) => ({
      number, id, kind: 'model', type: '', parent: 0, parent_body: 0, body: 0, pose: [0, 0, 0, 1, 0, 0, 0], static: false,
      interfaces: [], bodies: [], joints: [], sensors: [], ...more,
    });
    const wheel = (i) => ({ name: `wheel${i}`, kind: 'hinge', row: i, bodies: [1, 2 + i], frame: 1, anchor: [0, 0, 0], axes: [[0, 1, 0]] });
    const list = [
      entity(1, 'ground', { type: 'GroundPlane', static: true }),
      entity(2, 'sun', { kind: 'light', bodies: [{ ...body(9, ''), shapes: [{ kind: 'light', material: { diffuse: [0.9, 0.9, 0.8, 1] } }] }] }),
      entity(3, 'robot1', {
        type: 'Pioneer2AT', body: 1, bodies: [body(1, 'chassis'), body(2, 'front left'), body(3, 'front right')],
        joints: [wheel(0), wheel(1)], interfaces: [{ type: 'position', id: 'robot1' }],
      }),
      entity(4, 'laser1', { type: 'SickLMS200', parent: 3, body: 4, bodies: [body(4, 'body')], interfaces: [{ type: 'laser', id: 'laser1' }], sensors: [{ kind: 'rays', body: 4 }] }),
      entity(5, 'camera1', { type: 'MonoCamera', parent: 3, body: 5, bodies: [body(5, 'body')], interfaces: [{ type: 'camera', id: 'camera1' }], sensors: [{ kind: 'camera', body: 5, fov: 1.05, aspect: 1.33, near: 0.1, far: 50 }] }),
      entity(6, 'arm', {
        body: 6, bodies: [body(6, 'base'), body(7, 'upper', 'cylinder')],
        joints: [{ name: 'shoulder', kind: 'revolute', row: 2, bodies: [6, 7], frame: 6, anchor: [0, 0, 0], axes: [[0, 1, 0]], limits: [[-1, 1]] }],
        sensors: [{ kind: 'camera', name: 'cam', body: 7, pose: [0, 0, 0, 1, 0, 0, 0], rate: 10, topic: '~/arm/upper/cam/image' }],
      }),
      entity(7, 'rover', { body: 8, bodies: [body(8, 'link')] }),
      entity(8, '<img src=x onerror=window.evil=1>', { body: 8, bodies: [] }),
    ];
    for (let i = 0; i < Number(query.get('models') ?? 0); i++) list.push(entity(100 + i, `box_${i}`, { body: 8, bodies: [body(20 + i, 'link')] }));
    this.scene = { world: 'arena', era: query.get('era') ?? 'classic', revision: 1, gravity: [0, 0, -9.81], entities: list };
    for (const one of list) {
      this.entities.set(one.number, one);
      this.ids.set(one.id, one.number);
      for (const part of one.bodies) this.bodies.set(part.id, { body: part, entity: one.number, row: part.row });
    }
    const rows = 30 + list.length;
    this.state = { steps: 0, simTime: 0, pauseTime: 0, realTime: 0, paused: query.get('paused') !== null, revision: 1, bodies: new Float32Array(ROW * rows), joints: new Float32Array(4 * 3) };
    this.move();
  }

  move() {
    const { bodies, joints, simTime: t } = this.state;
    for (let row = 0; row < bodies.length / ROW; row++) {
      bodies.set([2 * Math.cos(t / 3 + row), 2 * Math.sin(t / 3 + row), 0.2, Math.cos(t / 6), 0, 0, Math.sin(t / 6)], ROW * row);
      bodies.set([0.4 * Math.cos(t), 0.3 * Math.sin(t), 0, 0, 0, 0.8 * Math.sin(t)], ROW * row + 10);
    }
    joints.set([t, t, 0.6 * Math.sin(t)], 0);
    joints.set([0.6 * Math.sin(t), 0, 0.6 * Math.cos(t), 0], 8);
    for (const key of this.wants.fields ?? []) this.series.set(key, { time: t, value: Math.sin(2 * t) });
  }

  tick(span) {
    if (!this.state.paused) {
      this.state.simTime += span;
      this.state.steps += 1;
    } else this.state.pauseTime += span;
    this.move();
    this.emit('state');
    this.emit('series');
  }

  emit(name) {
    this.dispatchEvent(new Event(name));
  }

  bodyPose(row) {
    return this.state.bodies.subarray(ROW * row, ROW * row + 7);
  }

  entityPose(number) {
    const row = this.bodies.get(this.entities.get(number)?.body)?.row;
    return row === undefined ? this.entities.get(number)?.pose : this.bodyPose(row);
  }

  select(selection) {
    this.selection = selection;
    this.emit('selection');
  }

  setHover(entity) {
    this.hover = entity;
    this.emit('hover');
  }

  isOn(name, entity) {
    return this.on.has(entity === undefined ? name : `${name}/${entity}`);
  }

  setSwitch(name, on, entity) {
    const key = entity === undefined ? name : `${name}/${entity}`;
    if (on) this.on.add(key);
    else this.on.delete(key);
    this.emit('switches');
  }

  setHandles(some) {
    this.handles = { ...this.handles, ...some };
    this.emit('handles');
  }

  setFollow(entity) {
    this.follow = entity;
    this.emit('follow');
  }

  setTheme(theme) {
    this.theme = theme;
    this.emit('theme');
  }

  chooseRobot(label) {
    this.robot = label;
    this.emit('robots');
  }

  drive(...way) {
    this.drives.push(way);
  }

  setSpeeds(some) {
    this.speeds = { ...this.speeds, ...some };
  }

  pressKey() {}

  view(command) {
    this.views.push(command);
  }

  want(channel, names) {
    this.wants[channel] = names;
  }

  async ask(verb, argument = '-', content = {}) {
    window.asked.push([verb, argument, JSON.parse(JSON.stringify(content))]);
    const answers = {
      catalogue: () => ['box', 'sphere', 'cylinder', 'model://table', { name: 'Pioneer2AT', title: 'Pioneer 2AT', group: 'Robots' }],
      describe: () => ({ mass: 28.05, plugins: [['drive', 'libdrive.so']] }),
      parts: () => (argument === 'robot1' ? [{ key: 'ptz1/pan', kind: 'slider', label: 'ptz1 pan', value: 0, low: -1.5, high: 1.5, unit: 'rad' }, { key: 'gripper1/1', kind: 'button', label: 'gripper1: open' }, { key: 'gripper1/2', kind: 'button', label: 'gripper1: close' }] : []),
      fields: () => (argument === 'robot1' ? [
        { of: 'position.robot1', key: 'position.robot1.pos[#]', label: 'pos[#]', unit: 'm', count: 3 },
        { of: 'position.robot1', key: 'position.robot1.stall', label: 'stall', unit: '', whole: true },
        { of: 'position.robot1', key: 'position.robot1.levels[#]', label: 'levels[#]', unit: 'V', count: 10 },
        { of: 'position.robot1', key: 'position.robot1.ranges[#]/far', label: 'ranges[#]/far', unit: 'm', count: 400 },
        { of: 'gps.a#b', key: 'gps.a#b.fix[#]', label: 'fix[#]', unit: 'm', count: 2 },
      ] : []),
      attributes: () => [
        ...(content.name === 'rover' && !asked.some(([asked]) => asked === 'embed')
          ? [{ key: 'include', label: 'file', group: 'Included', type: 'include', value: '/models/rover/model.sdf', reason: 'included' }]
          : []),
        { key: 'mass', label: 'mass', group: 'Inertia', type: 'number', value: 2, unit: 'kg', low: 0, above: true, help: 'Mass of the link', file: 'a.world', line: 12 },
        { key: 'size', label: 'size', group: 'Shape', type: 'vector', value: [1, 2, 3], unit: 'm', low: 0 },
        { key: 'color', label: 'colour', group: 'Shape', type: 'color', value: [1, 0.5, 0, 1] },
        { key: 'static', label: 'static', group: 'Attributes', type: 'bool', value: false },
        { key: 'kind', label: 'kind', group: 'Attributes', type: 'choice', value: 'b', options: ['a', 'b'] },
        { key: 'name', label: 'name', group: 'Attributes', type: 'text', value: 'arm' },
        { key: 'gravity', label: 'gravity', group: 'Attributes', type: 'bool', value: true, reason: 'set by the world' },
      ],
      embed: () => ({ name: content.name }),
      edit: () => ({ value: content.value, name: content.name }),
      undo: () => ({ text: 'move arm', undo: 0, redo: 1 }),
      diff: () => '--- a.world\n+++ a.world\n@@ -4,3 +4,3 @@\n <id>robot1</id>\n-<xyz>0 0 0</xyz>\n+<xyz>1 0 0.2</xyz>',
      write: () => '/tmp/a.world',
      insert: () => ['rover'],
      duplicate: () => ['rover'],
      pause: () => void (this.state.paused = argument === 'on'),
      step: () => {
        this.state.simTime += 0.02 * Number(argument);
        this.state.steps += Number(argument);
      },
      reset: () => {
        this.state.simTime = 0;
      },
      delete: () => {
        if (content.name === 'ground') throw new Error('ground cannot be deleted');
      },
    };
    const answer = answers[verb]?.();
    this.tick(0);
    return answer;
  }
}

class View {
  constructor(parent) {
    this.ready = query.get('loading') === null;
    this.progress = { done: 3, total: 7 };
    const canvas = document.createElement('canvas');
    canvas.width = canvas.height = 64;
    parent.append(canvas);
  }

  place() {
    return [1, 2, 0];
  }

  screenshot() {
    return new Promise((done) => document.createElement('canvas').toBlob(done));
  }
}

window.asked = [];
window.errors = [];
window.addEventListener('error', (event) => window.errors.push(event.message));
window.addEventListener('unhandledrejection', (event) => window.errors.push(String(event.reason)));
const world = (window.world = new World());
window.workplace = new Workplace(document.body, world, (parent) => new View(parent));
world.emit('hello');
world.emit('scene');
setInterval(() => world.tick(0.033), 33);
