// A shape for any arm, made from the frames of its joints: drums about the axes, tubes between them.

import { drum, lathe, tube } from './forms.js';
import { add, norm, scale, sub, unit } from './geometry.js';
import { Builder, FINISHES, panda, tip, ur5e } from './models.js';
import { gen3, iiwa, sawyer, so101, xarm7 } from './models_at_zero.js';

/**
 * @typedef {import('./types.js').Vec3} Vec3
 * @typedef {import('./kinematics.js').Kinematics} Kinematics
 * @typedef {import('./models.js').ModelPart} ModelPart
 *
 * @typedef {object} Style
 * @property {string} body finish of the links
 * @property {string} joint finish of the drums
 * @property {string} accent finish of the rings
 * @property {string} base
 * @property {number} thickness radius of the first link as a part of the length of the arm
 * @property {number} taper part of it that the last link has lost
 */

/** @type {Style} */
const PLAIN = { body: 'white', joint: 'dark', accent: 'sky', base: 'dark', thickness: 0.043, taper: 0.5 };

/** Robots with a shape of their own, stated in the frames of their joints. @type {Record<string, (b: Builder) => void>} */
const MODELS = { panda, fr3: panda, ur5e };

/** Robots with a shape of their own, stated in the base frame at the position zero. @type {Record<string, (b: Builder) => void>} */
const MODELS_AT_ZERO = { gen3, iiwa14: iiwa, sawyer, sawyer_dh: sawyer, so101, xarm7 };

/** Joint positions at which an arm is like another one at its zero, rad. @type {Record<string, number[]>} */
const ZEROS = { sawyer_dh: [Math.PI, -Math.PI / 2, Math.PI, 0, Math.PI, 0, 0] };

/** Finish of the links and of the joints where an arm is drawn with rods and drums alone. @type {Record<string, [string, string]>} */
const TWO_FINISHES = {
  gen3: ['shell', 'dark'], iiwa14: ['aluminium', 'orange'], sawyer: ['red', 'dark'], sawyer_dh: ['red', 'dark'], so101: ['print', 'dark'],
  ur5e: ['silver', 'sky'], xarm7: ['white', 'grey'],
};

/** Returns the colours of a robot where it is drawn with rods and drums alone. @type {(robot: string) => Partial<Record<import('./arm.js').Material, import('./shading.js').Rgb>>} */
export function simpleColours(robot) {
  const own = TWO_FINISHES[robot];
  return own ? { link: FINISHES[own[0]].rgb, joint: FINISHES[own[1]].rgb } : {};
}

/** @type {WeakMap<Kinematics, ModelPart[]>} */
const known = new WeakMap();

/** Returns the shape of a robot. @type {(kinematics: Kinematics) => ModelPart[]} */
export function modelOf(kinematics) {
  const made = known.get(kinematics) ?? make(kinematics);
  known.set(kinematics, made);
  return made;
}

/** @type {(kinematics: Kinematics) => ModelPart[]} */
function make(kinematics) {
  const builder = new Builder();
  const atZero = MODELS_AT_ZERO[kinematics.robot];
  if (atZero) {
    atZero(builder);
    return builder.parts(kinematics.frames(ZEROS[kinematics.robot] ?? kinematics.joints.map(() => 0)));
  }
  const own = MODELS[kinematics.robot];
  if (own) own(builder);
  else anyArm(builder, kinematics, PLAIN);
  return builder.parts();
}

/** @type {(b: Builder, kinematics: Kinematics, style: Style) => void} */
function anyArm(b, kinematics, style) {
  const { joints, tipMounts } = kinematics;
  const size = kinematics.reach || 1;
  const depths = joints.map((_, i) => depthOf(joints, i));
  const deepest = Math.max(1, ...depths);
  const radius = (/** @type {number} */ i) => size * style.thickness * (1 - (style.taper * depths[i]) / deepest);
  const r0 = size * style.thickness;
  lathe(b.of(style.base), [0, 0, 0], [0, 0, 1], [[0, 0], [2 * r0, 0], [2.05 * r0, 0.1 * r0], [2 * r0, 0.3 * r0], [1.5 * r0, 0.5 * r0], [1.38 * r0, 0.7 * r0], [0, 0.7 * r0]]);
  joints.forEach(({ parent, placement, slides }, i) => {
    b.joint = parent;
    const r = radius(i);
    const before = parent < 0 ? 1.15 * r : radius(parent);
    link(b, placement.position, parent < 0 ? 1.15 * r : before, r, style, parent < 0);
    b.joint = i;
    const half = slides ? 1.6 * r : 1.25 * r;
    const isAtFloor = parent < 0 && placement.position[2] < half;
    drum(b.of(style.joint, true), [0, 0, isAtFloor ? 0 : -half], [0, 0, half], 1.24 * r, 0.28 * r);
    for (const side of isAtFloor ? [1] : [-1, 1]) drum(b.of(style.accent), [0, 0, side * half * 0.98], [0, 0, side * half * 1.05], 0.8 * r, 0.03 * r);
  });
  for (const { carrier, offset } of tipMounts) {
    b.joint = carrier;
    if (carrier >= 0) endOf(b, offset.position, radius(carrier), style);
  }
}

/** Adds the link from the last joint to a tip. @type {(b: Builder, end: Vec3, radius: number, style: Style) => void} */
function endOf(b, end, radius, style) {
  if (norm(end) <= 1e-6) {
    tip(b, end, 0.5 * radius);
    return;
  }
  const direction = unit(end);
  const neck = Math.max(0, norm(end) - 0.9 * radius);
  link(b, scale(direction, neck), radius, 0.72 * radius, style, false);
  drum(b.of('steel'), scale(direction, neck * 0.98), end, 0.62 * radius, 0.1 * radius, 0.5 * radius);
}

/** @type {(joints: Kinematics['joints'], i: number) => number} */
function depthOf(joints, i) {
  let count = 0;
  for (let at = joints[i].parent; at >= 0; at = joints[at].parent) count += 1;
  return count;
}

/** Adds the link from the axis of the current joint to a point: along the axis first, then across, with a round corner. @type {(b: Builder, to: Vec3, from: number, end: number, style: Style, isBase: boolean) => void} */
function link(b, to, from, end, style, isBase) {
  if (norm(to) < 0.3 * from) return;
  const corner = /** @type {Vec3} */ ([0, 0, to[2]]);
  const across = sub(to, corner);
  const [up, out] = [Math.abs(to[2]), norm(across)];
  const body = b.of(isBase ? style.base : style.body);
  if (up < 0.5 * from || out < 0.5 * from) {
    tube(body, [[0, 0, 0], to], [from, end]);
    collar(b, to, from, end, style, isBase);
    return;
  }
  const bend = Math.min(0.5 * up, 0.5 * out, 2 * from);
  const [before, after] = [scale(unit(corner), up - bend), add(corner, scale(unit(across), bend))];
  const middle = (from + end) / 2;
  tube(body, [[0, 0, 0], before, add(corner, scale(sub(add(before, after), scale(corner, 2)), 0.22)), after, to], [from, middle, middle, middle, end]);
}

/** Adds a ring of the accent in the middle of a long link. @type {(b: Builder, to: Vec3, from: number, end: number, style: Style, isBase: boolean) => void} */
function collar(b, to, from, end, style, isBase) {
  if (isBase || norm(to) < 5 * from) return;
  const [low, high] = [scale(to, 0.47), scale(to, 0.53)];
  drum(b.of(style.joint), low, high, 1.04 * ((from + end) / 2), 0.1 * from);
}
