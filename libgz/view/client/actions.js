// @ts-check
/**
 * Actions: what users do by buttons, menus and keys, each said once.
 * @module
 */

/**
 * @typedef {'Time' | 'Edit' | 'Handles' | 'View' | 'Page'} Group
 *
 * @typedef {object} Action
 * @property {string | (() => string)} label
 * @property {import('libgz/icons.js').IconName | (() => import('libgz/icons.js').IconName)} icon
 * @property {Group} group
 * @property {string[]} [keys] such as Ctrl+S; names are those of `KeyboardEvent.key`, letters are capital
 * @property {boolean} [hold] whether a key that is held repeats it
 * @property {() => boolean} [offered] whether it is shown at all
 * @property {() => boolean} [can] whether it works now
 * @property {() => boolean} [on] of one that is switched on and off
 * @property {() => void} act
 *
 * @typedef {import('libgz/workplace.js').Workplace} Workplace
 */

export const RECORDED = 60; // [s] for the time line

/**
 * @param {Workplace} workplace
 */
export function makeActions(workplace) {
  const { store, ask } = workplace;
  /** @param {...string} verbs */
  const able = (...verbs) => store.control && verbs.some((verb) => store.abilities.has(verb));
  const selected = () => (store.selection ? store.entities.get(store.selection.entity) : undefined);
  /** @param {'translate' | 'rotate'} mode */
  const handles = (mode) => ({
    /** @type {Group} */
    group: 'Handles',
    offered: () => able('move'),
    on: () => store.handles.mode === mode,
    act: () => store.setHandles({ mode: store.handles.mode === mode ? 'none' : mode }),
  });

  /** @param {'undo' | 'redo'} verb @param {string} done */
  const history = async (verb, done) => {
    const answer = await ask(verb);
    if (answer) workplace.toasts.add(`${done}: ${answer.text ?? answer}`, 'info');
    else if (answer === null) workplace.toasts.add(`There is nothing to ${verb}.`, 'info');
  };

  /**
   * @param {'front' | 'back' | 'left' | 'right' | 'top' | 'iso'} side
   * @param {string} label
   * @param {string} key
   * @returns {Action}
   */
  const view = (side, label, key) => ({ label, icon: 'view', group: 'View', keys: [key], act: () => store.view(side) });

  /** @satisfies {Record<string, Action>} */
  const actions = {
    run: {
      label: () => (store.state?.paused ? 'Run' : 'Pause'),
      icon: () => (store.state?.paused ? 'play' : 'pause'),
      group: 'Time',
      keys: ['Space'],
      offered: () => able('pause'),
      act: () => ask('pause', store.state?.paused ? 'off' : 'on'),
    },
    step: {
      label: 'Step',
      icon: 'step',
      group: 'Time',
      keys: ['ArrowRight'],
      hold: true,
      offered: () => able('step'),
      act: () => (store.state?.paused ? ask('step', '1') : ask('pause', 'on')),
    },
    steps: {
      label: 'Ten steps',
      icon: 'step',
      group: 'Time',
      keys: ['ArrowUp'],
      hold: true,
      offered: () => able('step'),
      can: () => Boolean(store.state?.paused),
      act: () => ask('step', '10'),
    },
    earlier: {
      label: 'Back by a second',
      icon: 'rewind',
      group: 'Time',
      keys: ['ArrowLeft'],
      hold: true,
      offered: () => able('rewind', 'seek'),
      can: () => Boolean(store.state?.paused),
      act: () =>
        able('seek') && store.log
          ? ask('seek', String(Math.max(store.log.time - 1, store.log.begin)))
          : ask('rewind', '1'),
    },
    reset: { label: 'Reset', icon: 'reset', group: 'Time', keys: ['Ctrl+R'], offered: () => able('reset'), act: () => ask('reset') },
    record: {
      label: `Record ${RECORDED} s`,
      icon: 'record',
      group: 'Time',
      offered: () => able('keep'),
      on: () => workplace.timeline.recording,
      act: () => workplace.timeline.record(!workplace.timeline.recording),
    },

    undo: {
      label: 'Undo',
      icon: 'undo',
      group: 'Edit',
      keys: ['Ctrl+Z'],
      offered: () => able('undo'),
      act: () => history('undo', 'Undone'),
    },
    redo: {
      label: 'Redo',
      icon: 'redo',
      group: 'Edit',
      keys: ['Ctrl+Shift+Z', 'Ctrl+Y'],
      offered: () => able('redo'),
      act: () => history('redo', 'Redone'),
    },
    insert: {
      label: 'Insert',
      icon: 'plus',
      group: 'Edit',
      keys: ['I'],
      offered: () => able('insert'),
      act: () => workplace.dialogs.insert(),
    },
    save: {
      label: 'Save the world',
      icon: 'save',
      group: 'Edit',
      keys: ['Ctrl+S'],
      offered: () => able('write'),
      act: () => workplace.dialogs.save(),
    },
    duplicate: {
      label: 'Duplicate',
      icon: 'copy',
      group: 'Edit',
      keys: ['Ctrl+D'],
      offered: () => able('duplicate'),
      can: () => Boolean(selected()),
      act: () => workplace.dialogs.duplicate(),
    },
    align: {
      label: 'Align with another model',
      icon: 'align',
      group: 'Edit',
      keys: ['Ctrl+L'],
      offered: () => able('align'),
      can: () => Boolean(selected()),
      act: () => workplace.dialogs.align(),
    },
    remove: {
      label: 'Delete',
      icon: 'trash',
      group: 'Edit',
      keys: ['Delete'],
      offered: () => able('delete'),
      can: () => Boolean(selected()),
      act: () => workplace.dialogs.remove(),
    },
    deselect: {
      label: 'Select nothing',
      icon: 'close',
      group: 'Edit',
      keys: ['Escape'],
      act: () => store.select(null),
    },

    translate: { label: 'Move by handles', icon: 'move', keys: ['T'], ...handles('translate') },
    rotate: { label: 'Turn by handles', icon: 'rotate', keys: ['R'], ...handles('rotate') },
    space: {
      label: () => (store.handles.space === 'world' ? 'Handles along the world' : 'Handles along the model'),
      icon: () => (store.handles.space === 'world' ? 'world' : 'frame'),
      group: 'Handles',
      keys: ['L'],
      offered: () => able('move'),
      act: () => store.setHandles({ space: store.handles.space === 'world' ? 'local' : 'world' }),
    },
    snap: {
      label: 'Snap to 0.1 m and 15°',
      icon: 'magnet',
      group: 'Handles',
      keys: ['N'],
      offered: () => able('move'),
      on: () => store.handles.snap,
      act: () => store.setHandles({ snap: !store.handles.snap }),
    },

    fit: {
      label: 'Fit all',
      icon: 'fit',
      group: 'View',
      keys: ['Shift+F'],
      act: () => store.view('fit'),
    },
    focus: {
      label: 'Fit what is selected',
      icon: 'focus',
      group: 'View',
      keys: ['F'],
      act: () => (store.selection ? store.view({ focus: store.selection.entity }) : store.view('fit')),
    },
    follow: {
      label: 'Follow what is selected',
      icon: 'follow',
      group: 'View',
      keys: ['V'],
      can: () => Boolean(selected()) || store.follow !== null,
      on: () => store.follow !== null && (!store.selection || store.follow === store.selection.entity),
      act: () =>
        store.setFollow(store.selection && store.follow !== store.selection.entity ? store.selection.entity : null),
    },
    front: view('front', 'View from the front', '1'),
    back: view('back', 'View from behind', '2'),
    left: view('left', 'View from the left', '3'),
    right: view('right', 'View from the right', '4'),
    top: view('top', 'View from above', '5'),
    iso: view('iso', 'Oblique view', '6'),

    screenshot: { label: 'Screenshot', icon: 'camera', group: 'Page', keys: ['P'], act: () => workplace.takeScreenshot() },
    tree: {
      label: 'Tree',
      icon: 'left_panel',
      group: 'Page',
      keys: ['['],
      on: () => workplace.layout.isOpen('tree'),
      act: () => workplace.layout.toggle('tree'),
    },
    inspector: {
      label: 'Inspector',
      icon: 'right_panel',
      group: 'Page',
      keys: [']'],
      on: () => workplace.layout.isOpen('inspector'),
      act: () => workplace.layout.toggle('inspector'),
    },
    dock: {
      label: 'Plots and console',
      icon: 'bottom_panel',
      group: 'Page',
      keys: ['\\'],
      on: () => workplace.layout.isOpen('dock'),
      act: () => workplace.layout.toggle('dock'),
    },
    theme: {
      label: () => (store.theme === 'dark' ? 'Light theme' : 'Dark theme'),
      icon: () => (store.theme === 'dark' ? 'sun' : 'moon'),
      group: 'Page',
      act: () => workplace.setTheme(store.theme === 'dark' ? 'light' : 'dark'),
    },
    help: { label: 'Keys', icon: 'help', group: 'Page', keys: ['H', '?'], act: () => workplace.dialogs.help() },
  };
  return /** @type {Record<keyof typeof actions, Action>} */ (actions);
}

/** @param {Action} action */
export const labelOf = (action) => (typeof action.label === 'string' ? action.label : action.label());

/** @param {Action} action */
export const iconOf = (action) => (typeof action.icon === 'string' ? action.icon : action.icon());

/** @param {Action} action */
export const isOffered = (action) => action.offered?.() ?? true;

/** @param {Action} action */
export const isUsable = (action) => isOffered(action) && (action.can?.() ?? true);

const ARROWS = { Left: '←', Right: '→', Up: '↑', Down: '↓' };

/**
 * How a key is written for users.
 * @param {string} key
 */
export const keyName = (key) =>
  key.replace(/Arrow(\w+)/, (_, way) => ARROWS[/** @type {keyof typeof ARROWS} */ (way)]).replace('Delete', 'Del').replace('Escape', 'Esc').replaceAll('+', ' + ');

/**
 * An action as an entry of a menu.
 * @param {Action} action
 * @returns {import('libgz/menu.js').Entry}
 */
export const entryOf = (action) => ({
  label: labelOf(action),
  icon: iconOf(action),
  hint: action.keys?.[0] && keyName(action.keys[0]),
  disabled: !isUsable(action),
  checked: action.on?.(),
  action: () => action.act(),
});
