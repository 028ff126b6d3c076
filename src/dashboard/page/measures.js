// Quantities that the page computes from samples: forces along the axes of the tasks, and pose errors.

import { vec } from './arm.js';
import { along, areDependent, forceRows, poseError, positionRows, residualParts, targetPose } from './goals.js';
import { perRow, valueAt } from './profile.js';

/**
 * @typedef {import('./types.js').Controller} Controller
 * @typedef {import('./types.js').ControllerTask} Task
 * @typedef {import('./types.js').LiveSample} LiveSample
 * @typedef {import('./types.js').Pose} Pose
 * @typedef {import('./types.js').Quaternion} Quaternion
 * @typedef {import('./goals.js').ForceRow} ForceRow
 * @typedef {import('./goals.js').PoseError} PoseError
 *
 * @typedef {object} Measured
 * @property {number[]} force per shown direction, N
 * @property {(number | null)[]} target desired force, N
 * @property {PoseError[]} errors per task, highest priority first
 */

/** Times above this are those of Unix, s. */
const UNIX_TIME = 1e9;

const NO_ERROR = { linear: NaN, angular: NaN };

/** @type {(sample: {position: number[], orientation: number[]}) => Pose} */
export function toolPose({ position, orientation: [w, x, y, z] }) {
  return { position: vec(position), orientation: w || x || y || z ? { w, x, y, z } : { w: 1, x: 0, y: 0, z: 0 } };
}

/** Computes the quantities of one run. Its samples must come in order. */
export class Measures {
  /**
   * @param {Controller} controller
   * @param {Pose | null} start pose of the tool from which targets are measured; null: that of the first sample
   * @param {import('./kinematics.js').Kinematics | null} kinematics
   */
  constructor(controller, start, kinematics = null) {
    this.controller = controller;
    this.kinematics = kinematics;
    /** Whether the rows of all tasks together are singular or regular in every posture, so that only those of the tool count. */
    this.isDependent = areDependent(controller, kinematics?.joints.length ?? 0);
    this.start = start;
    /** Whether the pose from which the targets are measured is known. */
    this.knowsStart = true;
    /** @type {ForceRow[]} */
    this.rows = forceRows(controller);
    /** Targets that the page sent. @type {{task: string, time: number, pose: Pose}[]} */
    this.streamed = [];
    /** Whether each task follows a target that another client streams, which is not known. @type {boolean[]} */
    this.isStreamed = [];
    /** Integrated residual of each velocity task, m and rad. @type {(number[] | undefined)[]} */
    this.drift = [];
    this.time = NaN;
  }

  /** Takes over what an answer to another client says about its targets. @type {(answer: Pick<import('./types.js').StepAnswer, 'tasks'>) => void} */
  follow({ tasks }) {
    this.knowsStart = false;
    this.isStreamed = tasks.map(({ target_state: state }) => state !== undefined && state !== null);
  }

  /** Labels of the shown forces. */
  get forceLabels() {
    return this.rows.length > 0 ? this.rows.map(({ label }) => label) : ['x', 'y', 'z'];
  }

  /** @type {(sample: LiveSample) => Measured} */
  of(sample) {
    this.start ??= toolPose(sample);
    const force = vec(sample.force);
    const time = sample.time_s;
    const elapsed = Number.isNaN(this.time) ? 0 : Math.max(0, time - this.time);
    this.time = time;
    const own = this.rows.length > 0;
    return {
      force: own ? this.rows.map(({ direction }) => along(force, direction)) : force,
      target: own ? this.rows.map(({ direction, target }) => baseTarget(sample, direction) ?? target(time)) : sample.target_force,
      errors: this.controller.tasks.map((task, k) => this.error(task, k, sample, elapsed)),
    };
  }

  /** Returns the smallest singular value of the tasks; of the tool's directions if the rows of all tasks are dependent. @type {(sample: LiveSample) => number} */
  singularValue(sample) {
    const { kinematics, controller } = this;
    if (!kinematics || !this.isDependent) return sample.smallest_singular_value;
    const sigma = kinematics.smallestSingularValue(controller, sample.joint_position);
    return Number.isFinite(sigma) ? sigma : sample.smallest_singular_value;
  }

  /** @type {(task: Task, k: number, sample: LiveSample, elapsed: number) => PoseError} */
  error(task, k, sample, elapsed) {
    // The pose of the tool says nothing about these.
    if (task.law?.kind !== 'velocity' && (task.link || task.relative_to || this.isStreamed[k])) return NO_ERROR;
    // On the clock of Unix, profiles begin at a first state that the page has not seen.
    const moves = task.law && ['target_displacement', 'target_position'].some((name) => typeof Reflect.get(task.law ?? {}, name)?.kind === 'string' && Reflect.get(task.law ?? {}, name).kind !== 'constant');
    if (!this.knowsStart && moves && sample.time_s > UNIX_TIME) return NO_ERROR;
    const isInitial = task.law && 'target_pose' in task.law && (task.law.target_pose ?? 'initial') === 'initial';
    if (!this.knowsStart && (isInitial || (task.law && !('target_pose' in task.law) && positionRows(task).some(Boolean)))) return NO_ERROR;
    if (positionRows(task).some(Boolean)) return poseError(task, this.target(task, sample.time_s), toolPose(sample));
    if (task.law?.kind === 'posture') return { linear: NaN, angular: postureError(task, sample) };
    if (task.law?.kind !== 'velocity') return NO_ERROR;
    const residual = sample.task_residuals[k] ?? [];
    const drift = this.drift[k] ?? residual.map(() => 0);
    this.drift[k] = drift.map((sum, row) => sum + elapsed * (residual[row] ?? 0));
    return residualParts(task, this.drift[k]);
  }

  /** Returns the target pose of a task with a position law. @type {(task: Task, time: number) => Pose} */
  target(task, time) {
    const sent = this.streamed.findLast((target) => target.task === task.name && target.time <= time);
    const start = this.start ?? { position: [0, 0, 0], orientation: { w: 1, x: 0, y: 0, z: 0 } };
    const own = targetPose(task, start, time);
    return sent ? { ...own, ...sent.pose } : own;
  }
}

/** Returns the desired force of the sample along a base axis; null along other directions. @type {(sample: LiveSample, direction: number[]) => number | null} */
function baseTarget(sample, direction) {
  const axis = direction.findIndex((part) => Math.abs(part) > 1 - 1e-9);
  const value = axis < 0 ? null : (sample.target_force[axis] ?? null);
  return value === null ? null : value * Math.sign(direction[axis]);
}

/** @type {(task: Task, sample: LiveSample) => number} */
function postureError({ law }, { time_s: time, joint_position: q }) {
  if (law?.kind !== 'posture' || law.target_position === 'mid_range' || law.joints) return NaN;
  const target = perRow(valueAt(law.target_position, q.length, time), q.length);
  return Math.hypot(...q.map((value, joint) => value - target[joint]));
}
