// Force arrows and the target in the scene.

import { vec } from './arm.js';
import { add, dot, norm, scale, sub, unit } from './geometry.js';
import { palette } from './theme.js';

/**
 * @typedef {import('./types.js').Vec3} Vec3
 * @typedef {import('./geometry.js').Camera} Camera
 * @typedef {import('./scene.js').World} World
 * @typedef {import('./theme.js').Palette} Palette
 */

/** Returns the length of a force arrow, m: linear for small forces, logarithmic for large ones. @type {(newton: number) => number} */
const arrowLength = (newton) => 0.12 * Math.asinh(newton / 10);

/** Height of a label, px. */
const LABEL_HEIGHT = 16;

/** Radius of the drawn target, px. */
const GOAL_RADIUS = 9;

/** Draws the target that can be dragged, with a line from the tool. @type {(context: CanvasRenderingContext2D, camera: Camera, world: World, colours: Palette) => void} */
export function target(context, camera, { goal, arm }, colours) {
  if (!goal) return;
  const spot = camera.project(vec(goal.pose.position));
  if (arm) {
    const tool = camera.project(vec(arm.tool.position));
    context.strokeStyle = colours.goal;
    context.lineWidth = 1.2;
    context.setLineDash([3, 3]);
    context.beginPath();
    context.moveTo(tool.x, tool.y);
    context.lineTo(spot.x, spot.y);
    context.stroke();
    context.setLineDash([]);
  }
  for (const [radius, width, colour] of /** @type {[number, number, string][]} */ ([
    [GOAL_RADIUS, 5, colours.scene], [GOAL_RADIUS, 2.2, colours.goal], [2.5, 3, colours.goal],
  ])) {
    context.strokeStyle = colour;
    context.lineWidth = width;
    context.beginPath();
    context.arc(spot.x, spot.y, radius, 0, 2 * Math.PI);
    context.stroke();
  }
}

/** @type {(context: CanvasRenderingContext2D, camera: Camera, world: World, colours: Palette) => void} */
export function forces(context, camera, world, colours) {
  if (!world.arm) return;
  const tool = vec(world.arm.tool.position);
  const target = /** @type {Vec3} */ (world.target.map((value) => value ?? 0));
  if (norm(target) > 0.1) arrow(context, camera, tool, target, colours.text, true, '');
  if (norm(world.force) > 0.2) {
    // The sign of a contact says the force, too.
    const label = world.signs?.states.length ? '' : `${norm(world.force).toFixed(1)} N`;
    arrow(context, camera, tool, world.force, colours.accent, false, label);
  }
  if (norm(world.push) > 0.2) {
    const from = sub(tool, scale(unit(world.push), arrowLength(norm(world.push))));
    arrow(context, camera, from, world.push, colours.axes[2], false, `push ${norm(world.push).toFixed(0)} N`);
  }
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {Camera} camera
 * @param {Vec3} from
 * @param {Vec3} force
 * @param {string} colour
 * @param {boolean} outlined
 * @param {string} label
 */
function arrow(context, camera, from, force, colour, outlined, label) {
  const to = add(from, scale(unit(force), arrowLength(norm(force))));
  const [a, b] = [camera.project(from), camera.project(to)];
  const length = Math.hypot(b.x - a.x, b.y - a.y);
  context.strokeStyle = colour;
  context.fillStyle = colour;
  if (length > 3) {
    const [dx, dy] = [(b.x - a.x) / length, (b.y - a.y) / length];
    const head = Math.min(13, 0.6 * length);
    context.lineWidth = outlined ? 1.5 : 4;
    context.lineCap = 'butt';
    context.setLineDash(outlined ? [4, 3] : []);
    context.beginPath();
    context.moveTo(a.x, a.y);
    context.lineTo(b.x - dx * head, b.y - dy * head);
    context.stroke();
    context.setLineDash([]);
    context.beginPath();
    context.moveTo(b.x, b.y);
    context.lineTo(b.x - dx * head - dy * head * 0.5, b.y - dy * head + dx * head * 0.5);
    context.lineTo(b.x - dx * head + dy * head * 0.5, b.y - dy * head - dx * head * 0.5);
    context.closePath();
    if (outlined) context.stroke();
    else context.fill();
  }
  if (!label) return;
  context.font = '600 13px system-ui, sans-serif';
  context.textAlign = dot(unit(force), camera.right) >= 0 ? 'left' : 'right';
  context.textBaseline = 'bottom';
  context.lineWidth = 4;
  context.lineJoin = 'round';
  context.strokeStyle = haloColour(context) ?? colour;
  const { x, y } = inside(camera, b.x + (context.textAlign === 'left' ? 8 : -8), b.y - 4, context.measureText(label).width, context.textAlign);
  context.strokeText(label, x, y);
  context.fillText(label, x, y);
}

/** Moves a label into the part of the scene that no panel covers. @type {(camera: Camera, x: number, y: number, width: number, align: 'left' | 'right') => {x: number, y: number}} */
function inside({ free }, x, y, width, align) {
  const [before, after] = align === 'left' ? [0, width] : [width, 0];
  const clamp = (/** @type {number} */ value, /** @type {number} */ low, /** @type {number} */ high) => Math.max(low, Math.min(high, value));
  return {
    x: clamp(x, free.left + before, free.left + free.width - after),
    y: clamp(y, free.top + LABEL_HEIGHT, free.top + free.height),
  };
}

/** @type {(context: CanvasRenderingContext2D) => string | null} colour of the outline that keeps labels readable */
function haloColour(context) {
  return context.canvas.width > 0 ? palette().scene : null;
}
