// Draws the overlay of the scene: translucent shapes of the robot, obstacles, and lines between the nearest pairs.

import { dot, add, perpendiculars, scale, sub } from './geometry.js';
import { distance } from './number.js';
import { rotate } from './rotation.js';
import { brightness, drawBodies, lightOf, polygon, shade } from './shading.js';
import { middleOf } from './solids.js';

/**
 * @typedef {import('./types.js').Vec3} Vec3
 * @typedef {import('./geometry.js').Camera} Camera
 * @typedef {import('./room.js').Pair} Pair
 * @typedef {import('./shading.js').Rgb} Rgb
 * @typedef {import('./solids.js').Solid} Solid
 * @typedef {import('./solids.js').Box} Box
 * @typedef {import('./solids.js').Capsule} Capsule
 * @typedef {import('./solids.js').HalfSpace} HalfSpace
 * @typedef {import('./theme.js').Palette} Palette
 */

/** Half the width of the drawn part of a half-space, m, and the number of its cells per side. */
const PLANE_HALF_WIDTH = 0.7;
const PLANE_CELLS = 8;

/** Width and style of the line between a pair. */
const LINES = { clear: { width: 1.2, dash: [3, 3] }, near: { width: 2.2, dash: [] }, below: { width: 4, dash: [] } };

/** Height of a label, px. */
const LABEL_HEIGHT = 14;

/** The six faces of a box: outward direction as axis and sign. */
const FACES = [0, 1, 2].flatMap((axis) => [{ axis, sign: 1 }, { axis, sign: -1 }]);

/**
 * Draws capsules, spheres and boxes without transparency, far ones first.
 * @param {CanvasRenderingContext2D} context
 * @param {Camera} camera
 * @param {Solid[]} solids
 * @param {Rgb} rgb
 */
export function drawSolids(context, camera, solids, rgb) {
  const sorted = solids.map((solid) => ({ solid, depth: depthOf(camera, solid) })).sort((one, other) => other.depth - one.depth);
  for (const { solid } of sorted) {
    if (solid.kind === 'capsule') drawCapsule(context, camera, solid, rgb);
    if (solid.kind === 'box') drawBox(context, camera, solid, rgb);
  }
}

/** Returns the distance of the middle of a shape in the direction of view, m. @type {(camera: Camera, solid: Solid) => number} */
export function depthOf(camera, solid) {
  const middle = middleOf(solid);
  return middle ? -dot(sub(middle, camera.eye), camera.back) : Infinity;
}

/** @type {(context: CanvasRenderingContext2D, camera: Camera, capsule: Capsule, rgb: Rgb) => void} */
function drawCapsule(context, camera, { a, b, radius }, rgb) {
  const [from, to] = [camera.project(a), camera.project(b)];
  const [near, far] = from.depth < to.depth ? [from, to] : [to, from];
  // Seen along its axis, a capsule looks like the sphere at its near end.
  const isRound = Math.hypot(to.x - from.x, to.y - from.y) < 0.5 + radius * (near.scale - far.scale);
  if (isRound) drawBall(context, near, radius * near.scale, rgb);
  else drawBodies(context, camera, [{ kind: 'rod', a, b, ra: radius, rb: radius, material: 'link' }], () => rgb);
}

/** @type {(context: CanvasRenderingContext2D, center: {x: number, y: number}, radius: number, rgb: Rgb) => void} */
function drawBall(context, { x, y }, radius, rgb) {
  const fill = context.createRadialGradient(x - 0.35 * radius, y - 0.45 * radius, 0.1 * radius, x, y, radius);
  fill.addColorStop(0, shade(rgb, 1.15));
  fill.addColorStop(0.6, shade(rgb, 0.85));
  fill.addColorStop(1, shade(rgb, 0.5));
  context.fillStyle = fill;
  context.beginPath();
  context.arc(x, y, radius, 0, 2 * Math.PI);
  context.fill();
}

/** @type {(context: CanvasRenderingContext2D, camera: Camera, box: Box, rgb: Rgb) => void} */
function drawBox(context, camera, { center, size, orientation }, rgb) {
  const light = lightOf(camera);
  const axes = [0, 1, 2].map((axis) => rotate(orientation, /** @type {Vec3} */ ([0, 1, 2].map((k) => Number(k === axis)))));
  for (const { axis, sign } of FACES) {
    const normal = scale(axes[axis], sign);
    const middle = add(center, scale(normal, size[axis] / 2));
    if (dot(sub(camera.eye, middle), normal) <= 0) continue;
    const [i, j] = [(axis + 1) % 3, (axis + 2) % 3];
    const [u, v] = [scale(axes[i], size[i] / 2), scale(axes[j], size[j] / 2)];
    const corners = [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([s, t]) => camera.project(add(middle, add(scale(u, s), scale(v, t)))));
    context.fillStyle = shade(rgb, brightness(normal, light));
    polygon(context, corners);
    context.strokeStyle = shade(rgb, 0.55);
    context.lineWidth = 1;
    context.stroke();
  }
}

