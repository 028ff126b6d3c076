// A slider that parts the scene: the arm on the left of the line, the arm of the other method on the right.

import { element } from './notices.js';
import { methodName } from './setup.js';

/**
 * @typedef {import('./run_control.js').RunControl} RunControl
 * @typedef {import('./geometry.js').Camera} Camera
 * @typedef {import('./theme.js').Palette} Palette
 */

/** @param {() => void} onChange */
export function bind(onChange) {
  element('wipe').oninput = onChange;
}

/** Returns the part of the free scene that shows the first arm, 0 to 1; 1: the second arm is a ghost. @type {(runControl: RunControl) => number} */
export function wipeOf({ ghost }) {
  return ghost ? Number(/** @type {HTMLInputElement} */ (element('wipe')).value) / 100 : 1;
}

/** Shows the slider where there are two arms to compare. @param {boolean} isShown */
export function show(isShown) {
  const field = element('wipe-field');
  if (field.hidden === isShown) field.hidden = !isShown;
}

/** Returns the place of the line in the picture, px. @type {(camera: Camera, wipe: number) => number} */
export const lineOf = ({ free }, wipe) => free.left + wipe * free.width;

/** Draws the line with the names of the methods. @type {(context: CanvasRenderingContext2D, camera: Camera, wipe: number, names: [string, string], colours: Palette) => void} */
export function drawLine(context, camera, wipe, names, colours) {
  const x = lineOf(camera, wipe);
  const { top, height } = camera.free;
  context.strokeStyle = colours.text;
  context.lineWidth = 1.5;
  context.beginPath();
  context.moveTo(x, top + 30);
  context.lineTo(x, top + height);
  context.stroke();
  context.font = '600 12px system-ui, sans-serif';
  context.textBaseline = 'bottom';
  context.lineJoin = 'round';
  context.lineWidth = 4;
  context.strokeStyle = colours.scene;
  context.fillStyle = colours.text;
  names.forEach((name, i) => {
    context.textAlign = i === 0 ? 'right' : 'left';
    const at = x + (i === 0 ? -8 : 8);
    context.strokeText(methodName(name), at, top + height - 40);
    context.fillText(methodName(name), at, top + height - 40);
  });
}
