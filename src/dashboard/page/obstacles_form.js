// The form for obstacles.

import { vec } from './arm.js';
import { read } from './fields.js';
import { element } from './notices.js';
import { middle, newObstacle, obstaclesOf, placed } from './obstacles.js';

/**
 * @typedef {import('./run_control.js').RunControl} RunControl
 * @typedef {import('./obstacles.js').Kind} Kind
 * @typedef {import('./planes_form.js').Change} Change
 * @typedef {import('./types.js').RoomObstacle} RoomObstacle
 * @typedef {import('./types.js').Vec3} Vec3
 */

/** Largest distance of an obstacle from the base along an axis, m. */
const FARTHEST = 100;

const KINDS = /** @type {const} */ (['sphere', 'post', 'box']);

/** @type {(runControl: RunControl, change: Change) => void} */
export function bind(runControl, change) {
  for (const kind of KINDS) {
    element(`add-${kind}`).onclick = () => {
      const { tool } = runControl;
      const more = (/** @type {RoomObstacle[]} */ obstacles) => [...obstacles, newObstacle(obstacles, kind, vec(/** @type {any} */ (tool).position))];
      if (tool) change(() => ({ obstacles: more(obstaclesOf(runControl)) }));
    };
  }
}

/** Shows the obstacles. A robot without shapes cannot keep clear of them. @type {(runControl: RunControl, change: Change) => void} */
export function show(runControl, change) {
  element('obstacles-part').hidden = !runControl.robot?.shapes;
  element('obstacles').replaceChildren(...items(runControl, change));
}

/** @type {(runControl: RunControl, change: Change) => HTMLElement[]} */
function items(runControl, change) {
  const obstacles = obstaclesOf(runControl);
  const replace = (/** @type {RoomObstacle} */ old, /** @type {RoomObstacle[]} */ ...next) =>
    change(() => ({ obstacles: obstaclesOf(runControl).flatMap((obstacle) => (obstacle.name === old.name ? next : [obstacle])) }));
  return obstacles.map((obstacle) => {
    const item = document.createElement('li');
    const label = document.createElement('label');
    const at = middle(obstacle);
    label.append(`${obstacle.name} `);
    if (at && !obstacle.moves) label.append(placeField(at, (place) => replace(obstacle, placed(obstacle, place))), ' m');
    const remove = document.createElement('button');
    Object.assign(remove, { type: 'button', className: 'quiet', textContent: '✕', ariaLabel: `Remove ${obstacle.name}` });
    remove.onclick = () => replace(obstacle);
    item.append(label, remove);
    return item;
  });
}

/** Returns a field for the middle of an obstacle. @type {(place: Vec3, onPlace: (place: Vec3) => void) => HTMLElement} */
function placeField(place, onPlace) {
  const field = document.createElement('input');
  Object.assign(field, { type: 'text', className: 'place', title: 'x y z of its middle, m' });
  field.value = place.map((value) => String(Math.round(value * 1000) / 1000)).join(' ');
  field.onchange = () => {
    const numbers = read(field, { count: 3, least: -FARTHEST, most: FARTHEST });
    if (numbers) onPlace(vec(numbers));
  };
  return field;
}
