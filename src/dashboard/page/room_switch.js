// The switch that shows the shapes of the robot, the obstacles and their distances.

import { element } from './notices.js';

/**
 * @typedef {import('./types.js').Controller} Controller
 * @typedef {import('./types.js').Robot} Robot
 */

const STORAGE_KEY = 'revprio-shapes';

/** Returns whether the overlay is shown: as the user chose, else if the controller keeps clear of something. @type {(controller: Controller) => boolean} */
export function isShown(controller) {
  const kept = localStorage.getItem(STORAGE_KEY);
  return kept === null ? Boolean(controller.collisions) : kept === 'on';
}

/** @type {(roomController: () => Controller | undefined, onChange: () => void) => void} */
export function bind(roomController, onChange) {
  element('shapes').onclick = () => {
    const controller = roomController();
    if (!controller) return;
    localStorage.setItem(STORAGE_KEY, isShown(controller) ? 'off' : 'on');
    onChange();
  };
}

/** Shows the state of the switch. It is hidden where there is nothing to show. @type {(controller: Controller | undefined, robot: Robot | null) => void} */
export function show(controller, robot) {
  element('shapes').hidden = !robot?.shapes && !controller?.collisions;
  const pressed = String(controller ? isShown(controller) : false);
  if (element('shapes').ariaPressed !== pressed) element('shapes').ariaPressed = pressed;
}
