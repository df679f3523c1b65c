// @ts-check
/**
 * Overlays: what GUI plugins show, in windows over the view.
 * @module
 */

import { element, fill, setText, show } from 'libgz/dom.js';
import { Chart } from 'libgz/plots.js';
import { FloatingWindow } from 'libgz/windows.js';

/** The windows of GUI plugins. */
export class Overlays {
  /** @param {import('libgz/workplace.js').Workplace} workplace */
  constructor(workplace) {
    this.workplace = workplace;
    /** @type {Map<string, Overlay>} */
    this.shown = new Map();
    workplace.store.addEventListener('overlays', () => this.draw());
    workplace.store.want('overlays', ['*']);
    this.draw();
  }

  draw() {
    const { overlays } = this.workplace.store;
    for (const [name, overlay] of this.shown) {
      if (overlays.some((one) => one.name === name)) continue;
      overlay.window.remove();
      this.shown.delete(name);
    }
    for (const content of overlays) {
      let overlay = this.shown.get(content.name);
      if (!overlay) {
        overlay = new Overlay(this.workplace, content.name);
        this.shown.set(content.name, overlay);
      }
      overlay.show(content);
    }
  }
}

class Overlay {
  /**
   * @param {import('libgz/workplace.js').Workplace} workplace
   * @param {string} name
   */
  constructor(workplace, name) {
    this.workplace = workplace;
    this.name = name;
    this.text = element('p', { class: 'overlay-text' });
    this.buttons = element('div', { class: 'overlay-buttons' });
    this.images = element('div', { class: 'overlay-images' });
    this.plots = element('div', { class: 'overlay-plots' });
    /** @type {Map<string, Chart>} */
    this.charts = new Map();
    this.labels = '';
    this.window = new FloatingWindow(workplace.layout.stage, {
      name: `overlay.${name}`,
      title: name,
      content: element('div', { class: 'overlay' }, this.text, this.buttons, this.images, this.plots),
    });
  }

  /** @param {import('libgz/store.js').Overlay} content */
  show({ text, buttons, images, plots }) {
    setText(this.text, text);
    show(this.text, Boolean(text));
    if (this.labels !== JSON.stringify(buttons)) {
      this.labels = JSON.stringify(buttons);
      fill(
        this.buttons,
        buttons.map((label) =>
          element('button', { type: 'button', class: 'text', text: label, on: { click: () => this.workplace.ask('press', this.name, { label }) } }),
        ),
      );
    }
    const shown = Object.entries(images);
    while (this.images.children.length > shown.length) this.images.lastElementChild?.remove();
    shown.forEach(([label, url], i) => {
      let image = /** @type {HTMLImageElement | undefined} */ (this.images.children[i]);
      if (!image) this.images.append((image = element('img')));
      image.alt = label;
      image.title = label;
      if (image.src !== url) image.src = url;
    });
    for (const [label, chart] of this.charts)
      if (!(label in plots)) {
        chart.root.parentElement?.remove();
        this.charts.delete(label);
      }
    for (const [label, plot] of Object.entries(plots)) {
      let chart = this.charts.get(label);
      if (!chart) {
        chart = new Chart();
        this.charts.set(label, chart);
        this.plots.append(element('figure', {}, element('figcaption', { text: label }), chart.root));
      }
      chart.show(plot);
    }
  }
}
