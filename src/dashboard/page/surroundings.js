// Floor, walls, planes and springs of the scene.

import { axisOf, vec } from './arm.js';
import { perpendiculars, add, dot, mix, scale, sub } from './geometry.js';
import { polygon } from './shading.js';

/**
 * @typedef {import('./types.js').Vec3} Vec3
 * @typedef {import('./geometry.js').Camera} Camera
 * @typedef {import('./scene.js').Contact} Contact
 * @typedef {import('./scene.js').World} World
 * @typedef {import('./theme.js').Palette} Palette
 */

/** Half the width of a drawn wall, m. */
const WALL_HALF_WIDTH = 0.32;

/** @type {(context: CanvasRenderingContext2D, camera: Camera, colours: Palette) => void} */
export function floor(context, camera, colours) {
  const reach = 1.25 * camera.size;
  context.lineWidth = 1;
  for (let i = -6; i <= 6; i += 1) {
    const at = (i * reach) / 6;
    const long = Math.sqrt(reach * reach - at * at);
    context.strokeStyle = colours.dark ? `rgba(150,170,190,${i === 0 ? 0.3 : 0.13})` : `rgba(70,90,110,${i === 0 ? 0.3 : 0.13})`;
    segment(context, camera, [at, -long, 0], [at, long, 0]);
    segment(context, camera, [-long, at, 0], [long, at, 0]);
  }
  axes(context, camera, colours, true);
}

/** Length of the axes of the base as a part of the length of the arm. */
export const AXIS = 0.18;

/** Draws the axes of the base, or their letters alone. @type {(context: CanvasRenderingContext2D, camera: Camera, colours: Palette, withLines: boolean) => void} */
export function axes(context, camera, colours, withLines) {
  context.font = '600 11px system-ui, sans-serif';
  context.textAlign = 'center';
  context.textBaseline = 'middle';
  for (let axis = 0; axis < 3; axis += 1) {
    const tip = scale(axisOf(axis), AXIS * camera.size);
    context.strokeStyle = colours.axes[axis];
    context.lineWidth = 2;
    if (withLines) segment(context, camera, [0, 0, 0], tip);
    // With WebGL the arm hides its own axis.
    if (!withLines && axis === 2) continue;
    const label = camera.project(scale(tip, 1.18));
    if (!withLines && isBehindBase(camera, tip, label)) continue;
    context.fillStyle = colours.axes[axis];
    context.fillText('xyz'[axis], label.x, label.y);
  }
}

/** Half the width of the base of an arm as a part of its length. */
const BASE = 0.08;

/** Returns whether the base hides the end of an axis. @type {(camera: Camera, tip: Vec3, label: {x: number}) => boolean} */
function isBehindBase(camera, tip, label) {
  const base = camera.project([0, 0, 0]);
  return dot(tip, camera.back) < 0 && Math.abs(label.x - base.x) < BASE * camera.size * base.scale;
}

/** @type {(context: CanvasRenderingContext2D, camera: Camera, contact: Contact, world: World, colours: Palette) => void} */
export function wall(context, camera, contact, world, colours) {
  const [u, v] = perpendiculars(contact.inwards);
  const center = wallCenter(contact, world);
  /** @type {(s: number, t: number) => Vec3} */
  const place = (s, t) => add(center, add(scale(u, s * WALL_HALF_WIDTH), scale(v, t * WALL_HALF_WIDTH)));
  const corners = [place(-1, -1), place(1, -1), place(1, 1), place(-1, 1)].map((corner) => camera.project(corner));
  const touched = contact.isVirtual ? contact.isTouched : Math.abs(dot(world.force, contact.inwards)) > 0.5;
  const rgb = contact.isVirtual ? (colours.dark ? '223,148,189' : '181,86,143') : colours.dark ? '120,170,205' : '70,120,160';
  context.fillStyle = `rgba(${rgb},${touched ? 0.3 : 0.18})`;
  polygon(context, corners);
  context.strokeStyle = `rgba(${rgb},0.32)`;
  context.lineWidth = 1;
  for (let i = -3; i <= 3; i += 1) {
    segment(context, camera, place(i / 4, -1), place(i / 4, 1));
    segment(context, camera, place(-1, i / 4), place(1, i / 4));
  }
  context.strokeStyle = touched ? (contact.isVirtual ? colours.ghost : colours.accent) : `rgba(${rgb},0.9)`;
  context.lineWidth = touched ? 2.5 : 1.5;
  context.beginPath();
  corners.forEach(({ x, y }, i) => (i === 0 ? context.moveTo(x, y) : context.lineTo(x, y)));
  context.closePath();
  context.stroke();
}

/** @type {(context: CanvasRenderingContext2D, camera: Camera, contact: Contact, world: World, colours: Palette) => void} */
export function spring(context, camera, contact, world, colours) {
  if (!world.arm) return;
  const axis = contact.inwards;
  const tool = vec(world.arm.tool.position);
  const restLength = 0.26;
  const anchor = add(tool, scale(axis, restLength + dot(sub(contact.at, tool), axis)));
  const [side] = perpendiculars(axis);
  const turns = 9;
  context.strokeStyle = colours.muted;
  context.lineWidth = 1.5;
  context.lineJoin = 'round';
  context.beginPath();
  for (let i = 0; i <= 2 * turns + 2; i += 1) {
    const isInner = i > 0 && i < 2 * turns + 2;
    const point = add(mix(tool, anchor, i / (2 * turns + 2)), scale(side, isInner ? (i % 2 ? 0.018 : -0.018) : 0));
    const spot = camera.project(point);
    if (i === 0) context.moveTo(spot.x, spot.y);
    else context.lineTo(spot.x, spot.y);
  }
  context.stroke();
  const [u, v] = perpendiculars(axis);
  const plate = [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([s, t]) =>
    camera.project(add(anchor, add(scale(u, 0.05 * s), scale(v, 0.05 * t)))));
  context.fillStyle = colours.dark ? 'rgba(120,170,205,0.35)' : 'rgba(70,120,160,0.3)';
  polygon(context, plate);
}

/** @type {(context: CanvasRenderingContext2D, camera: Camera, a: Vec3, b: Vec3) => void} */
function segment(context, camera, a, b) {
  const [from, to] = [camera.project(a), camera.project(b)];
  if (from.depth <= 0.05 || to.depth <= 0.05) return;
  context.beginPath();
  context.moveTo(from.x, from.y);
  context.lineTo(to.x, to.y);
  context.stroke();
}

/** Returns the centre of the drawn part of a wall: a plane has no centre, so the part next to the tool is drawn. @type {(contact: Contact, world: World) => Vec3} */
export function wallCenter({ at, inwards, isVirtual }, { arm }) {
  if (!isVirtual || !arm) return at;
  const tool = vec(arm.tool.position);
  return add(tool, scale(inwards, dot(sub(at, tool), inwards)));
}
