// @ts-check
/**
 * Plots: curves of values over sim time.
 * @module
 */

import uPlot from 'uplot';
import { element, fill, setText, show, throttled } from 'libgz/dom.js';
import { short } from 'libgz/format.js';
import { icon } from 'libgz/icons.js';
import { openMenu } from 'libgz/menu.js';
import { DRAGGED } from 'libgz/series.js';
import { recall, remember } from 'libgz/settings.js';

/**
 * @typedef {import('libgz/series.js').Series} Series
 * @typedef {import('libgz/workplace.js').Workplace} Workplace
 */

const MOST_PLOTS = 6;
const MOST_CURVES = 8;
const MOST_POINTS = 20000; // of each curve
const PERIOD = 100; // [ms] between two drawings
const NOISE = 1e-6; // of values, which counts as rest
const WINDOWS = [5, 10, 30, 60, 300]; // [s]
export const COLORS = ['#4c8dff', '#ff9f43', '#35c28a', '#e15b9b', '#a78bfa', '#27b8c9', '#d9b310', '#f26464'];

/** All plots, side by side. */
export class Plots {
  /** @param {Workplace} workplace */
  constructor(workplace) {
    this.workplace = workplace;
    /** @type {Plot[]} */
    this.plots = [];
    /** @type {Plot | undefined} that was used last */
    this.last = undefined;
    this.hint = element(
      'div',
      { class: 'plots-hint' },
      icon('plot'),
      element('p', { text: 'Drag a value from the inspector to here, or use the button beside it.' }),
    );
    this.area = element('div', { class: 'plots' }, this.hint);
    this.root = element('div', { class: 'panel-body plots-panel', 'aria-label': 'Plots' }, this.area);
    acceptSeries(this.root, (series) => this.add(series, true));
    const { store } = workplace;
    store.addEventListener('state', () => this.#sample());
    store.addEventListener('theme', () => this.plots.forEach((plot) => plot.draw()));
    for (const keys of recall('plots', /** @type {Series[][]} */ ([])).slice(0, MOST_PLOTS))
      if (Array.isArray(keys)) this.#restore(keys);
  }

  /** @param {unknown[]} list */
  #restore(list) {
    const some = list.filter(isSeries);
    const first = some[0];
    if (!first) return;
    const plot = this.add(first, true);
    for (const series of some.slice(1)) plot?.add(series);
  }

  /**
   * Plot a value: in the plot that was used last, or in a new one.
   * @param {Series} series
   * @param {boolean} [alone]
   */
  add(series, alone = false) {
    /** @type {Plot | undefined} */
    let plot = alone ? undefined : (this.plots.find((one) => one === this.last) ?? this.plots.at(-1));
    if (!plot || plot.full) {
      if (this.plots.length >= MOST_PLOTS) {
        this.workplace.toasts.add(`There are at most ${MOST_PLOTS} plots with ${MOST_CURVES} curves each.`, 'warning');
        return undefined;
      }
      plot = new Plot(this, this.workplace);
      this.plots.push(plot);
      this.area.append(plot.root);
    }
    plot.add(series);
    this.last = plot;
    this.changed();
    return plot;
  }

  /** @param {Plot} plot */
  remove(plot) {
    this.plots = this.plots.filter((one) => one !== plot);
    plot.root.remove();
    this.changed();
  }

  /** The keys of the fields of interfaces that are plotted. */
  fields() {
    const keys = this.plots.flatMap((plot) => plot.curves.map((curve) => JSON.parse(curve.key)));
    return keys.filter((parts) => parts[0] === 'field').map((parts) => String(parts[1]));
  }

  changed() {
    show(this.hint, !this.plots.length);
    remember('plots', this.plots.map((plot) => plot.curves.map(({ key, label, unit }) => ({ key, label, unit }))));
    const { store } = this.workplace;
    store.want('fields', [...new Set([...this.fields(), ...(this.workplace.inspector?.fields() ?? [])])]);
  }

  #sample() {
    const time = this.workplace.store.state?.simTime;
    if (time !== undefined) for (const plot of this.plots) plot.sample(time);
  }
}

/** @param {unknown} value @returns {value is Series} */
const isSeries = (value) => {
  const series = /** @type {Series | null} */ (value);
  return typeof series?.key === 'string' && typeof series.label === 'string' && typeof series.unit === 'string';
};

/**
 * Let values be dropped on an element.
 * @param {HTMLElement} target
 * @param {(series: Series) => void} add
 */
function acceptSeries(target, add) {
  /** @param {DragEvent} event */
  const fits = (event) => event.dataTransfer?.types.includes(DRAGGED);
  target.addEventListener('dragover', (event) => {
    if (!fits(event)) return;
    event.preventDefault();
    event.stopPropagation();
    target.classList.add('dropping');
  });
  target.addEventListener('dragleave', () => target.classList.remove('dropping'));
  target.addEventListener('drop', (event) => {
    target.classList.remove('dropping');
    if (!fits(event)) return;
    event.preventDefault();
    event.stopPropagation();
    try {
      const series = JSON.parse(event.dataTransfer?.getData(DRAGGED) ?? '');
      if (isSeries(series)) add(series);
    } catch {
      // Something else was dropped.
    }
  });
}

