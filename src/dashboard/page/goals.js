// What the tasks of a scenario aim at: target poses, pose errors, and desired forces along the axes of each task.

import { add, dot, norm, scale, sub } from './geometry.js';
import { perRow, valueAt } from './profile.js';
import { IDENTITY, fromVector, inverse, multiply, rotate, rotationVector } from './rotation.js';

/**
 * @typedef {import('./types.js').Controller} Controller
 * @typedef {import('./types.js').ControllerTask} Task
 * @typedef {import('./types.js').Pose} Pose
 * @typedef {import('./types.js').Profile} Profile
 * @typedef {import('./types.js').Quaternion} Quaternion
 * @typedef {import('./types.js').Vec3} Vec3
 *
 * @typedef {{linear: number, angular: number}} PoseError norms, m and rad; nan for axes that the task does not control
 *
 * @typedef {object} ForceRow a direction in which a task follows a force
 * @property {string} label
 * @property {Vec3} direction unit vector, base axes
 * @property {(time: number) => number} target desired force in this direction, N
 */

const LINEAR = ['x', 'y', 'z'];
const ANGULAR = ['rx', 'ry', 'rz'];

/** @type {(list: number[]) => Vec3} */
const vec = (list) => [list[0], list[1], list[2]];

/** Returns the fixed frame of a task; null for the base and for the tool. @type {(task: Task) => Pose | null} */
export function fixedFrame({ frame }) {
  return typeof frame === 'object' && frame !== null ? frame : null;
}

/** Returns the rows of a task that follow a position. @type {(task: Task) => boolean[]} */
export function positionRows(task) {
  const { law } = task;
  const axes = task.axes ?? [];
  if (!law || !['pose', 'impedance', 'hybrid'].includes(law.kind)) return axes.map(() => false);
  return law.kind === 'hybrid' ? perRow(law.position_controlled, axes.length) : axes.map(() => true);
}

/** Returns the linear directions along which a task follows a position, base axes. @type {(task: Task) => Vec3[]} */
export function positionDirections(task) {
  const rows = positionRows(task);
  const rotation = fixedFrame(task)?.orientation ?? IDENTITY;
  return (task.axes ?? []).flatMap((axis, row) => {
    const k = LINEAR.indexOf(axis);
    return rows[row] && k >= 0 ? [rotate(rotation, unitAxis(k))] : [];
  });
}

/** @type {(k: number) => Vec3} */
const unitAxis = (k) => vec([Number(k === 0), Number(k === 1), Number(k === 2)]);

/**
 * Returns the pose that a task aims at, base frame.
 * @param {Task} task with a position law
 * @param {Pose} start pose of the tool at the start of the run
 * @param {number} time s
 * @returns {Pose}
 */
export function targetPose(task, start, time) {
  const law = /** @type {{target_pose?: 'initial' | Pose, target_displacement?: Profile | null}} */ (task.law);
  const given = law.target_pose ?? 'initial';
  const frame = fixedFrame(task);
  const pose = given === 'initial' ? referencePose(task, start) : frame ? inBase(frame, given) : given;
  if (!law.target_displacement) return pose;
  const axes = task.axes ?? [];
  const values = valueAt(law.target_displacement, axes.length, time);
  const along = (/** @type {string[]} */ names) =>
    vec(names.map((name) => values[axes.indexOf(/** @type {any} */ (name))] ?? 0));
  const turn = task.frame === 'tool' ? pose.orientation : (frame?.orientation ?? IDENTITY);
  const rotation = fromVector(rotate(turn, along(ANGULAR)));
  return {
    position: add(vec(pose.position), rotate(turn, along(LINEAR))),
    orientation: multiply(rotation, pose.orientation),
  };
}

/** @type {(frame: Pose, pose: Pose) => Pose} */
function inBase(frame, { position, orientation }) {
  return {
    position: add(vec(frame.position), rotate(frame.orientation, vec(position))),
    orientation: multiply(frame.orientation, orientation),
  };
}

/** Returns a pose of the base frame in the frame of the task's targets. @type {(task: Task, pose: Pose) => Pose} */
export function inTaskFrame(task, { position, orientation }) {
  const frame = fixedFrame(task);
  if (!frame) return { position, orientation };
  const back = inverse(frame.orientation);
  return {
    position: rotate(back, sub(vec(position), vec(frame.position))),
    orientation: multiply(back, orientation),
  };
}

/** Returns the pose of the task's reference point for a pose of the tool. @type {(task: Task, tool: Pose) => Pose} */
export function referencePose({ reference_point: point }, { position, orientation }) {
  return { position: point ? add(vec(position), rotate(orientation, vec(point))) : position, orientation };
}

/**
 * Returns how far the tool is from the target of a task, along the axes that the task controls.
 * @param {Task} task with a position law
 * @param {Pose} target
 * @param {Pose} tool
 * @returns {PoseError}
 */
