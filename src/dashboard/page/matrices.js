// Matrices of the WebGL renderer: 4 × 4, column by column, as WebGL reads them.

import { cross, dot, perpendiculars, scale, sub, unit } from './geometry.js';
import { rotate } from './rotation.js';

/**
 * @typedef {import('./types.js').Vec3} Vec3
 * @typedef {import('./geometry.js').Camera} Camera
 * @typedef {import('./urdf.js').Placement} Placement
 * @typedef {Float32Array} Matrix 16 numbers
 */

/** Distances of the nearest and the farthest drawn points, m. */
const NEAR = 0.02;
const FAR = 60;

/** Unit vectors of the axes. @type {Vec3[]} */
const UNITS = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];

/** Returns a · b. @type {(a: Matrix, b: Matrix) => Matrix} */
export function product(a, b) {
  const result = new Float32Array(16);
  for (let column = 0; column < 4; column += 1) {
    for (let row = 0; row < 4; row += 1) {
      let sum = 0;
      for (let k = 0; k < 4; k += 1) sum += a[4 * k + row] * b[4 * column + k];
      result[4 * column + row] = sum;
    }
  }
  return result;
}

/** Returns the transform from a frame, with its axes scaled, to the base. @type {(frame: Placement, factors?: Vec3) => Matrix} */
export function transform({ position, orientation }, factors = /** @type {Vec3} */ ([1, 1, 1])) {
  const axes = UNITS.map((axis, i) => scale(rotate(orientation, axis), factors[i]));
  return new Float32Array([...axes[0], 0, ...axes[1], 0, ...axes[2], 0, ...position, 1]);
}

/** Returns the transform whose z axis goes from `a` to `b`, scaled by a radius and by the distance. @type {(a: Vec3, b: Vec3, radius: number) => Matrix} */
export function along(a, b, radius) {
  const z = sub(b, a);
  const axis = unit(z);
  const [x, y] = perpendiculars(axis);
  return new Float32Array([...scale(x, radius), 0, ...scale(y, radius), 0, ...z, 0, ...a, 1]);
}

/** Returns the projection of a camera; the middle of its free part shows its target. @type {(camera: Camera) => Matrix} */
export function projection(camera) {
  const { width, height, focal, middle, right, up, back, eye } = camera;
  const [fx, fy] = [(2 * focal) / width, (2 * focal) / height];
  const [ox, oy] = [(2 * middle.x) / width - 1, 1 - (2 * middle.y) / height];
  const view = new Float32Array([
    right[0], up[0], back[0], 0, right[1], up[1], back[1], 0, right[2], up[2], back[2], 0,
    -dot(right, eye), -dot(up, eye), -dot(back, eye), 1,
  ]);
  const lens = new Float32Array([
    fx, 0, 0, 0, 0, fy, 0, 0, -ox, -oy, (FAR + NEAR) / (NEAR - FAR), -1, 0, 0, (2 * FAR * NEAR) / (NEAR - FAR), 0,
  ]);
  return product(lens, view);
}

/** Returns the parallel projection of a ball as the light sees it. @type {(light: Vec3, center: Vec3, radius: number) => Matrix} */
export function lightProjection(light, center, radius) {
  const right = unit(cross([0, 0, 1], light));
  const up = cross(light, right);
  const s = 1 / radius;
  return new Float32Array([
    s * right[0], s * up[0], -0.5 * s * light[0], 0, s * right[1], s * up[1], -0.5 * s * light[1], 0,
    s * right[2], s * up[2], -0.5 * s * light[2], 0,
    -s * dot(right, center), -s * dot(up, center), 0.5 * s * dot(light, center), 1,
  ]);
}