/** Returns whether the free side of a half-space faces the camera. @type {(camera: Camera, plane: HalfSpace) => boolean} */
export const facesCamera = (camera, { normal, offset }) => dot(camera.eye, normal) > offset;

/** Draws the part of a half-space's surface that is next to the middle of the scene. @type {(context: CanvasRenderingContext2D, camera: Camera, plane: HalfSpace, colours: Palette) => void} */
export function drawHalfSpace(context, camera, { normal, offset }, colours) {
  const center = add(camera.target, scale(normal, offset - dot(camera.target, normal)));
  const [u, v] = perpendiculars(normal).map((axis) => scale(axis, PLANE_HALF_WIDTH));
  const place = (/** @type {number} */ s, /** @type {number} */ t) => camera.project(add(center, add(scale(u, s), scale(v, t))));
  const rgb = colours.room.obstacle.join(',');
  context.fillStyle = `rgba(${rgb},0.16)`;
  polygon(context, [place(-1, -1), place(1, -1), place(1, 1), place(-1, 1)]);
  context.strokeStyle = `rgba(${rgb},0.35)`;
  context.lineWidth = 1;
  for (let i = 0; i <= PLANE_CELLS; i += 1) {
    const at = (2 * i) / PLANE_CELLS - 1;
    line(context, place(at, -1), place(at, 1));
    line(context, place(-1, at), place(1, at));
  }
}

/** Draws the lines between pairs, nearest last, and their distances where no other label is. @type {(context: CanvasRenderingContext2D, camera: Camera, pairs: Pair[], colours: Palette) => void} */
export function drawPairs(context, camera, pairs, colours) {
  for (const { points, level } of [...pairs].reverse()) {
    const [a, b] = points.map((point) => camera.project(point));
    const { width, dash } = LINES[level];
    context.lineCap = 'round';
    for (const [extra, colour] of /** @type {[number, string][]} */ ([[2.4, colours.scene], [0, colours.room[level]]])) {
      context.strokeStyle = colour;
      context.lineWidth = width + extra;
      context.setLineDash(extra > 0 ? [] : dash);
      line(context, a, b);
    }
    context.setLineDash([]);
    for (const spot of [a, b]) endPoint(context, spot, level === 'clear' ? 2 : 3.2, colours.room[level]);
  }
  labels(context, camera, pairs, colours);
}

/** @type {(context: CanvasRenderingContext2D, camera: Camera, pairs: Pair[], colours: Palette) => void} */
function labels(context, camera, pairs, colours) {
  context.textAlign = 'left';
  context.textBaseline = 'middle';
  context.lineJoin = 'round';
  /** @type {{left: number, right: number, y: number}[]} */
  const taken = [];
  for (const { points, distance: length, level } of pairs) {
    const [a, b] = points.map((point) => camera.project(point));
    const [x, y] = [Math.max(a.x, b.x) + 7, (a.y + b.y) / 2];
    context.font = `${level === 'clear' ? 500 : 700} 12px system-ui, sans-serif`;
    const text = millimetres(length);
    const box = { left: x, right: x + context.measureText(text).width, y };
    if (taken.some((other) => other.left < box.right && box.left < other.right && Math.abs(other.y - y) < LABEL_HEIGHT)) continue;
    taken.push(box);
    context.strokeStyle = colours.scene;
    context.lineWidth = 4;
    context.strokeText(text, x, y);
    context.fillStyle = colours.room[level];
    context.fillText(text, x, y);
  }
}

/** @type {(meters: number) => string} whole millimetres, or one digit more below 10 mm */
export function millimetres(meters) {
  const size = Math.abs(meters);
  return distance(Number(meters.toFixed(size < 0.01 ? 4 : 3)));
}

/** @type {(context: CanvasRenderingContext2D, a: {x: number, y: number}, b: {x: number, y: number}) => void} */
function line(context, a, b) {
  context.beginPath();
  context.moveTo(a.x, a.y);
  context.lineTo(b.x, b.y);
  context.stroke();
}

/** @type {(context: CanvasRenderingContext2D, spot: {x: number, y: number}, radius: number, colour: string) => void} */
function endPoint(context, { x, y }, radius, colour) {
  context.fillStyle = colour;
  context.beginPath();
  context.arc(x, y, radius, 0, 2 * Math.PI);
  context.fill();
}

/** @type {(pair: Pair) => string} */
export function nearestText({ a, b, distance: length, level }) {
  return `${a} – ${b}: ${millimetres(length)}${level === 'below' ? ', too near' : ''}`;
}
