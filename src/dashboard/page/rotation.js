// Rotations as unit quaternions w, x, y, z.

import { add, cross, dot, norm, scale } from './geometry.js';

/**
 * @typedef {import('./types.js').Vec3} Vec3
 * @typedef {import('./types.js').Quaternion} Quaternion
 */

/** @type {Quaternion} */
export const IDENTITY = { w: 1, x: 0, y: 0, z: 0 };

/** @type {(q: Quaternion) => Quaternion} */
export const inverse = ({ w, x, y, z }) => ({ w, x: -x, y: -y, z: -z });

/** @type {(a: Quaternion, b: Quaternion) => Quaternion} first b, then a */
export function multiply(a, b) {
  const [u, v] = [part(a), part(b)];
  const [x, y, z] = add(add(scale(v, a.w), scale(u, b.w)), cross(u, v));
  return { w: a.w * b.w - dot(u, v), x, y, z };
}

/** @type {(q: Quaternion, v: Vec3) => Vec3} */
export function rotate(q, v) {
  const u = part(q);
  const twice = scale(cross(u, v), 2);
  return add(add(v, scale(twice, q.w)), cross(u, twice));
}

/** @type {(q: Quaternion) => Vec3} the rotation vector, rad */
export function rotationVector(q) {
  const sign = q.w < 0 ? -1 : 1;
  const v = scale(part(q), sign);
  const length = norm(v);
  return length < 1e-12 ? scale(v, 2) : scale(v, (2 * Math.atan2(length, sign * q.w)) / length);
}

/** @type {(vector: Vec3) => Quaternion} the rotation with this rotation vector, rad */
export function fromVector(vector) {
  const half = norm(vector) / 2;
  const [x, y, z] = scale(vector, half < 1e-9 ? 0.5 : Math.sin(half) / (2 * half));
  return { w: Math.cos(half), x, y, z };
}

/** @type {(q: Quaternion) => Vec3} */
function part({ x, y, z }) {
  return [x, y, z];
}
