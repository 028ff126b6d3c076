// What the scene shows of the tasks: the velocity of the tool and what it gives up, target frames, limits and distances.

import { vec } from './arm.js';
import { contactColour, contactSigns } from './contact_signs.js';
import { add, cross, dot, norm, scale, sub, unit } from './geometry.js';
import { positionRows } from './goals.js';
import { distance, quantity } from './number.js';
import { activeLimits, rests } from './reason.js';
import { rotate } from './rotation.js';
import { shownSample } from './view.js';

/**
 * @typedef {import('./types.js').Vec3} Vec3
 * @typedef {import('./types.js').LiveSample} LiveSample
 * @typedef {import('./geometry.js').Camera} Camera
 * @typedef {import('./kinematics.js').Kinematics} Kinematics
 * @typedef {import('./run_control.js').RunControl} RunControl
 * @typedef {import('./scene.js').Contact} Contact
 * @typedef {import('./theme.js').Palette} Palette
 * @typedef {import('./view.js').View} View
 *
 * @typedef {object} LimitSign the range of a joint at a limit
 * @property {Vec3} center
 * @property {Vec3} axis
 * @property {Vec3} pointer direction that turns with the joint
 * @property {number} lower angle from the pointer to the lower end of the range, rad
 * @property {number} upper
 * @property {('lower' | 'upper')[]} sides
 * @property {string} text
 *
 * @typedef {object} Signs
 * @property {Vec3} tool
 * @property {Vec3} velocity of the tool, m/s
 * @property {{name: string, velocity: Vec3}[]} givenUp requested minus achieved velocity of the tool per task, m/s
 * @property {{position: Vec3, axes: Vec3[]}[]} frames of the tool and of its target
 * @property {LimitSign[]} limits
 * @property {{at: Vec3, foot: Vec3, text: string}[]} planes
 * @property {import('./contact_signs.js').ContactSign[]} states of the contacts of the tasks
 * @property {number} size of the arm, m
 */

/** Smallest shown velocity, m/s, and the length of an arrow per velocity, s. */
const MIN_VELOCITY = 2e-3;
const ARROW = 0.6;

/** Largest length of an arrow, of a frame, and radius of an arc, as parts of the size of the arm. */
const LONGEST = 0.22;
const FRAME = 0.055;
const RADIUS = 0.085;

/** Distance below which a plane shows its number, m. */
const NEAR_PLANE = 0.5;

/** Radius of the ring of a contact, px. */
const RING = 13;

/** Height of a line of text, px. */
const LINE = 18;

/** Font of the texts. */
const FONT = '600 12px system-ui, sans-serif';

/** Steps of a drawn arc. */
const STEPS = 40;

/** Returns what the scene shows of the tasks. @type {(runControl: RunControl, view: Pick<View, 'robot' | 'labels' | 'controller'>, kinematics: Kinematics, position: number[], contacts: Contact[], goal: import('./target.js').Goal | null) => Signs | null} */
export function signsOf(runControl, view, kinematics, position, contacts, goal) {
  if (position.length !== kinematics.joints.length) return null;
  const frames = kinematics.frames(position);
  const tool = kinematics.tool(frames);
  const sample = shownSample(runControl);
  const columns = kinematics.jacobian(frames);
  const speeds = sample?.joint_velocity ?? [];
  const velocity = columns.map((column, i) => scale(vec(column), speeds[i] ?? 0)).reduce(add);
  return {
    tool: tool.position,
    velocity,
    givenUp: sample && !rests(sample) ? givenUp(view, sample) : [],
    frames: goal && turns(goal.task) ? [tool, { position: vec(goal.pose.position), orientation: goal.pose.orientation }].map(axesOf) : [],
    limits: sample ? limitSigns(view, sample, frames, position) : [],
    planes: contacts.filter(({ isVirtual }) => isVirtual).flatMap((plane) => planeSign(plane, tool.position)),
    states: contactSigns(view.controller, sample),
    size: kinematics.reach,
  };
}

/** @type {(task: import('./types.js').ControllerTask) => boolean} */
const turns = (task) => (task.axes ?? []).some((axis) => axis.length === 2) && positionRows(task).some(Boolean);

/** @type {(frame: import('./urdf.js').Placement) => {position: Vec3, axes: Vec3[]}} */
const axesOf = ({ position, orientation }) =>
  ({ position, axes: /** @type {Vec3[]} */ ([[1, 0, 0], [0, 1, 0], [0, 0, 1]]).map((axis) => rotate(orientation, axis)) });

