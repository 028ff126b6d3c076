// Transforms of mesh files as 4 × 4 matrices, row by row.

import { fromVector, rotate } from './rotation.js';
import { scale, unit } from './geometry.js';

/**
 * @typedef {import('./types.js').Vec3} Vec3
 * @typedef {import('./types.js').Quaternion} Quaternion
 * @typedef {number[]} Matrix 16 numbers
 */

/** @type {Matrix} */
export const IDENTITY = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];

/** @type {(a: Matrix, b: Matrix) => Matrix} first b, then a */
export function multiply(a, b) {
  return IDENTITY.map((_, at) => {
    const [row, column] = [at - (at % 4), at % 4];
    return a[row] * b[column] + a[row + 1] * b[4 + column] + a[row + 2] * b[8 + column] + a[row + 3] * b[12 + column];
  });
}

/** @type {(a: Matrix) => Matrix} */
export const transposed = (a) => a.map((_, at) => a[4 * (at % 4) + Math.floor(at / 4)]);

/** @type {(shift: Vec3) => Matrix} */
export const translation = ([x, y, z]) => [1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, z, 0, 0, 0, 1];

/** @type {(factors: Vec3) => Matrix} */
export const scaling = ([x, y, z]) => [x, 0, 0, 0, 0, y, 0, 0, 0, 0, z, 0, 0, 0, 0, 1];

/** @type {(q: Quaternion) => Matrix} */
export function rotation(q) {
  const [x, y, z] = [rotate(q, [1, 0, 0]), rotate(q, [0, 1, 0]), rotate(q, [0, 0, 1])];
  return [x[0], y[0], z[0], 0, x[1], y[1], z[1], 0, x[2], y[2], z[2], 0, 0, 0, 0, 1];
}

/** @type {(axis: Vec3, degrees: number) => Matrix} */
export const turn = (axis, degrees) => rotation(fromVector(scale(unit(axis), (degrees * Math.PI) / 180)));

/** @type {(a: Matrix, point: number[]) => Vec3} */
export function apply(a, [x, y, z]) {
  const row = (/** @type {number} */ i) => a[i] * x + a[i + 1] * y + a[i + 2] * z + a[i + 3];
  return [row(0), row(4), row(8)];
}