export function poseError(task, target, tool) {
  const at = referencePose(task, tool);
  const rotation = task.frame === 'tool' ? tool.orientation : (fixedFrame(task)?.orientation ?? IDENTITY);
  const back = inverse(rotation);
  const shift = rotate(back, sub(vec(at.position), vec(target.position)));
  const turn = rotate(back, rotationVector(multiply(at.orientation, inverse(target.orientation))));
  const rows = positionRows(task);
  const part = (/** @type {string[]} */ names, /** @type {Vec3} */ vector) => {
    const values = (task.axes ?? []).flatMap((axis, row) => (rows[row] && names.includes(axis) ? [vector[names.indexOf(axis)]] : []));
    return values.length > 0 ? Math.hypot(...values) : NaN;
  };
  return { linear: part(LINEAR, shift), angular: part(ANGULAR, turn) };
}

/** Returns the directions in which tasks follow a force. @type {(controller: Controller) => ForceRow[]} */
export function forceRows(controller) {
  return controller.tasks.flatMap((task) => {
    const { law } = task;
    if (!law || !('target_force' in law) || task.frame === 'tool') return [];
    const axes = task.axes ?? [];
    const held = positionRows(task);
    const frame = fixedFrame(task);
    return axes.flatMap((axis, row) => {
      const k = LINEAR.indexOf(axis);
      const target = (/** @type {number} */ time) => valueAt(law.target_force, axes.length, time)[row];
      const isIdle = Array.from({ length: 8 }, (_, i) => target(i * 0.7)).every((value) => value === 0);
      if (k < 0 || held[row] || isIdle) return [];
      // A force against an axis is shown as a positive force in the opposite direction.
      const sign = (frame || law.kind === 'contact') && target(0) < 0 ? -1 : 1;
      const direction = scale(rotate(frame?.orientation ?? IDENTITY, unitAxis(k)), sign);
      const label = `${sign < 0 ? '−' : ''}${axis}${frame ? ` of “${task.name}”` : ''}`;
      return [{ label, direction, target: (/** @type {number} */ time) => sign * target(time) }];
    });
  }).slice(0, 3);
}

/** Returns whether forces matter in a run: a task follows or feels them, or a contact or a push exerts them. @type {(scenario: {controller: Controller, contacts?: unknown[], external_wrench?: unknown}) => boolean} */
export function hasForces({ controller, contacts, external_wrench: push }) {
  const feels = controller.tasks.some(({ law }) => law && ['contact', 'force', 'hybrid', 'impedance'].includes(law.kind));
  return feels || Boolean(push) || (contacts ?? []).length > 0;
}

/** Splits a task's velocity residual into its linear and angular part; nan for a missing part. @type {(task: Task, residual: number[]) => PoseError} */
export function residualParts(task, residual) {
  const axes = task.axes ?? [];
  const part = (/** @type {string[]} */ names) => {
    const values = residual.filter((_, row) => names.includes(axes[row]));
    return values.length > 0 ? Math.hypot(...values) : NaN;
  };
  if (axes.length > 0) return { linear: part(LINEAR), angular: part(ANGULAR) };
  return { linear: NaN, angular: residual.length > 0 ? Math.hypot(...residual) : NaN };
}

/** Returns whether some rows of the tasks depend on others in every posture. @type {(controller: Controller, joints: number) => boolean} */
export function areDependent({ tasks }, joints) {
  const rows = tasks.flatMap(toolRows);
  const others = tasks.reduce((sum, task) => sum + (task.axes ? 0 : (task.jacobian?.length ?? joints)), 0);
  return rows.length + others > joints || rank(rows) < rows.length;
}

/** Returns the directions of the tool that the tasks control, as far as they are independent. @type {(controller: Controller, joints: number) => number[][]} */
export function controlledRows({ tasks }, joints) {
  /** @type {number[][]} */
  const rows = [];
  for (const row of tasks.filter(({ link, relative_to: other }) => !link && !other).flatMap(toolRows)) {
    if (rows.length < joints && rank([...rows, row]) > rows.length) rows.push(row);
  }
  return rows;
}

/** Returns the rows of a task as directions of the tool: linear, then angular part. @type {(task: Task) => number[][]} */
function toolRows(task) {
  const turn = fixedFrame(task)?.orientation ?? IDENTITY;
  return (task.axes ?? []).map((axis) => {
    const isLinear = axis.length === 1;
    const direction = rotate(turn, unitAxis((isLinear ? LINEAR : ANGULAR).indexOf(axis)));
    return isLinear ? [...direction, 0, 0, 0] : [0, 0, 0, ...direction];
  });
}

/** @type {(rows: number[][]) => number} number of linearly independent rows, by Gram-Schmidt */
function rank(rows) {
  /** @type {number[][]} */
  const basis = [];
  for (const row of rows) {
    const rest = basis.reduce((left, other) => {
      const part = left.reduce((sum, value, i) => sum + value * other[i], 0);
      return left.map((value, i) => value - part * other[i]);
    }, row);
    const length = Math.hypot(...rest);
    if (length > 1e-6) basis.push(rest.map((value) => value / length));
  }
  return basis.length;
}

/** @type {(force: Vec3, direction: Vec3) => number} the component of a force, N */
export const along = (force, direction) => dot(force, direction) / Math.max(1e-12, norm(direction));
