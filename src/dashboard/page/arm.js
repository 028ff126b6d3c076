// Builds the bodies that draw an arm. It only needs the joint axes, so any robot can be drawn.

import { add, dot, mix, norm, scale, sub, unit } from './geometry.js';

/**
 * @typedef {import('./types.js').ArmView} ArmView
 * @typedef {import('./types.js').Vec3} Vec3
 *
 * @typedef {'link' | 'joint' | 'limit' | 'tool'} Material
 * @typedef {{kind: 'rod', a: Vec3, b: Vec3, ra: number, rb: number, material: Material}} Rod
 * @typedef {{kind: 'cylinder', a: Vec3, b: Vec3, r: number, material: Material}} Cylinder
 * @typedef {Rod | Cylinder} Body
 */

/** Approximate length of the pieces in which a rod is drawn, m. Short pieces can be sorted by depth. */
const PIECE_LENGTH = 0.09;

/**
 * Returns the bodies of each chain of an arm.
 * @param {ArmView} arm
 * @param {boolean[]} atLimit per joint
 * @returns {Body[]}
 */
export function bodies(arm, atLimit) {
  const chains = arm.chains ?? [{ joints: arm.joints.map((_, i) => i), tip: arm.tool.position }];
  return chains.filter(({ joints }) => joints.length > 0).flatMap(({ joints, tip }) => chainBodies(joints.map((i) => arm.joints[i]), vec(tip), joints.map((i) => atLimit[i])));
}

/**
 * Returns rods for the links, cylinders for the joints, and a tapered rod for the tool.
 * @param {ArmView['joints']} views
 * @param {Vec3} tool
 * @param {boolean[]} atLimit per joint
 * @returns {Body[]}
 */
function chainBodies(views, tool, atLimit) {
  const joints = views.map(({ origin, axis }) => ({ origin: vec(origin), axis: vec(axis) }));
  const points = [...joints.map(({ origin }) => origin), tool];
  const length = points.reduce((sum, point, i) => sum + norm(sub(point, i > 0 ? points[i - 1] : [0, 0, 0])), 0);
  const radius = (/** @type {number} */ i) => length * 0.036 * (1 - (0.55 * i) / joints.length);
  /** @type {Body[]} */
  const all = [
    { kind: 'cylinder', a: [0, 0, -0.004], b: [0, 0, length * 0.022], r: length * 0.075, material: 'joint' },
  ];
  addRod(all, [0, 0, 0], joints[0].origin, radius(0) * 1.15, radius(0), 'link');
  joints.forEach(({ origin, axis }, i) => {
    const next = points[i + 1];
    const r = radius(i);
    const elbow = add(origin, scale(axis, dot(sub(next, origin), axis)));
    const isLast = i + 1 === joints.length;
    const end = isLast ? radius(i) * 0.75 : radius(i + 1);
    addRod(all, origin, elbow, r, r, 'link');
    addRod(all, elbow, isLast ? mix(elbow, next, 0.72) : next, r, end, 'link');
    const half = scale(axis, r * 1.3);
    const material = atLimit[i] ? 'limit' : 'joint';
    all.push({ kind: 'cylinder', a: sub(origin, half), b: add(origin, half), r: r * 1.22, material });
    if (isLast) addRod(all, mix(elbow, next, 0.72), next, end * 0.7, end * 0.22, 'tool');
  });
  return all;
}

/**
 * Appends a rod, in pieces, to `all`.
 * @param {Body[]} all
 * @param {Vec3} a
 * @param {Vec3} b
 * @param {number} ra
 * @param {number} rb
 * @param {Material} material
 */
function addRod(all, a, b, ra, rb, material) {
  const length = norm(sub(b, a));
  if (length < 0.4 * Math.min(ra, rb)) return;
  const pieces = Math.max(1, Math.round(length / PIECE_LENGTH));
  for (let i = 0; i < pieces; i += 1) {
    const [from, to] = [i / pieces, (i + 1) / pieces];
    const radius = (/** @type {number} */ s) => ra + s * (rb - ra);
    all.push({ kind: 'rod', a: mix(a, b, from), b: mix(a, b, to), ra: radius(from), rb: radius(to), material });
  }
}

/**
 * Converts an array to a vector.
 * @param {number[]} list
 * @returns {Vec3}
 */
export function vec(list) {
  return [list[0], list[1], list[2]];
}

/**
 * Returns the unit vector of axis 0 (x), 1 (y) or 2 (z).
 * @param {number} axis
 * @returns {Vec3}
 */
export function axisOf(axis) {
  return unit([Number(axis === 0), Number(axis === 1), Number(axis === 2)]);
}
