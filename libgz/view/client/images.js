// @ts-check
/**
 * Images: windows of cameras' and depth cameras' images.
 * @module
 */

import { element, setText } from 'libgz/dom.js';
import { FloatingWindow } from 'libgz/windows.js';

/**
 * @typedef {import('libgz/store.js').Entity} Entity
 * @typedef {import('libgz/store.js').Sensor} Sensor
 */

const CAMERAS = ['camera', 'guicam', 'stereocamera']; // types of interfaces
const KINDS = ['camera', 'depth', 'multicamera', 'wideanglecamera', 'logical_camera', 'depth_camera', 'rgbd']; // of SDF sensors

/** The windows of images. */
export class Images {
  /** @param {import('libgz/workplace.js').Workplace} workplace */
  constructor(workplace) {
    this.workplace = workplace;
    /** @type {Map<string, { window: FloatingWindow, image: HTMLImageElement, note: HTMLElement }>} */
    this.open = new Map();
    workplace.store.addEventListener('images', () => this.#draw());
    workplace.store.addEventListener('hello', () => this.#want());
  }

  /**
   * The images of a sensor.
   * @param {Entity} entity
   * @param {Sensor} sensor
   * @returns {{ name: string, label: string }[]}
   */
  ofSensor(entity, sensor) {
    if (sensor.name) {
      if (!KINDS.includes(sensor.kind)) return [];
      const body = entity.bodies.find((one) => one.id === sensor.body)?.name ?? '';
      const name = `${entity.id}::${body}::${sensor.name}`;
      return [{ name, label: name }];
    }
    if (sensor.kind !== 'camera') return [];
    return entity.interfaces.filter((one) => CAMERAS.includes(one.type)).map((one) => ({ name: one.id, label: one.id }));
  }

  /** All images that there are. */
  offered() {
    const found = new Map();
    for (const entity of this.workplace.store.entities.values()) {
      for (const one of entity.interfaces) if (CAMERAS.includes(one.type)) found.set(one.id, one.id);
      for (const sensor of entity.sensors) for (const { name, label } of this.ofSensor(entity, sensor)) found.set(name, label);
    }
    return [...found].map(([name, label]) => ({ name: String(name), label: String(label) }));
  }

  /** @param {string} name */
  isOpen(name) {
    return this.open.has(name);
  }

  /**
   * Open or close the window of an image.
   * @param {string} name
   * @param {string} label
   */
  toggle(name, label) {
    const known = this.open.get(name);
    if (known) {
      known.window.remove();
      this.#close(name);
      return;
    }
    const image = element('img', { alt: `Image of ${label}`, hidden: true });
    const note = element('p', { class: 'hint', text: 'Waiting for an image …' });
    const window = new FloatingWindow(this.workplace.layout.stage, {
      name: `image.${name}`,
      title: label,
      content: element('div', { class: 'image' }, image, note),
      width: 260,
      resizable: true,
      closed: () => this.#close(name),
    });
    image.addEventListener('load', () => {
      image.hidden = false;
      note.hidden = true;
      setText(note, '');
    });
    this.open.set(name, { window, image, note });
    this.#want();
    this.#draw();
  }

  /** @param {string} name */
  #close(name) {
    this.open.delete(name);
    this.#want();
  }

  #want() {
    this.workplace.store.want('images', [...this.open.keys()], 'windows');
  }

  #draw() {
    for (const [name, { image }] of this.open) {
      const url = this.workplace.store.images.get(name);
      if (url && image.src !== url) image.src = url;
    }
  }
}
