// A target that follows a figure of eight, for the playground.

import { positionRows } from './goals.js';

/**
 * @typedef {import('./types.js').ControllerTask} Task
 * @typedef {import('./types.js').Scenario} Scenario
 * @typedef {import('./types.js').Profile} Profile
 */

/** Time of one round, s, and the number of its points. */
const ROUND = 7;
const POINTS = 8;

/** Size of the figure as a part of the distance from the base to the start, across and up. */
const ACROSS = 0.3;
const UP = 0.17;

/** Smallest size across, m. */
const SMALLEST = 0.03;

/** Lets the target of the first task that follows a position go round. @type {(scenario: Scenario, start: import('./types.js').Vec3) => void} */
export function addFigureOfEight(scenario, start) {
  const task = scenario.controller.tasks.find((candidate) => linearAxes(candidate).length > 0);
  if (!task?.law) return;
  const size = Math.max(SMALLEST, Math.hypot(...start));
  const law = /** @type {any} */ (task.law);
  if (law.target_pose && law.target_pose !== 'initial') return;
  law.target_displacement = figure(task, size, scenario.duration_s);
}

/** @type {(task: Task) => string[]} */
function linearAxes(task) {
  const rows = positionRows(task);
  return (task.axes ?? []).filter((axis, row) => rows[row] && axis.length === 1);
}

/** @type {(task: Task, size: number, duration: number) => Profile} */
function figure(task, size, duration) {
  const axes = task.axes ?? [];
  const [up, across] = [...linearAxes(task)].reverse();
  const points = [];
  for (let i = 0; (i * ROUND) / POINTS <= duration; i += 1) {
    const angle = (2 * Math.PI * i) / POINTS;
    const value = axes.map((axis) => round(axis === across ? ACROSS * size * Math.sin(angle) : axis === up ? UP * size * Math.sin(2 * angle) : 0));
    points.push({ time_s: (i * ROUND) / POINTS, value });
  }
  return { kind: 'waypoints', points };
}

/** @type {(value: number) => number} to a tenth of a millimetre */
const round = (value) => Math.round(value * 1e4) / 1e4;
