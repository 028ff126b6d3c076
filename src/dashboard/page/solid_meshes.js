// Meshes of the WebGL renderer that many bodies share, flat meshes of triangles, and ribbons along paths.

import { block, emptyForm, lathe } from './forms.js';
import { cross, norm, scale, sub, unit, add } from './geometry.js';

/**
 * @typedef {import('./types.js').Vec3} Vec3
 * @typedef {import('./forms.js').Form} Form
 * @typedef {import('./geometry.js').Camera} Camera
 * @typedef {import('./webgl.js').Mesh} Mesh
 */

/** Number of cells of a grid per side, and half the width of its lines as a part of its width. */
const CELLS = 8;
const LINE = 0.004;

/** Length of a dash and of a gap of a dashed ribbon, px. */
const DASH = 6;
const GAP = 4;

/** Rings of the sphere. */
const RINGS = 18;

/** @type {(form: Form) => Mesh} */
const meshOf = ({ places, normals }) => ({ places: new Float32Array(places), normals: new Float32Array(normals) });

/** @type {(fill: (form: Form) => void) => Mesh} */
function made(fill) {
  const form = emptyForm();
  fill(form);
  return meshOf(form);
}

/** A sphere with radius 1, a cylinder along z with radius 1 and length 1 without ends, and a cube with edges of 1. */
export const SPHERE = made((form) => lathe(form, [0, 0, 0], [0, 0, 1], Array.from({ length: RINGS + 1 }, (_, i) => {
  const angle = (Math.PI * i) / RINGS;
  return /** @type {[number, number]} */ ([Math.sin(angle), -Math.cos(angle)]);
})));
export const CYLINDER = made((form) => lathe(form, [0, 0, 0], [0, 0, 1], [[1, 0], [1, 1]]));
export const BOX = made((form) => block(form, [0, 0, 0], [1, 1, 1], 0.015));

/** @type {(form: Form, corners: Vec3[]) => void} a rectangle across z */
function rectangle(form, [a, b, c, d]) {
  for (const corner of [a, b, c, a, c, d]) {
    form.places.push(...corner);
    form.normals.push(0, 0, 1);
  }
}

const SQUARE = made((form) => rectangle(form, [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]));
const GRID = made((form) => {
  for (let i = 0; i <= CELLS; i += 1) {
    const [at, half] = [(2 * i) / CELLS - 1, i % CELLS === 0 ? 2 * LINE : LINE];
    rectangle(form, [[at - half, -1, 0], [at + half, -1, 0], [at + half, 1, 0], [at - half, 1, 0]]);
    rectangle(form, [[-1, at - half, 0], [1, at - half, 0], [1, at + half, 0], [-1, at + half, 0]]);
  }
});

/** Returns a square across z from −1 to 1. */
export const square = () => SQUARE;

/** Returns the lines of a square across z from −1 to 1. */
export const grid = () => GRID;

/** @type {WeakMap<Float32Array, Mesh>} */
const flat = new WeakMap();

/** Returns triangles with the normal of each. @type {(triangles: Float32Array) => Mesh} */
export function flatMesh(triangles) {
  const known = flat.get(triangles);
  if (known) return known;
  const normals = new Float32Array(triangles.length);
  const corner = (/** @type {number} */ i) => /** @type {Vec3} */ ([triangles[i], triangles[i + 1], triangles[i + 2]]);
  for (let i = 0; i < triangles.length; i += 9) {
    const normal = unit(cross(sub(corner(i + 3), corner(i)), sub(corner(i + 6), corner(i))));
    for (let k = 0; k < 9; k += 1) normals[i + k] = normal[k % 3];
  }
  const mesh = { places: triangles, normals };
  flat.set(triangles, mesh);
  return mesh;
}

/** Returns a ribbon along a path that faces the camera and looks `width` px wide. @type {(points: Vec3[], camera: Camera, width: number, isDashed: boolean) => Mesh} */
export function ribbon(points, camera, width, isDashed) {
  /** @type {number[]} */
  const places = [];
  /** @type {[Vec3, Vec3][]} */
  const sides = points.map((point, i) => {
    const direction = sub(points[i + 1] ?? point, points[i - 1] ?? point);
    const fromEye = sub(point, camera.eye);
    const across = norm(direction) > 1e-7 ? unit(cross(direction, fromEye)) : camera.right;
    const half = scale(across, (0.5 * width) / camera.project(point).scale);
    return [add(point, half), sub(point, half)];
  });
  const spots = isDashed ? points.map((point) => camera.project(point)) : [];
  let length = 0;
  for (let i = 0; i + 1 < sides.length; i += 1) {
    if (isDashed) length += Math.hypot(spots[i + 1].x - spots[i].x, spots[i + 1].y - spots[i].y);
    if (isDashed && length % (DASH + GAP) > DASH) continue;
    const [[a, b], [c, d]] = [sides[i], sides[i + 1]];
    places.push(...a, ...b, ...d, ...a, ...d, ...c);
  }
  return { places: new Float32Array(places), normals: new Float32Array(places.length), isTemporary: true };
}