/** @type {(view: Pick<View, 'controller'>, sample: LiveSample) => {name: string, velocity: Vec3}[]} */
function givenUp({ controller }, sample) {
  return (controller?.tasks ?? []).flatMap((task, k) => {
    if (task.link || task.relative_to || (task.frame ?? 'base') !== 'base') return [];
    const residual = sample.task_residuals[k] ?? [];
    const velocity = vec(['x', 'y', 'z'].map((axis) => {
      const row = (task.axes ?? []).findIndex((known) => known === axis);
      return row < 0 ? 0 : -(residual[row] ?? 0);
    }));
    return norm(velocity) > MIN_VELOCITY ? [{ name: task.name, velocity }] : [];
  });
}

/** @type {(view: Pick<View, 'robot' | 'labels'>, sample: LiveSample, frames: import('./urdf.js').Placement[], position: number[]) => LimitSign[]} */
function limitSigns(view, sample, frames, position) {
  return activeLimits(view, sample).flatMap(({ joint, label, text, sides }) => {
    const range = view.robot?.joints[joint].position_limit;
    const { position: center, orientation } = frames[joint];
    const [low, high] = range ?? [position[joint] - Math.PI, position[joint] + Math.PI];
    return [{
      center, sides, axis: rotate(orientation, [0, 0, 1]), pointer: rotate(orientation, [1, 0, 0]),
      lower: low - position[joint], upper: high - position[joint], text: `${label} ${text.replace(/^is /, '')}`,
    }];
  });
}

/** @type {(plane: Contact, tool: Vec3) => {at: Vec3, foot: Vec3, text: string}[]} */
function planeSign({ at, inwards }, tool) {
  const away = dot(sub(at, tool), inwards);
  if (Math.abs(away) > NEAR_PLANE) return [];
  return [{ at: tool, foot: add(tool, scale(inwards, away)), text: distance(Number(away.toFixed(3))) }];
}

/** Draws the signs on the canvas over the scene. @type {(context: CanvasRenderingContext2D, camera: Camera, signs: Signs, colours: Palette) => void} */
export function drawSigns(context, camera, signs, colours) {
  for (const { at, foot, text } of signs.planes) {
    line(context, camera, [at, foot], colours.ghost, 1.4, [4, 3]);
    label(context, camera, add(at, scale(sub(foot, at), 0.5)), text, colours.ghost, colours);
  }
  signs.frames.forEach(({ position, axes }, i) => axes.forEach((axis, k) =>
    line(context, camera, [position, add(position, scale(axis, FRAME * signs.size))], colours.axes[k], i === 0 ? 2.2 : 1.4, i === 0 ? [] : [3, 2])));
  for (const limit of signs.limits) drawLimit(context, camera, limit, signs.size, colours);
  drawVelocity(context, camera, signs, colours);
  drawContacts(context, camera, signs, colours);
}

/** Draws a ring about the tool in the colour of each contact, with its state, force and target. @type {(context: CanvasRenderingContext2D, camera: Camera, signs: Signs, colours: Palette) => void} */
function drawContacts(context, camera, { tool, states }, colours) {
  const { x, y } = camera.project(tool);
  states.forEach(({ state }, i) => {
    context.strokeStyle = contactColour(state, colours);
    context.lineWidth = 3.5;
    context.beginPath();
    context.arc(x, y, RING + 6 * i, 0, 2 * Math.PI);
    context.stroke();
  });
  const [left, end] = [x + RING + 8, camera.free.left + camera.free.width];
  const lines = states.flatMap(({ state, text }) => wrapped(context, text, end - left).map((part) => ({ part, colour: contactColour(state, colours) })));
  const widest = Math.max(0, ...lines.map(({ part }) => context.measureText(part).width));
  lines.forEach(({ part, colour }, i) => write(context, camera, Math.min(left, end - widest), y + RING + 4 + LINE * i, part, colour, colours));
}

/** Breaks a text that is too wide after its colon. @type {(context: CanvasRenderingContext2D, text: string, width: number) => string[]} */
function wrapped(context, text, width) {
  context.font = FONT;
  return context.measureText(text).width > width ? text.split(/(?<=:) /) : [text];
}

/** Draws the velocity of the tool, and from its end what each task gives up, which fades. @type {(context: CanvasRenderingContext2D, camera: Camera, signs: Signs, colours: Palette) => void} */
function drawVelocity(context, camera, { tool, velocity, givenUp: lost, size }, colours) {
  const shown = (/** @type {Vec3} */ v) => scale(unit(v), Math.min(LONGEST * size, ARROW * norm(v)));
  const end = norm(velocity) > MIN_VELOCITY ? add(tool, shown(velocity)) : tool;
  if (end !== tool) arrow(context, camera, tool, end, colours.axes[2], 1);
  for (const { name, velocity: missing } of lost) {
    const ghost = add(end, shown(missing));
    for (const [part, alpha] of /** @type {[number, number][]} */ ([[0.34, 0.75], [0.67, 0.5], [1, 0.3]])) {
      arrow(context, camera, end, add(end, scale(sub(ghost, end), part)), colours.alarm, alpha);
    }
    label(context, camera, ghost, `“${name}” −${quantity(norm(missing), 'm/s', 2)}`, colours.alarm, colours);
  }
}

