// @ts-check
/**
 * The page's icons: lines on a grid of 24 units, in the colour of the text beside them.
 * @module
 */

const SVG = 'http://www.w3.org/2000/svg';

/** Outlines; those whose name is in FILLED are filled. */
const PATHS = {
  play: ['M7 4.5v15l12-7.5z'],
  pause: ['M7 5h3.5v14H7z', 'M13.5 5H17v14h-3.5z'],
  step: ['M5 5v14l9-7z', 'M17 5v14'],
  reset: ['M4 12a8 8 0 1 0 2.6-5.9', 'M4 3.5v4.6h4.6'],
  speed: ['M4.2 17.5a9 9 0 1 1 15.6 0', 'M12 13.5l4-5'],
  record: ['M12 12m-8.5 0a8.5 8.5 0 1 0 17 0a8.5 8.5 0 1 0-17 0', 'M12 12m-3.2 0a3.2 3.2 0 1 0 6.4 0a3.2 3.2 0 1 0-6.4 0'],
  camera: ['M3.5 8h4l1.5-2.5h6L16.5 8h4v11h-17z', 'M12 13.3m-3.2 0a3.2 3.2 0 1 0 6.4 0a3.2 3.2 0 1 0-6.4 0'],
  moon: ['M19.5 14.5A8 8 0 0 1 9.5 4.5a8 8 0 1 0 10 10z'],
  sun: [
    'M12 12m-4 0a4 4 0 1 0 8 0a4 4 0 1 0-8 0',
    'M12 2.5v2.5M12 19v2.5M2.5 12H5M19 12h2.5M5.3 5.3L7 7M17 17l1.7 1.7M5.3 18.7L7 17M17 7l1.7-1.7',
  ],
  help: ['M9 9.2a3 3 0 1 1 4.2 2.7c-.8.4-1.2 1-1.2 2.1', 'M12 17.5v.1', 'M12 12m-9 0a9 9 0 1 0 18 0a9 9 0 1 0-18 0'],
  plus: ['M12 5v14M5 12h14'],
  close: ['M6 6l12 12M18 6L6 18'],
  save: ['M4.5 4.5h12l3 3v12h-15z', 'M8 4.5v5h7v-5', 'M8 19.5v-6h8v6'],
  undo: ['M8.5 5L4 9.5L8.5 14', 'M4 9.5h10a5.5 5.5 0 0 1 0 11h-3'],
  redo: ['M15.5 5L20 9.5L15.5 14', 'M20 9.5H10a5.5 5.5 0 0 0 0 11h3'],
  eye: ['M2.5 12C5 7.5 8.3 5.5 12 5.5s7 2 9.5 6.5c-2.5 4.5-5.8 6.5-9.5 6.5S5 16.5 2.5 12z', 'M12 12m-2.8 0a2.8 2.8 0 1 0 5.6 0a2.8 2.8 0 1 0-5.6 0'],
  hidden: ['M4 4l16 16', 'M9.5 6a9.5 9.5 0 0 1 2.5-.4c3.7 0 7 2 9.5 6.4a17 17 0 0 1-2.7 3.5M6 7.5A16 16 0 0 0 2.5 12C5 16.5 8.3 18.5 12 18.5a9.3 9.3 0 0 0 4-.9'],
  lock: ['M5.5 11h13v9h-13z', 'M8.5 11V8a3.5 3.5 0 0 1 7 0v3'],
  unlock: ['M5.5 11h13v9h-13z', 'M8.5 11V8a3.5 3.5 0 0 1 6.8-1.2'],
  search: ['M10.5 10.5m-6 0a6 6 0 1 0 12 0a6 6 0 1 0-12 0', 'M15 15l5.5 5.5'],
  right: ['M9.5 6l6 6l-6 6'],
  down: ['M6 9.5l6 6l6-6'],
  up: ['M6 14.5l6-6l6 6'],
  left: ['M14.5 6l-6 6l6 6'],
  more: ['M5.5 12m-1.3 0a1.3 1.3 0 1 0 2.6 0a1.3 1.3 0 1 0-2.6 0', 'M12 12m-1.3 0a1.3 1.3 0 1 0 2.6 0a1.3 1.3 0 1 0-2.6 0', 'M18.5 12m-1.3 0a1.3 1.3 0 1 0 2.6 0a1.3 1.3 0 1 0-2.6 0'],
  world: ['M12 12m-9 0a9 9 0 1 0 18 0a9 9 0 1 0-18 0', 'M3 12h18', 'M12 3c3 3 4 6 4 9s-1 6-4 9c-3-3-4-6-4-9s1-6 4-9z'],
  model: ['M12 3l8 4.5v9L12 21l-8-4.5v-9z', 'M4 7.5l8 4.5l8-4.5', 'M12 12v9'],
  robot: ['M5 9h14v10H5z', 'M12 9V5.5', 'M12 4.5v.1', 'M9 13v1.5M15 13v1.5', 'M2.5 12.5v3M21.5 12.5v3'],
  link: ['M5 8l7-3.5L19 8v8l-7 3.5L5 16z'],
  joint: ['M12 12m-3 0a3 3 0 1 0 6 0a3 3 0 1 0-6 0', 'M3 20l6.8-5.8M21 4l-6.8 5.8'],
  sensor: ['M12 12m-2 0a2 2 0 1 0 4 0a2 2 0 1 0-4 0', 'M7.5 16.5a6.4 6.4 0 0 1 0-9M16.5 7.5a6.4 6.4 0 0 1 0 9', 'M4.7 19.3a10.3 10.3 0 0 1 0-14.6M19.3 4.7a10.3 10.3 0 0 1 0 14.6'],
  light: ['M9 17.5h6M10 20.5h4', 'M9 17.5c0-2.5-3-4-3-7.5a6 6 0 0 1 12 0c0 3.5-3 5-3 7.5'],
  focus: ['M4 8.5V4h4.5M15.5 4H20v4.5M20 15.5V20h-4.5M8.5 20H4v-4.5', 'M12 12m-2.5 0a2.5 2.5 0 1 0 5 0a2.5 2.5 0 1 0-5 0'],
  fit: ['M4 8.5V4h4.5M15.5 4H20v4.5M20 15.5V20h-4.5M8.5 20H4v-4.5'],
  follow: ['M12 12m-6.5 0a6.5 6.5 0 1 0 13 0a6.5 6.5 0 1 0-13 0', 'M12 2.5v6M12 15.5v6M2.5 12h6M15.5 12h6'],
  move: ['M12 3v18M3 12h18', 'M9.5 5.5L12 3l2.5 2.5M9.5 18.5L12 21l2.5-2.5M5.5 9.5L3 12l2.5 2.5M18.5 9.5L21 12l-2.5 2.5'],
  rotate: ['M19.5 8A8.5 8.5 0 1 0 20.5 12', 'M20.5 3.5V8.5h-5'],
  select: ['M6 3.5l12.5 8l-5.8 1.4L9.5 18.5z'],
  magnet: ['M5 4.5h4.5v7.5a2.5 2.5 0 0 0 5 0V4.5H19V12a7 7 0 0 1-14 0z', 'M5 8.5h4.5M14.5 8.5H19'],
  frame: ['M5 19V6M5 19h13', 'M5 19l7-6', 'M3 8l2-2.5L7 8M16 17l2.5 2l-2.5 2'],
  trash: ['M4.5 7h15', 'M9 7V4.5h6V7', 'M6.5 7l1 13h9l1-13', 'M10 10.5v6M14 10.5v6'],
  copy: ['M8.5 8.5h11v11h-11z', 'M15.5 8.5v-4h-11v11h4'],
  plot: ['M4 4v16h16', 'M7 15l4-5l3.5 3L20 6.5'],
  console: ['M3.5 5h17v14h-17z', 'M7 9.5l3 2.5l-3 2.5M12.5 15h4'],
  image: ['M3.5 5h17v14h-17z', 'M4 17l5-5.5l4 4l3-2.5l4.5 4', 'M15.5 9v.1'],
  drive: ['M12 12m-8.5 0a8.5 8.5 0 1 0 17 0a8.5 8.5 0 1 0-17 0', 'M12 12m-2.5 0a2.5 2.5 0 1 0 5 0a2.5 2.5 0 1 0-5 0', 'M3.8 10.5l5.7 1M20.2 10.5l-5.7 1M12 14.5v6'],
  marks: ['M4 6h9M17 6h3M4 12h3M11 12h9M4 18h7M15 18h5', 'M15 6m-2 0a2 2 0 1 0 4 0a2 2 0 1 0-4 0', 'M9 12m-2 0a2 2 0 1 0 4 0a2 2 0 1 0-4 0', 'M13 18m-2 0a2 2 0 1 0 4 0a2 2 0 1 0-4 0'],
  view: ['M12 3l8 4.5v9L12 21l-8-4.5v-9z', 'M12 12v9M12 12L4 7.5M12 12l8-4.5'],
  warning: ['M12 4L2.8 19.5h18.4z', 'M12 10v4.5M12 17v.1'],
  error: ['M12 12m-9 0a9 9 0 1 0 18 0a9 9 0 1 0-18 0', 'M9 9l6 6M15 9l-6 6'],
  info: ['M12 12m-9 0a9 9 0 1 0 18 0a9 9 0 1 0-18 0', 'M12 11v5.5M12 7.5v.1'],
  download: ['M12 4v11M7.5 11L12 15.5L16.5 11', 'M4.5 19.5h15'],
  hand: ['M7 12V6.5a1.5 1.5 0 0 1 3 0V11V4.5a1.5 1.5 0 0 1 3 0V11V5.5a1.5 1.5 0 0 1 3 0V12V8.5a1.5 1.5 0 0 1 3 0V15c0 4-2.5 6-6 6c-3 0-4.5-1-6-3.5L4.5 14a1.5 1.5 0 0 1 2.5-1.5'],
  align: ['M4 3.5v17', 'M7.5 6h12v4.5h-12z', 'M7.5 13.5H15V18H7.5z'],
  check: ['M5 12.5l4.5 4.5L19 7'],
  rewind: ['M11.5 6v12L4 12z', 'M20 6v12l-7.5-6z'],
  left_panel: ['M3.5 5h17v14h-17z', 'M9 5v14'],
  right_panel: ['M3.5 5h17v14h-17z', 'M15 5v14'],
  bottom_panel: ['M3.5 5h17v14h-17z', 'M3.5 14h17'],
  edit: ['M4.5 19.5l1-4L16 5l3 3L8.5 18.5z'],
};

const FILLED = new Set(['play', 'pause', 'more']);

/** @typedef {keyof typeof PATHS} IconName */

/**
 * An icon; it is decoration, so whatever has it needs a label.
 * @param {IconName} name
 * @returns {SVGSVGElement}
 */
export function icon(name) {
  const image = document.createElementNS(SVG, 'svg');
  image.setAttribute('viewBox', '0 0 24 24');
  image.setAttribute('class', FILLED.has(name) ? 'icon filled' : 'icon');
  image.setAttribute('aria-hidden', 'true');
  for (const outline of PATHS[name]) {
    const path = document.createElementNS(SVG, 'path');
    path.setAttribute('d', outline);
    image.append(path);
  }
  return image;
}
