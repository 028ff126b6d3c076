// The data that the plots and numbers show: the latest sample, or the sample at the cursor.

import { colourOf } from './ghost_curves.js';
import { residualParts } from './goals.js';
import { jointLabels } from './labels.js';
import { methodName } from './setup.js';

/**
 * @typedef {import('./run_control.js').RunControl} RunControl
 * @typedef {import('./history.js').History} History
 * @typedef {import('./types.js').ArmView} ArmView
 * @typedef {import('./types.js').Controller} Controller
 * @typedef {import('./types.js').LiveSample} LiveSample
 * @typedef {import('./types.js').PathCounts} PathCounts
 * @typedef {import('./types.js').Robot} Robot
 * @typedef {import('./types.js').TimeHistogram} TimeHistogram
 *
 * @typedef {object} View
 * @property {History} history
 * @property {{history: import('./recording.js').Path, colour: number, name: string}[]} ghosts curves of other arms; `colour`: index in `Palette.ghosts`
 * @property {number} duration of the run, s; 0 if it has no end
 * @property {number | null} cursor time that is shown instead of the latest one, s
 * @property {LiveSample | undefined} sample the shown sample
 * @property {Controller | undefined} controller
 * @property {ArmView | null} arm
 * @property {Robot | null} robot
 * @property {string[]} labels short names of the joints
 * @property {number[]} position q, rad or m
 * @property {number[]} velocity q̇, rad/s or m/s
 * @property {string[]} tasks names with their priorities, in the order of the columns of the history
 * @property {string[]} residualUnits in the same order
 * @property {number[]} order column of the history of each task
 * @property {number | null} threshold δ of the damping
 * @property {number | undefined} sigma smallest singular value of the shown sample
 * @property {number} period T, s
 * @property {PathCounts | null} paths
 * @property {TimeHistogram | null} solveTime
 * @property {boolean} closeUp whether the force axis is zoomed to the desired force
 */

/** Threshold of the damping of a controller that states none. */
const DEFAULT_THRESHOLD = 0.15;

/** Returns the sample that the page shows. @type {(runControl: RunControl) => LiveSample | undefined} */
export function shownSample({ history, cursor }) {
  if (cursor === null) return history.last;
  return history.samples[Math.max(0, history.indexAt(cursor))];
}

/** Returns the smallest singular value at the shown time, or at the start. @type {(runControl: RunControl) => number | undefined} */
function shownSigma({ history, cursor, kinematics, scenario, watch }) {
  const index = cursor === null ? history.length - 1 : Math.max(0, history.indexAt(cursor));
  if (history.length > 0) return history.columns.sigma[index];
  if (watch || !kinematics || !scenario || kinematics.robot !== scenario.controller.robot) return undefined;
  const sigma = kinematics.smallestSingularValue(scenario.controller, scenario.start_joint_position);
  return Number.isFinite(sigma) ? sigma : undefined;
}

/** Returns the posture that the page shows. @type {(runControl: RunControl) => ArmView | null} */
export function shownArm(runControl) {
  const { cursor, history, watch, run, kinematics, robot } = runControl;
  if (cursor !== null && history.arms.length > 0) {
    const sample = shownSample(runControl);
    const near = history.armAt(sample?.time_s ?? cursor);
    if (!near || !sample) return near?.arm ?? null;
    // Samples are denser than postures of the service.
    const arm = near.time === sample.time_s ? near.arm : withoutBounds(near.arm);
    return kinematics && kinematics.robot === robot?.name ? kinematics.armAt(arm, sample.joint_position) : arm;
  }
  if (watch) return watch.step?.arm ?? null;
  return run?.frame?.arm ?? runControl.preview;
}

/** Returns an arm without the bounds of its velocities, which hold in one period only. @type {(arm: ArmView) => ArmView} */
const withoutBounds = (arm) => ({ ...arm, joints: arm.joints.map((joint) => ({ ...joint, lower: null, upper: null })) });

/** Returns the controller of the run, of the session, or of the setup. @type {(runControl: RunControl) => Controller | undefined} */
export function shownController({ watch, running, applied, pastScenario }) {
  return watch?.session.controller ?? (pastScenario ?? running ?? applied)?.controller;
}

/** @type {(runControl: RunControl) => View['ghosts']} */
function curvesOf({ ghosts, recordings, robot, kinematics, watch }) {
  const runs = ghosts.map(({ history, simulation }) => ({ history, colour: colourOf(`method:${simulation.method}`), name: methodName(simulation.method) }));
  const shown = recordings.filter((recording) => !watch && kinematics && kinematics.robot === robot?.name && recording.robot === robot.name);
  return [...runs, ...shown.map((recording) => ({ history: recording.path(/** @type {import('./kinematics.js').Kinematics} */ (kinematics)), colour: colourOf(recording.id), name: recording.name }))];
}

/** @type {(runControl: RunControl) => View} */
export function view(runControl) {
  const { history, watch, run, robot, running, applied, cursor } = runControl;
  const controller = shownController(runControl);
  const sample = shownSample(runControl);
  const frame = run?.frame;
  const scenario = running ?? applied;
  const order = history.segmentAt(cursor)?.order ?? history.order;
  /** @type {(values: string[]) => string[]} */
  const byColumn = (values) => {
    /** @type {string[]} */
    const placed = [];
    values.forEach((value, k) => { placed[order[k] ?? k] = value; });
    return placed;
  };
  return {
    history,
    ghosts: curvesOf(runControl),
    duration: watch ? 0 : (scenario ? history.offset + scenario.duration_s : 0),
    cursor,
    sample,
    controller,
    arm: shownArm(runControl),
    robot,
    labels: jointLabels(robot?.joints.map(({ name }) => name) ?? []),
    position: sample?.joint_position ?? (watch ? [] : (scenario?.start_joint_position ?? [])),
    velocity: sample?.joint_velocity ?? [],
    tasks: byColumn(controller?.tasks.map(({ name }, k) => `${k + 1}. ${name}`) ?? []),
    residualUnits: byColumn(controller?.tasks.map(residualUnit) ?? []),
    order,
    threshold: controller?.damping === null ? null : (controller?.damping?.threshold ?? DEFAULT_THRESHOLD),
    sigma: shownSigma(runControl),
    period: controller?.period_s ?? 0.001,
    paths: watch?.paths ?? frame?.paths ?? null,
    solveTime: watch?.solveTime ?? frame?.solve_time ?? null,
    closeUp: runControl.closeUp,
  };
}

/** @type {(task: import('./types.js').ControllerTask) => string} */
function residualUnit(task) {
  const { linear, angular } = residualParts(task, (task.axes ?? ['rx']).map(() => 1));
  if (Number.isNaN(linear)) return 'rad/s';
  return Number.isNaN(angular) ? 'm/s' : 'm/s, rad/s';
}
