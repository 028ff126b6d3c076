// Watches a session that another client uses. The page cannot change the session.

import { vec } from './arm.js';
import { History } from './history.js';
import { Kinematics } from './kinematics.js';
import { Measures } from './measures.js';
import { rotate } from './rotation.js';
import { events, get } from './transport.js';

/**
 * @typedef {import('./types.js').SessionList} SessionList
 * @typedef {import('./types.js').SessionStatus} SessionStatus
 * @typedef {import('./types.js').WatchedStep} WatchedStep
 * @typedef {import('./types.js').LiveSample} LiveSample
 * @typedef {import('./types.js').Robot} Robot
 */

/** Time between two looks at the status of the session, ms. */
const STATUS_TIME = 2000;

/** @returns {Promise<SessionList>} */
export function sessions() {
  return get('/v1/controllers');
}

/** A watched session: receives its steps and converts them to samples. */
export class Watch {
  /**
   * @param {SessionStatus} session
   * @param {Robot} robot
   * @param {Kinematics} kinematics
   */
  constructor(session, robot, kinematics) {
    this.session = session;
    this.robot = robot;
    this.kinematics = kinematics;
    this.history = new History(new Measures(session.controller, null, kinematics));
    /** @type {WatchedStep | null} */
    this.step = null;
    /** Number of watched steps by solver path. */
    this.paths = { closed_form: 0, active_set: 0, qp: 0 };
    this.solveTime = { counts: /** @type {number[]} */ (Array(52).fill(0)), worst_us: 0 };
    this.abort = new AbortController();
  }

  /** @param {string} id */
  static async open(id) {
    /** @type {SessionStatus} */
    const session = await get(`/v1/controllers/${id}`);
    /** @type {Robot} */
    const robot = await get(`/v1/robots/${session.controller.robot}`);
    return new Watch(session, robot, await Kinematics.learn(robot));
  }

  /**
   * @param {(watch: Watch) => void} onChange called after each step, and with each status
   * @param {(reason: 'end' | 'lost' | 'replaced', error?: unknown) => void} onEnd `replaced`: the session has another controller now
   */
  async follow(onChange, onEnd) {
    const status = setInterval(() => this.readStatus(onChange, () => onEnd('replaced')), STATUS_TIME);
    const onEvent = (/** @type {string} */ _name, /** @type {WatchedStep} */ step) => {
      this.addStep(step);
      onChange(this);
    };
    try {
      await events(`/v1/controllers/${this.session.id}/watch`, onEvent, this.abort.signal);
      if (!this.abort.signal.aborted) onEnd('end');
    } catch (error) {
      if (!this.abort.signal.aborted) onEnd('lost', error);
    } finally {
      clearInterval(status);
    }
  }

  /**
   * Reads how many periods were missed, and whether another client has replaced the controller.
   * @param {(watch: Watch) => void} onChange
   * @param {() => void} onReplaced
   */
  async readStatus(onChange, onReplaced) {
    /** @type {SessionStatus | null} */
    const session = await get(`/v1/controllers/${this.session.id}`).catch(() => null);
    // The stream says that the service is gone.
    if (!session || this.abort.signal.aborted) return;
    const isReplaced = JSON.stringify(session.controller) !== JSON.stringify(this.session.controller);
    if (isReplaced) return onReplaced();
    this.session = session;
    onChange(this);
  }

  /** @param {WatchedStep} step */
  addStep(step) {
    this.step = step;
    const { answer } = step;
    this.paths[answer.solver.path] += 1;
    const bin = Math.floor(10 * Math.log10(Math.max(0.1, answer.elapsed_us)) + 1);
    this.solveTime.counts[Math.max(0, Math.min(51, bin))] += 1;
    this.solveTime.worst_us = Math.max(this.solveTime.worst_us, answer.elapsed_us);
    this.history.measures?.follow(answer);
    this.history.push(this.sample(step));
    if (step.arm) this.history.pushArm(step.state.time_s, step.arm);
  }

  /**
   * Converts a step to a sample.
   * @param {WatchedStep} step
   * @returns {LiveSample}
   */
  sample({ state, answer, arm }) {
    const names = this.robot.joints.map((joint) => joint.name);
    const limited = (/** @type {string} */ side) =>
      [...answer.active_limits, ...answer.violated_limits]
        .filter((limit) => limit.side === side)
        .map((limit) => names.indexOf(limit.joint))
        .filter((joint) => joint >= 0);
    return {
      time_s: state.time_s,
      joint_position: this.joints(state.joint_position),
      joint_velocity: answer.joint_velocity,
      position: arm?.tool.position ?? [0, 0, 0],
      orientation: arm ? [arm.tool.orientation.w, arm.tool.orientation.x, arm.tool.orientation.y, arm.tool.orientation.z] : [1, 0, 0, 0],
      force: answer.wrench?.force ?? this.force(state.wrench?.force ?? [0, 0, 0], arm),
      target_force: targets(this.session, answer),
      wall_distance_m: null,
      residual_norms: answer.tasks.map((task) => task.residual_norm),
      task_residuals: answer.tasks.map(({ achieved, requested }) => achieved.map((value, row) => value - requested[row])),
      active_inequalities: (answer.active_inequalities ?? []).map(({ name }) => name),
      smallest_singular_value: answer.singularity.smallest_singular_value,
      at_lower: limited('lower'),
      at_upper: limited('upper'),
      path: answer.solver.path,
      status: answer.solver.status,
      kkt_residual: answer.solver.kkt_residual,
      solve_us: answer.elapsed_us,
      round_trip_us: 0,
      answered: true,
      channels: answer.channels,
      contacts: answer.tasks.flatMap(({ contact }, task) => (contact ?? []).map((report, row) => ({ ...report, force: report.force ?? 0, target_force: report.target_force ?? 0, task, row }))),
      ...(answer.why && { why: answer.why }),
      ...(answer.collisions && { room: { report: answer.collisions, obstacles: state.obstacles ?? [] } }),
    };
  }

  /**
   * Returns a measured force as the force of the tool on its environment, base axes; not a number if it is in the axes of a tool whose pose is not known.
   * @param {number[]} measured
   * @param {WatchedStep['arm']} arm
   * @returns {number[]}
   */
  force(measured, arm) {
    const { wrench_convention: convention, wrench_frame: frame } = this.session.controller;
    const force = vec(measured.map((value) => (convention === 'on_tool' ? -value : value)));
    if (frame !== 'tool') return force;
    return arm ? rotate(arm.tool.orientation, force) : [NaN, NaN, NaN];
  }

  /**
   * Returns a joint vector in the robot's joint order.
   * @param {number[] | Record<string, number>} vector
   * @returns {number[]}
   */
  joints(vector) {
    return Array.isArray(vector) ? vector : this.robot.joints.map((joint) => vector[joint.name]);
  }

  close() {
    this.abort.abort();
  }
}

/**
 * Returns the desired force along the base axes x, y and z, N; null for axes without one.
 * @param {SessionStatus} session
 * @param {WatchedStep['answer']} answer
 * @returns {(number | null)[]}
 */
function targets(session, answer) {
  /** @type {(number | null)[]} */
  const found = [null, null, null];
  session.controller.tasks.forEach((task, k) => {
    if (task.frame !== undefined && task.frame !== 'base') return;
    task.axes?.forEach((axis, row) => {
      const place = ['x', 'y', 'z'].indexOf(axis);
      if (place >= 0) found[place] = answer.tasks[k]?.target_force?.[row] ?? null;
    });
  });
  return found;
}
