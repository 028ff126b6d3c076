// The target of a task in the scene: where it is, and how the user moves it.

import { vec } from './arm.js';
import { add, dot, scale, sub } from './geometry.js';
import { inTaskFrame, positionDirections, referencePose, targetPose } from './goals.js';
import { toolPose } from './measures.js';
import { shownController, shownSample } from './view.js';

/**
 * @typedef {import('./run_control.js').RunControl} RunControl
 * @typedef {import('./types.js').ControllerTask} Task
 * @typedef {import('./types.js').Pose} Pose
 * @typedef {import('./types.js').Vec3} Vec3
 *
 * @typedef {object} Goal
 * @property {Task} task
 * @property {Pose} pose of the task's reference point, base frame; along directions that the task leaves free, that of the tool
 * @property {Vec3[]} directions along which the task follows it
 */

/** Minimum interval between two targets that the page sends, ms. */
const SEND_INTERVAL = 40;

/** Returns the target that the user can drag: that of the highest task that follows a position. @type {(runControl: RunControl) => Goal | null} */
export function handle(runControl) {
  const { watch, history, run, cursor, preview, dragged } = runControl;
  const tasks = shownController(runControl)?.tasks ?? [];
  const task = tasks.find((candidate) => positionDirections(candidate).length > 0);
  const start = history.measures?.start ?? preview?.tool;
  if (!task || !start || watch) return null;
  const directions = positionDirections(task);
  const sample = shownSample(runControl);
  const tool = sample ? toolPose(sample) : preview?.tool;
  const goal = (/** @type {Pose} */ pose) => ({ task, pose: tool ? atFreeDirections(task, pose, directions, tool) : pose, directions });
  if (dragged?.task === task.name && cursor === null) return goal(dragged.pose);
  const { from = 0, measures = null } = history.segmentAt(cursor) ?? {};
  const time = (sample?.time_s ?? 0) - from;
  return goal(run && measures && history.length > 0 ? measures.target(task, time) : targetPose(task, start, 0));
}

/** Moves a target to the tool along the directions that its task leaves free. @type {(task: Task, pose: Pose, directions: Vec3[], tool: Pose) => Pose} */
function atFreeDirections(task, pose, directions, tool) {
  const aim = vec(pose.position);
  const away = sub(vec(referencePose(task, tool).position), aim);
  const free = directions.reduce((left, direction) => sub(left, scale(direction, dot(left, direction))), away);
  return { ...pose, position: add(aim, free) };
}

/** Moves the target and sends it to the run. @type {(runControl: RunControl, goal: Goal, shift: Vec3) => void} */
export function moveTarget(runControl, goal, shift) {
  const allowed = goal.directions.reduce((sum, direction) => add(sum, scale(direction, dot(shift, direction))), vec([0, 0, 0]));
  const pose = { ...goal.pose, position: add(vec(goal.pose.position), allowed) };
  runControl.dragged = { task: goal.task.name, pose };
  sendTarget(runControl, goal.task, pose);
  runControl.onChange();
}

/** Ends a movement: the target becomes a part of the setup. @type {(runControl: RunControl) => void} */
export function dropTarget(runControl) {
  const { dragged, setup } = runControl;
  if (!dragged || !setup) return;
  runControl.dragged = null;
  const task = shownController(runControl)?.tasks.find(({ name }) => name === dragged.task);
  if (task) sendTarget(runControl, task, dragged.pose);
  const targets = { ...setup.targets, [dragged.task]: dragged.pose };
  runControl.change({ targets }).catch(runControl.onError);
}

/** The target to send next, and whether one is being sent: requests could overtake each other. */
let isSending = false;
/** @type {{task: Task, pose: Pose} | null} */
let waiting = null;

/** Sends a target to the run and its ghosts, after the one before it. A run that is being made gets it afterwards. @type {(runControl: RunControl, task: Task, pose: Pose) => Promise<void>} */
export async function sendTarget(runControl, task, pose) {
  await runControl.started.catch(() => {});
  if (!runControl.isActive) return;
  for (const run of [runControl.run, ...runControl.ghosts]) {
    const { history } = run ?? {};
    history?.measures?.streamed.push({ task: task.name, time: history.now - history.offset, pose });
  }
  waiting = { task, pose };
  if (!isSending) sendWaiting(runControl).catch(runControl.onError);
}

/** @param {RunControl} runControl */
async function sendWaiting(runControl) {
  isSending = true;
  try {
    while (waiting) {
      const { task, pose } = waiting;
      waiting = null;
      // At rest: the loop would go on along a last step of the pointer, and hold a place beyond the target.
      const target = { pose: inTaskFrame(task, pose), velocity: (task.axes ?? []).map(() => 0) };
      await runControl.sendControl({ targets: { [task.name]: target } });
      if (waiting) await new Promise((resolve) => { setTimeout(resolve, SEND_INTERVAL); });
    }
  } finally {
    isSending = false;
  }
}

/** @type {(goal: Goal, tool: number[]) => number} distance from the tool to the target, m */
export function distanceTo({ pose }, tool) {
  return Math.hypot(...sub(vec(pose.position), vec(tool)));
}
