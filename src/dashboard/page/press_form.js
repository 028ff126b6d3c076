// The form of the presets `push` and `wipe`: one click starts a run in which the tool presses on a wall.

import { select } from './editing.js';
import { accept, read } from './fields.js';
import { element } from './notices.js';
import { SIDES } from './planes.js';
import { MOST_NEWTONS, MOST_SPEED } from './presets.js';
import { PLAYGROUND } from './setup.js';

/**
 * @typedef {import('./run_control.js').RunControl} RunControl
 * @typedef {import('./controls.js').Attempt} Attempt
 * @typedef {import('./presets.js').Press} Press
 */

/** @type {(id: string) => HTMLInputElement & HTMLSelectElement} */
const field = (id) => element(id);

/** @type {(runControl: RunControl, attempt: Attempt) => void} */
export function bind(runControl, attempt) {
  field('press-side').replaceChildren(...SIDES.map((side) => new Option(side, side)));
  field('press-along').replaceChildren(...['x', 'y', 'z'].map((axis) => new Option(axis, axis)));
  for (const kind of /** @type {const} */ (['push', 'wipe'])) {
    element(`press-${kind}`).onclick = () => attempt(async () => {
      const press = pressOf(kind);
      const robot = runControl.robot?.name;
      if (!press || !robot) return;
      await select(runControl, PLAYGROUND, robot, press);
      runControl.showSetup();
      await runControl.start(false);
    });
  }
  show(null);
}

/** Reads the form; null if a number is refused. @type {(kind: Press['kind']) => Press | null} */
function pressOf(kind) {
  const [newtons] = read(field('press-newtons'), { isOpen: true, most: MOST_NEWTONS }) ?? [];
  const isAuto = field('press-speed').value.trim() === '';
  if (isAuto) accept(field('press-speed'));
  const [speed] = isAuto ? [null] : (read(field('press-speed'), { isOpen: true, most: 1000 * MOST_SPEED }) ?? []);
  if (newtons === undefined || speed === undefined) return null;
  return { kind, side: field('press-side').value, newtons, along: field('press-along').value, speed: speed && speed / 1000 };
}

/** Shows a preset, or the proposed numbers. @type {(press: Press | null) => void} */
export function show(press) {
  for (const kind of ['push', 'wipe']) element(`press-${kind}`).ariaPressed = String(press?.kind === kind);
  const { side, newtons, along, speed } = press ?? { side: '−z', newtons: 15, along: 'y', speed: 0.01 };
  if (!press && field('press-side').value && field('press-newtons').value) return;
  field('press-side').value = side;
  field('press-newtons').value = String(newtons);
  field('press-along').value = along;
  field('press-speed').value = speed === null ? '' : String(1000 * speed);
}
