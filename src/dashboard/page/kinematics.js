// The kinematics of the shown arm: frames of its joints, its tool, and singular values, for any posture.

import { vec } from './arm.js';
import { cross, sub } from './geometry.js';
import { controlledRows } from './goals.js';
import { jointFrames, jointsOf, mountOf, mounted, posture, relative } from './link_poses.js';
import { IDENTITY, rotate } from './rotation.js';
import { smallestSingularValue } from './singular_value.js';
import { post } from './transport.js';

/**
 * @typedef {import('./types.js').Controller} Controller
 * @typedef {import('./types.js').KinematicsAnswer} KinematicsAnswer
 * @typedef {import('./types.js').Robot} Robot
 * @typedef {import('./urdf.js').Placement} Placement
 */

export class Kinematics {
  /**
   * @param {Robot} robot
   * @param {KinematicsAnswer} answer of the service for the posture `rest`
   * @param {number[]} rest
   */
  constructor(robot, answer, rest) {
    this.robot = robot.name;
    this.joints = jointsOf(robot, answer, rest);
    this.toolMount = mountOf(this.joints, answer, rest);
    /** The tool and the other tips. */
    this.tipMounts = [this.toolMount, ...(answer.tips ?? []).slice(1).map(({ joint, pose: { position, orientation } }) => {
      const carrier = answer.links.findIndex((link) => link.joint === joint);
      const frame = this.frames(rest)[carrier] ?? { position: [0, 0, 0], orientation: IDENTITY };
      return { carrier, offset: relative(frame, { position: vec(position), orientation }) };
    })];
  }

  /** Asks the service for the kinematics of a robot. @type {(robot: Robot) => Promise<Kinematics>} */
  static async learn(robot) {
    const joint_position = posture(robot, 0.5);
    return new Kinematics(robot, await post('/v1/kinematics', { robot: robot.name, joint_position }), joint_position);
  }

  /** Returns the frames of the joints; each moves about or along its z. @type {(position: number[]) => Placement[]} */
  frames(position) {
    return jointFrames(this.joints, position);
  }

  /** @type {(frames: Placement[]) => Placement} */
  tool(frames) {
    return mounted(this.toolMount, frames);
  }

  /** Returns an arm at another posture; arms with several chains stay as they are. @type {(arm: import('./types.js').ArmView, position: number[]) => import('./types.js').ArmView} */
  armAt(arm, position) {
    if (arm.chains || arm.joints.length !== this.joints.length || position.length !== this.joints.length) return arm;
    const frames = this.frames(position);
    const joints = arm.joints.map((joint, i) => ({ ...joint, origin: [...frames[i].position], axis: [...rotate(frames[i].orientation, [0, 0, 1])] }));
    return { ...arm, joints, tool: this.tool(frames) };
  }

  /** Returns the joint that carries the tool and those before it. */
  get toolChain() {
    const chain = [];
    for (let at = this.toolMount.carrier; at >= 0; at = this.joints[at].parent) chain.unshift(at);
    return chain;
  }

  /** Returns the columns of the Jacobian of the tool: linear, then angular parts. @type {(frames: Placement[]) => number[][]} */
  jacobian(frames) {
    const tool = this.tool(frames).position;
    const columns = this.joints.map(() => [0, 0, 0, 0, 0, 0]);
    for (const i of this.toolChain) {
      const axis = rotate(frames[i].orientation, [0, 0, 1]);
      const turn = cross(axis, sub(tool, frames[i].position));
      columns[i] = this.joints[i].slides ? [...axis, 0, 0, 0] : [...turn, ...axis];
    }
    return columns;
  }

  /**
   * Returns the smallest singular value of the directions of the tool that the tasks control, highest priority first, as
   * far as they are independent.
   * @param {Controller} controller
   * @param {number[]} position
   */
  smallestSingularValue(controller, position) {
    const frames = this.frames(position);
    const columns = this.jacobian(frames);
    const length = controller.characteristic_length_m ?? 1;
    const rows = controlledRows(controller, columns.length).map((row) =>
      columns.map((column) => row.reduce((sum, part, i) => sum + (i < 3 ? part / length : part) * column[i], 0)));
    return smallestSingularValue(rows);
  }

  /** Returns the length of the arm along its joints, m. */
  get reach() {
    const chain = this.toolChain;
    const parts = [...chain.map((i) => this.joints[i].placement.position), this.toolMount.offset.position];
    return parts.reduce((sum, part) => sum + Math.hypot(...part), 0);
  }
}

