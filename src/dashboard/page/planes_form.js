// The form for planes and walls.

import { vec } from './arm.js';
import { read } from './fields.js';
import { element } from './notices.js';
import { SIDES, newPlane } from './planes.js';

/**
 * @typedef {import('./run_control.js').RunControl} RunControl
 * @typedef {import('./planes.js').Plane} Plane
 * @typedef {import('./setup.js').Setup} Setup
 * @typedef {(part: import('./setup.js').Change) => void} Change
 */

/** Largest distance of a plane from the base, m. */
const FARTHEST = 100;

/** @type {(runControl: RunControl, change: Change) => void} */
export function bind(runControl, change) {
  /** @type {HTMLSelectElement} */
  const side = element('plane-side');
  side.replaceChildren(...SIDES.map((name) => new Option(name, name)));
  const add = (/** @type {Plane['kind']} */ kind) => {
    const { tool } = runControl;
    if (!tool) return;
    change(({ planes }) => ({ planes: [...planes, newPlane(planes, kind, side.value, vec(tool.position))] }));
  };
  element('add-plane').onclick = () => add('plane');
  element('add-wall').onclick = () => add('wall');
}

/** Returns the items of the list. @type {(runControl: RunControl, change: Change) => HTMLElement[]} */
export function planeItems({ setup }, change) {
  const planes = setup?.planes ?? [];
  const replace = (/** @type {Plane} */ old, /** @type {Plane[]} */ ...next) =>
    change(({ planes: now }) => ({ planes: now.flatMap((plane) => (plane.name === old.name ? next : [plane])) }));
  return planes.map((plane) => {
    const item = document.createElement('li');
    const label = document.createElement('label');
    const field = document.createElement('input');
    Object.assign(field, { type: 'number', step: '0.01', value: String(plane.offset) });
    field.onchange = () => {
      const numbers = read(field, { least: -FARTHEST, most: FARTHEST });
      if (numbers) replace(plane, { ...plane, offset: numbers[0] });
    };
    label.append(`${plane.name}, ${plane.side} `, field, ' m');
    const remove = document.createElement('button');
    Object.assign(remove, { type: 'button', className: 'quiet', textContent: '✕', ariaLabel: `Remove ${plane.name}` });
    remove.onclick = () => replace(plane);
    item.append(label, remove);
    return item;
  });
}
