// @ts-check
/**
 * The switches of what the view shows, as entries of menus.
 * @module
 */

/** @typedef {import('libgz/menu.js').Entry} Entry */

/** Name of a switch, label, whether it can be set for one model alone. */
const SWITCHES = /** @type {const} */ ([
  ['Sensors', [['lasers', 'Laser rays', true], ['sonars', 'Sonar cones', true], ['frusta', 'Camera frusta', true]]],
  [
    'Mechanics',
    [
      ['contacts', 'Contacts', true],
      ['forces', 'Contact forces', true],
      ['axes', 'Joint axes', true],
      ['masses', 'Centres of mass', true],
      ['inertia', 'Inertia', true],
    ],
  ],
  [
    'Geometry',
    [
      ['frames', 'Frames', true],
      ['names', 'Names', true],
      ['boxes', 'Bounding boxes', true],
      ['trails', 'Trails', true],
      ['collisions', 'Collision shapes', true],
      ['wireframe', 'Wireframe', true],
      ['transparent', 'Transparent', true],
    ],
  ],
  ['View', [['grid', 'Grid', false], ['shadows', 'Shadows', false], ['skins', 'Fine skins of old robots', false]]],
]);

/** What needs an ability of the server. */
const NEEDS = /** @type {Record<string, string>} */ ({ contacts: 'contacts', forces: 'contacts' });

/**
 * @param {import('libgz/workplace.js').Workplace} workplace
 * @param {number} [entity] whose switches they are; without, those for all
 * @returns {Entry[]}
 */
export function marks({ store }, entity) {
  const entries = /** @type {Entry[]} */ ([]);
  for (const [heading, switches] of SWITCHES) {
    const shown = switches.filter(
      ([name, , single]) =>
        (entity === undefined || single) &&
        (!NEEDS[name] || store.abilities.has(NEEDS[name] ?? '')) &&
        (name !== 'skins' || store.scene?.era !== 'classic'),
    );
    if (!shown.length) continue;
    entries.push({ heading });
    for (const [name, label] of shown)
      entries.push({
        label,
        checked: store.isOn(name, entity),
        // What is shown for all cannot be hidden for one.
        disabled: entity !== undefined && store.isOn(name),
        hint: entity !== undefined && store.isOn(name) ? 'all' : undefined,
        action: () => store.setSwitch(name, !store.isOn(name, entity), entity),
      });
  }
  return entries;
}

/**
 * The menu for all, with the windows of images.
 * @param {import('libgz/workplace.js').Workplace} workplace
 * @returns {Entry[]}
 */
export function globalMarks(workplace) {
  const entries = marks(workplace);
  const images = workplace.images.offered();
  if (images.length) {
    entries.push({ heading: 'Images' });
    for (const { name, label } of images)
      entries.push({ label, checked: workplace.images.isOpen(name), action: () => workplace.images.toggle(name, label) });
  }
  if (workplace.drive.offered) {
    entries.push({ line: true });
    entries.push({ label: 'Drive panel', checked: workplace.drive.isOpen, action: () => workplace.drive.toggle() });
  }
  return entries;
}