/** Draws the range of a joint as an arc, its pointer, and the end that it is at. @type {(context: CanvasRenderingContext2D, camera: Camera, limit: LimitSign, size: number, colours: Palette) => void} */
function drawLimit(context, camera, { center, axis, pointer, lower, upper, sides, text }, size, colours) {
  const radius = RADIUS * size;
  const side = cross(axis, pointer);
  const at = (/** @type {number} */ angle, /** @type {number} */ r) =>
    add(center, add(scale(pointer, r * Math.cos(angle)), scale(side, r * Math.sin(angle))));
  const [from, to] = [Math.max(lower, -2 * Math.PI), Math.min(upper, 2 * Math.PI)];
  const arc = Array.from({ length: STEPS + 1 }, (_, i) => at(from + ((to - from) * i) / STEPS, radius));
  line(context, camera, arc, colours.muted, 2.5, []);
  line(context, camera, [center, at(0, 1.4 * radius)], colours.alarm, 2.5, []);
  for (const end of sides) {
    const angle = end === 'lower' ? from : to;
    const near = Array.from({ length: 9 }, (_, i) => at(angle + ((end === 'lower' ? 1 : -1) * 0.5 * i) / 8, radius));
    line(context, camera, near, colours.alarm, 5, []);
  }
  label(context, camera, at(0, 1.5 * radius), text, colours.alarm, colours);
}

/** @type {(context: CanvasRenderingContext2D, camera: Camera, points: Vec3[], colour: string, width: number, dash: number[]) => void} */
function line(context, camera, points, colour, width, dash) {
  context.strokeStyle = colour;
  context.lineWidth = width;
  context.lineCap = 'round';
  context.lineJoin = 'round';
  context.setLineDash(dash);
  context.beginPath();
  points.map((point) => camera.project(point)).forEach(({ x, y }, i) => (i === 0 ? context.moveTo(x, y) : context.lineTo(x, y)));
  context.stroke();
  context.setLineDash([]);
}

/** @type {(context: CanvasRenderingContext2D, camera: Camera, from: Vec3, to: Vec3, colour: string, alpha: number) => void} */
function arrow(context, camera, from, to, colour, alpha) {
  const [a, b] = [camera.project(from), camera.project(to)];
  const length = Math.hypot(b.x - a.x, b.y - a.y);
  if (length < 4) return;
  const [dx, dy] = [(b.x - a.x) / length, (b.y - a.y) / length];
  const head = Math.min(10, 0.6 * length);
  context.globalAlpha = alpha;
  context.strokeStyle = colour;
  context.fillStyle = colour;
  context.lineWidth = 2.4;
  context.beginPath();
  context.moveTo(a.x, a.y);
  context.lineTo(b.x - dx * head, b.y - dy * head);
  context.stroke();
  context.beginPath();
  context.moveTo(b.x, b.y);
  context.lineTo(b.x - dx * head - dy * head * 0.45, b.y - dy * head + dx * head * 0.45);
  context.lineTo(b.x - dx * head + dy * head * 0.45, b.y - dy * head - dx * head * 0.45);
  context.fill();
  context.globalAlpha = 1;
}

/** @type {(context: CanvasRenderingContext2D, camera: Camera, at: Vec3, text: string, colour: string, colours: Palette) => void} */
function label(context, camera, at, text, colour, colours) {
  const { x, y } = camera.project(at);
  write(context, camera, x + 8, y, text, colour, colours);
}

/** Writes a text that stays in the free part of the scene. @type {(context: CanvasRenderingContext2D, camera: Camera, x: number, y: number, text: string, colour: string, colours: Palette) => void} */
function write(context, camera, x, y, text, colour, colours) {
  context.font = FONT;
  context.textAlign = 'left';
  context.textBaseline = 'middle';
  context.lineJoin = 'round';
  context.lineWidth = 4;
  const { free } = camera;
  const left = Math.max(free.left, Math.min(x, free.left + free.width - context.measureText(text).width));
  context.strokeStyle = colours.scene;
  context.strokeText(text, left, y);
  context.fillStyle = colour;
  context.fillText(text, left, y);
}
