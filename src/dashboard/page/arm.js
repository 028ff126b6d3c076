// The bodies that an arm is drawn with, from the axes of its joints: any robot has those.

import { add, dot, mix, norm, scale, sub, unit } from './geometry.js';

/**
 * @typedef {import('./types.js').ArmView} ArmView
 * @typedef {import('./types.js').Vec3} Vec3
 *
 * @typedef {'link' | 'joint' | 'limit' | 'tool'} Material
 * @typedef {{kind: 'rod', a: Vec3, b: Vec3, ra: number, rb: number, material: Material}} Rod
 * @typedef {{kind: 'drum', a: Vec3, b: Vec3, r: number, material: Material}} Drum
 * @typedef {Rod | Drum} Body
 */

/** Long rods are drawn in pieces, so that what is nearer covers what is farther away. */
const PIECE = 0.09;

/**
 * @param {ArmView} arm
 * @param {boolean[]} atLimit per joint
 * @returns {Body[]}
 */
export function bodies(arm, atLimit) {
  const joints = arm.joints.map(({ origin, axis }) => ({ origin: vec(origin), axis: vec(axis) }));
  const tool = vec(arm.tool.position);
  const stops = [...joints.map(({ origin }) => origin), tool];
  const reach = stops.reduce((sum, stop, i) => sum + norm(sub(stop, i > 0 ? stops[i - 1] : [0, 0, 0])), 0);
  const thick = (/** @type {number} */ i) => reach * 0.036 * (1 - (0.55 * i) / joints.length);
  /** @type {Body[]} */
  const all = [{ kind: 'drum', a: [0, 0, -0.004], b: [0, 0, reach * 0.022], r: reach * 0.075, material: 'joint' }];
  rod(all, [0, 0, 0], joints[0].origin, thick(0) * 1.15, thick(0), 'link');
  joints.forEach(({ origin, axis }, i) => {
    const next = stops[i + 1];
    const r = thick(i);
    const elbow = add(origin, scale(axis, dot(sub(next, origin), axis)));
    const isLast = i + 1 === joints.length;
    const end = isLast ? thick(i) * 0.75 : thick(i + 1);
    rod(all, origin, elbow, r, r, 'link');
    rod(all, elbow, isLast ? mix(elbow, next, 0.72) : next, r, end, 'link');
    const half = scale(axis, r * 1.3);
    const material = atLimit[i] ? 'limit' : 'joint';
    all.push({ kind: 'drum', a: sub(origin, half), b: add(origin, half), r: r * 1.22, material });
    if (isLast) rod(all, mix(elbow, next, 0.72), next, end * 0.7, end * 0.22, 'tool');
  });
  return all;
}

/**
 * @param {Body[]} all where the rod's pieces are added
 * @param {Vec3} a
 * @param {Vec3} b
 * @param {number} ra
 * @param {number} rb
 * @param {Material} material
 */
function rod(all, a, b, ra, rb, material) {
  const length = norm(sub(b, a));
  if (length < 0.4 * Math.min(ra, rb)) return;
  const pieces = Math.max(1, Math.round(length / PIECE));
  for (let i = 0; i < pieces; i += 1) {
    const [from, to] = [i / pieces, (i + 1) / pieces];
    const radius = (/** @type {number} */ s) => ra + s * (rb - ra);
    all.push({ kind: 'rod', a: mix(a, b, from), b: mix(a, b, to), ra: radius(from), rb: radius(to), material });
  }
}

/**
 * Where the arm and what it touches are, and how large.
 * @param {ArmView} arm
 * @returns {{center: Vec3, size: number}}
 */
export function extent(arm) {
  const points = [[0, 0, 0], ...arm.joints.map(({ origin }) => origin), arm.tool.position].map(vec);
  const low = /** @type {Vec3} */ ([0, 1, 2].map((i) => Math.min(...points.map((p) => p[i]))));
  const high = /** @type {Vec3} */ ([0, 1, 2].map((i) => Math.max(...points.map((p) => p[i]))));
  return { center: mix(low, high, 0.5), size: Math.max(0.4, norm(sub(high, low))) };
}

/**
 * @param {number[]} list
 * @returns {Vec3}
 */
export function vec(list) {
  return [list[0], list[1], list[2]];
}

/**
 * Direction of an axis by its number.
 * @param {number} axis
 * @returns {Vec3}
 */
export function axisOf(axis) {
  return unit([Number(axis === 0), Number(axis === 1), Number(axis === 2)]);
}