/** One plot with its curves. */
class Plot {
  /** @param {Plots} plots @param {Workplace} workplace */
  constructor(plots, workplace) {
    this.plots = plots;
    this.workplace = workplace;
    /** @type {(Series & { values: number[], color: string, figure: HTMLElement, item: HTMLElement })[]} */
    this.curves = [];
    /** @type {number[]} */
    this.times = [];
    this.window = 10;
    this.paused = false;
    this.legend = element('ul', { class: 'legend' });
    /** @param {import('libgz/icons.js').IconName} image @param {string} label @param {() => void} act */
    const tool = (image, label, act) =>
      element('button', { type: 'button', class: 'small', title: label, 'aria-label': label, on: { click: act } }, icon(image));
    this.pauseButton = tool('pause', 'Pause the plot', () => this.#pause());
    this.spanText = element('span', { text: `${this.window} s` });
    const span = element('button', { type: 'button', class: 'text small-text', title: 'Time shown', 'aria-haspopup': 'menu', 'aria-label': 'Time shown' }, this.spanText);
    span.addEventListener('click', () =>
      openMenu(
        span,
        () => WINDOWS.map((seconds) => ({ label: `${seconds} s`, choice: true, checked: seconds === this.window, action: () => this.#span(seconds) })),
        'Time shown',
      ),
    );
    this.canvas = element('div', { class: 'plot-canvas' });
    this.root = element(
      'section',
      { class: 'plot', 'aria-label': 'Plot', on: { pointerdown: () => (this.plots.last = this) } },
      element(
        'div',
        { class: 'plot-head' },
        this.legend,
        element(
          'div',
          { class: 'tools' },
          span,
          this.pauseButton,
          tool('trash', 'Clear the plot', () => this.#clear()),
          tool('download', 'Export as CSV', () => this.#export()),
          tool('close', 'Close the plot', () => this.plots.remove(this)),
        ),
      ),
      this.canvas,
    );
    acceptSeries(this.root, (series) => {
      this.add(series);
      this.plots.last = this;
      this.plots.changed();
    });
    this.drawSoon = throttled(() => this.draw(), PERIOD);
    /** @type {uPlot | null} */
    this.chart = null;
    this.made = '';
    new ResizeObserver(() => this.draw()).observe(this.canvas);
  }

  get full() {
    return this.curves.length >= MOST_CURVES;
  }

  /** @param {Series} series */
  add(series) {
    if (this.full || this.curves.some((curve) => curve.key === series.key)) return;
    const color = COLORS.find((one) => !this.curves.some((curve) => curve.color === one)) ?? '#888888';
    const figure = element('output', { class: 'figure' });
    const swatch = element('span', { class: 'swatch' });
    swatch.style.background = color;
    const item = element(
      'li',
      {},
      swatch,
      element('span', { class: 'legend-label', text: series.label, title: series.label }),
      figure,
      element('span', { class: 'unit', text: series.unit }),
      element(
        'button',
        { type: 'button', class: 'small quiet', 'aria-label': `Remove ${series.label}`, on: { click: () => this.#removeCurve(series.key) } },
        icon('close'),
      ),
    );
    this.legend.append(item);
    this.curves.push({ ...series, values: this.times.map(() => NaN), color, figure, item });
    this.drawSoon();
  }

  /** @param {string} key */
  #removeCurve(key) {
    const curve = this.curves.find((one) => one.key === key);
    curve?.item.remove();
    this.curves = this.curves.filter((one) => one !== curve);
    if (this.curves.length) this.plots.changed();
    else this.plots.remove(this);
    this.draw();
  }

  #pause() {
    this.paused = !this.paused;
    const label = this.paused ? 'Continue the plot' : 'Pause the plot';
    fill(this.pauseButton, icon(this.paused ? 'play' : 'pause'));
    this.pauseButton.title = label;
    this.pauseButton.setAttribute('aria-label', label);
    if (!this.paused) this.#clear();
  }

  /** @param {number} seconds */
  #span(seconds) {
    this.window = seconds;
    setText(this.spanText, `${seconds} s`);
    this.draw();
  }

  #clear() {
    this.times = [];
    for (const curve of this.curves) curve.values = [];
    this.draw();
  }

  #export() {
    const quoted = (/** @type {string} */ text) => `"${text.replaceAll('"', '""')}"`;
    const head = ['sim time [s]', ...this.curves.map(({ label, unit }) => (unit ? `${label} [${unit}]` : label))];
    const lines = this.times.map((time, i) => [Number(time.toFixed(6)), ...this.curves.map((curve) => curve.values[i] ?? NaN)]);
    const rows = lines.map((line) => line.map((value) => (Number.isFinite(value) ? String(value) : '')).join(','));
    const text = [head.map(quoted).join(','), ...rows, ''].join('\r\n');
    this.workplace.download(new Blob([text], { type: 'text/csv' }), 'plot.csv');
  }

  /**
   * Take the present values.
   * @param {number} time sim time [s]
   */
  sample(time) {
    const { sampler } = this.workplace;
    if (!this.paused && time < (this.times.at(-1) ?? -Infinity)) {
      // A reset, or back in time: what is after that has not happened.
      const kept = this.times.findIndex((one) => one >= time);
      this.times.length = kept;
      for (const curve of this.curves) curve.values.length = kept;
    }
    const later = !this.paused && time > (this.times.at(-1) ?? -Infinity);
    if (later) this.times.push(time);
    for (const curve of this.curves) {
      const value = sampler.read(curve.key);
      setText(curve.figure, short(Number(value.toFixed(4))));
      if (later) curve.values.push(value);
    }
    if (this.paused) return;
    if (this.times.length > MOST_POINTS) {
      this.times.splice(0, MOST_POINTS / 10);
      for (const curve of this.curves) curve.values.splice(0, MOST_POINTS / 10);
    }
    this.drawSoon();
  }

  draw() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (width < 40 || height < 30) return;
    const axis = axisOf(11);
    const shape = JSON.stringify([this.curves.map((curve) => curve.key), axis]);
    if (!this.chart || this.made !== shape) {
      this.made = shape;
      this.chart?.destroy();
      this.chart = new uPlot(
        {
          width,
          height,
          legend: { show: false },
          padding: [8, 8, 0, 0],
          cursor: { drag: { x: false, y: false }, points: { size: 5 } },
          scales: { x: { time: false }, y: { range: (_, low, high) => rangeOf(low, high) } },
          axes: [
            { ...axis, size: 26, values: (_, ticks) => ticks.map((tick) => `${short(tick)}`) },
            { ...axis, size: 52, values: (_, ticks) => ticks.map((tick) => short(tick)) },
          ],
          series: [{}, ...this.curves.map(({ color, label }) => ({ label, stroke: color, width: 1.5, points: { show: false } }))],
        },
        [[]],
        this.canvas,
      );
    } else if (this.chart.width !== width || this.chart.height !== height) this.chart.setSize({ width, height });
    const end = this.times.at(-1) ?? 0;
    let first = 0;
    for (let low = 0, high = this.times.length; low < high; ) {
      const middle = (low + high) >> 1;
      if ((this.times[middle] ?? 0) < end - this.window) low = middle + 1;
      else high = middle;
      first = low;
    }
    this.chart.setData(/** @type {uPlot.AlignedData} */ ([this.times.slice(first), ...this.curves.map((curve) => curve.values.slice(first).map((value) => (Number.isFinite(value) ? value : null)))]), false);
    this.chart.batch(() => {
      const begin = Math.max(end - this.window, this.times[0] ?? 0);
      this.chart?.setScale('x', { min: begin, max: Math.max(end, begin + this.window) });
    });
  }
}

/**
 * An axis in the colours of the theme.
 * @param {number} size of its figures [px]
 */
function axisOf(size) {
  const style = getComputedStyle(document.documentElement);
  const [stroke, line, font] = ['--text-soft', '--line', '--font'].map((name) => style.getPropertyValue(name).trim());
  return { stroke, font: `${size}px ${font}`, grid: { stroke: line, width: 1 }, ticks: { stroke: line, width: 1, size: 4 } };
}

/**
 * What is shown of values; noise of what rests is not.
 * @param {number | null} low the least value; null without values
 * @param {number | null} high
 * @returns {[number, number]}
 */
function rangeOf(low, high) {
  if (low === null || high === null) return [0, 1];
  const middle = (low + high) / 2;
  const least = NOISE * Math.max(Math.abs(middle), 1);
  const half = high - low < least ? Math.max(0.1 * Math.abs(middle), 0.1) : 0.55 * (high - low);
  return [middle - half, middle + half];
}

/**
 * A chart of given curves, such as a GUI plugin's.
 */
export class Chart {
  constructor() {
    this.root = element('div', { class: 'plot-canvas fixed' });
    /** @type {uPlot | null} */
    this.chart = null;
    this.made = '';
  }

  /** @param {{ x: number[], lines: Record<string, number[]> }} plot */
  show({ x, lines }) {
    const width = this.root.clientWidth || 220;
    const axis = axisOf(10);
    const shape = JSON.stringify([Object.keys(lines), axis]);
    if (!this.chart || this.made !== shape) {
      this.made = shape;
      this.chart?.destroy();
      this.chart = new uPlot(
        {
          width,
          height: 140,
          scales: { x: { time: false } },
          legend: { live: false },
          axes: [{ ...axis, size: 24 }, { ...axis, size: 44 }],
          series: [{}, ...Object.keys(lines).map((label, i) => ({ label, stroke: COLORS[i % COLORS.length] ?? axis.stroke, width: 1.5 }))],
        },
        [[]],
        this.root,
      );
    } else if (this.chart.width !== width) this.chart.setSize({ width, height: 140 });
    this.chart.setData(/** @type {uPlot.AlignedData} */ ([x, ...Object.values(lines)]));
  }
}
