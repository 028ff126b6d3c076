// Where the links of a robot are in any posture. The service answers for two postures; the page computes the others.

import { vec } from './arm.js';
import { norm, sub } from './geometry.js';
import { IDENTITY, fromVector, inverse, multiply, rotate } from './rotation.js';
import { post } from './transport.js';
import { compose } from './urdf.js';

/**
 * @typedef {import('./types.js').KinematicsAnswer} KinematicsAnswer
 * @typedef {import('./types.js').Pose} Pose
 * @typedef {import('./types.js').Robot} Robot
 * @typedef {import('./urdf.js').Placement} Placement
 *
 * @typedef {object} Joint
 * @property {number} parent index of the joint before it; −1: the base
 * @property {Placement} placement its frame after the motion to `rest`, in the frame of its parent
 * @property {number} rest position, rad or m
 * @property {boolean} slides
 *
 * @typedef {{carrier: number, offset: Placement}} Mount a link is fixed to the frame of the joint `carrier`; −1: to the base
 */

/** Largest difference between a computed and an answered place, m. */
const TOLERANCE = 1e-5;

/** Largest entry of a column of the Jacobian of a joint that does not move a link. */
const NO_MOTION = 1e-9;

/** @type {Placement} */
const BASE = { position: [0, 0, 0], orientation: IDENTITY };

export class LinkPoses {
  /** @param {Joint[]} joints @param {Map<string, Mount>} mounts by link @param {string[]} unknown links whose place cannot be computed */
  constructor(joints, mounts, unknown) {
    this.joints = joints;
    this.mounts = mounts;
    this.unknown = unknown;
  }

  /** Returns the frames of the known links. @type {(position: number[]) => Map<string, Placement>} */
  at(position) {
    const frames = jointFrames(this.joints, position);
    return new Map([...this.mounts].map(([link, mount]) => [link, mounted(mount, frames)]));
  }

  /** Asks the service for the places of links. @type {(robot: Robot, links: string[]) => Promise<LinkPoses>} */
  static async learn(robot, links) {
    const [rest, other] = [0.5, 0.62].map((part) => posture(robot, part));
    const ask = (/** @type {number[]} */ joint_position, /** @type {string} */ link) =>
      /** @type {Promise<KinematicsAnswer>} */ (post('/v1/kinematics', { robot: robot.name, joint_position, link }));
    /** @type {Joint[]} */
    let joints = [];
    const mounts = new Map();
    const unknown = [];
    for (const link of links) {
      const [atRest, atOther] = [await ask(rest, link), await ask(other, link)];
      if (joints.length === 0) joints = jointsOf(robot, atRest, rest);
      const mount = mountOf(joints, atRest, rest);
      const computed = mounted(mount, jointFrames(joints, other));
      if (differ(computed, placementOf(atOther.pose))) unknown.push(link);
      else mounts.set(link, mount);
    }
    return new LinkPoses(joints, mounts, unknown);
  }
}

/** Returns a posture inside the ranges of the joints. @type {(robot: Robot, part: number) => number[]} */
export function posture({ joints }, part) {
  return joints.map(({ position_limit: range }) => {
    const [low, high] = range ?? [-1, 1];
    return low + part * (high - low);
  });
}

/** @type {(pose: Pose) => Placement} */
const placementOf = ({ position, orientation }) => ({ position: vec(position), orientation });

/** @type {(a: Placement, b: Placement) => Placement} the frame b, in the frame a */
export function relative(a, b) {
  const back = inverse(a.orientation);
  return { position: rotate(back, sub(b.position, a.position)), orientation: multiply(back, b.orientation) };
}

/** @type {(robot: Robot, answer: KinematicsAnswer, rest: number[]) => Joint[]} */
export function jointsOf(robot, { links }, rest) {
  const names = links.map(({ joint }) => joint);
  return links.map(({ parent, pose }, i) => {
    const at = names.indexOf(parent ?? '');
    const before = at < 0 ? BASE : placementOf(links[at].pose);
    return { parent: at, placement: relative(before, placementOf(pose)), rest: rest[i], slides: robot.joints[i]?.kind === 'prismatic' };
  });
}

/** Returns the frames of the joints after their motion. Each moves along or about its z. @type {(joints: Joint[], position: number[]) => Placement[]} */
export function jointFrames(joints, position) {
  /** @type {Placement[]} */
  const frames = [];
  joints.forEach(({ parent, placement, rest, slides }, i) => {
    const q = (position[i] ?? rest) - rest;
    /** @type {Placement} */
    const motion = slides ? { position: [0, 0, q], orientation: IDENTITY } : { position: [0, 0, 0], orientation: fromVector([0, 0, q]) };
    frames.push(compose(compose(frames[parent] ?? BASE, placement), motion));
  });
  return frames;
}

/** Returns which joint carries a link: of those that move it, the one after most others. @type {(joints: Joint[], answer: KinematicsAnswer, rest: number[]) => Mount} */
export function mountOf(joints, { jacobian, pose }, rest) {
  const moves = (/** @type {number} */ joint) => jacobian.some((row) => Math.abs(row[joint]) > NO_MOTION);
  const depth = (/** @type {number} */ joint) => {
    let count = 0;
    for (let at = joint; at >= 0; at = joints[at].parent) count += 1;
    return count;
  };
  const movers = joints.map((_, joint) => joint).filter(moves);
  const carrier = movers.reduce((best, joint) => (best < 0 || depth(joint) > depth(best) ? joint : best), -1);
  const frame = carrier < 0 ? BASE : jointFrames(joints, rest)[carrier];
  return { carrier, offset: relative(frame, placementOf(pose)) };
}

/** @type {(mount: Mount, frames: Placement[]) => Placement} */
export const mounted = ({ carrier, offset }, frames) => compose(frames[carrier] ?? BASE, offset);

/** Compares the places of the origin and of points on two axes. @type {(a: Placement, b: Placement) => boolean} */
function differ(a, b) {
  const points = /** @type {import('./types.js').Vec3[]} */ ([[0, 0, 0], [1, 0, 0], [0, 1, 0]]);
  const at = (/** @type {Placement} */ frame, /** @type {import('./types.js').Vec3} */ position) => compose(frame, { position, orientation: IDENTITY }).position;
  return points.some((point) => norm(sub(at(a, point), at(b, point))) > TOLERANCE);
}
