// The arms that are compared with the run: runs with other methods, and recordings.

import { vec } from './arm.js';
import { colourOf, keepColours } from './ghost_curves.js';
import { toolPose } from './measures.js';
import { positionAt, timeToShow } from './playback.js';
import { methodName } from './setup.js';
import { state } from './state.js';
import { distanceTo, handle } from './target.js';
import { shownArm } from './view.js';

/**
 * @typedef {import('./run_control.js').RunControl} RunControl
 * @typedef {import('./run.js').Run} Run
 * @typedef {import('./recording.js').Path} Path
 * @typedef {import('./recording.js').Recording} Recording
 * @typedef {import('./types.js').ArmView} ArmView
 *
 * @typedef {object} Ghost an arm that is compared with that of the run
 * @property {string} id
 * @property {string} name
 * @property {number} colour index in `Palette.ghosts`
 * @property {ArmView | null} arm
 * @property {Path} history
 * @property {number | null} until end of the drawn path, s; null: its latest point
 * @property {number[]} position q, rad or m
 * @property {import('./types.js').Vec3 | null} target its own target of the tool, m; null: that of the run
 * @property {number | null} away distance of the tool from the target, m
 *
 * @typedef {{id: string, name: string, isKnown: boolean, recording: Recording | null}} Entry a ghost in the list; it is shown if `isKnown`
 */

/** Returns the chosen methods and the recordings, in the order of the list. @type {(runControl: RunControl) => Entry[]} */
export function entries({ setup, ghosts, recordings, robot, watch }) {
  const running = new Set(ghosts.map(({ simulation }) => simulation.method));
  const methods = (watch ? [] : (setup?.ghosts ?? [])).map((method) => ({ id: `method:${method}`, name: methodName(method), isKnown: running.has(method), recording: null }));
  const others = recordings.map((recording) => ({ id: recording.id, name: recording.name, isKnown: recording.robot === robot?.name, recording }));
  const all = [...methods, ...others];
  keepColours(all.map(({ id }) => id));
  all.forEach(({ id }) => colourOf(id));
  return all;
}

/** Returns the ghosts at the shown time. @type {(runControl: RunControl, now: number | null) => Ghost[]} `now`: real time for even motion between samples, s */
export function ghostsOf(runControl, now) {
  const { ghosts, recordings, robot } = runControl;
  entries(runControl);
  const shown = recordings.filter((recording) => recording.robot === robot?.name);
  return [...ghosts.flatMap((run) => ofRun(runControl, run, now)), ...shown.flatMap((recording) => ofRecording(runControl, recording, now))];
}

/** @type {(runControl: RunControl, run: Run, now: number | null) => Ghost[]} */
function ofRun(runControl, run, now) {
  const { cursor, setup } = runControl;
  const { history, frame, simulation } = run;
  const arm = cursor === null ? frame?.arm : history.armAt(cursor)?.arm;
  if (!arm) return [];
  const sample = cursor === null ? history.last : history.samples[Math.max(0, history.indexAt(cursor))];
  const isEven = now !== null && cursor === null && state.value.phase === 'running';
  const position = (isEven ? positionAt(history, timeToShow(history, setup?.speed ?? 1, now)) : sample?.joint_position) ?? [];
  const { kinematics, robot } = runControl;
  const shown = kinematics && kinematics.robot === robot?.name ? kinematics.armAt(arm, position) : arm;
  const goal = handle(runControl);
  const away = goal && sample ? distanceTo(goal, toolPose(sample).position) : null;
  const id = `method:${simulation.method}`;
  return [{ id, name: methodName(simulation.method), colour: colourOf(id), arm: shown, history, until: cursor, position, target: null, away }];
}

/** @type {(runControl: RunControl, recording: Recording, now: number | null) => Ghost[]} */
function ofRecording(runControl, recording, now) {
  const { kinematics, robot } = runControl;
  if (!kinematics || kinematics.robot !== robot?.name) return [];
  const time = shownTime(runControl, now);
  const position = recording.positionAt(time);
  const known = shownArm(runControl);
  const frames = kinematics.frames(position);
  const tool = kinematics.tool(frames).position;
  const goal = handle(runControl);
  const target = recording.targetAt(time);
  const aim = target ?? (goal && vec(goal.pose.position));
  const away = aim && Math.hypot(...tool.map((value, axis) => value - aim[axis]));
  // The canvas draws no posture of an arm with several chains.
  const arm = known && !known.chains ? kinematics.armAt(known, position) : null;
  const { id, name } = recording;
  return [{ id, name, colour: colourOf(id), arm, history: recording.path(kinematics), until: time, position, target, away }];
}

/** Returns the shown time since the start of the run or of the session, s. @type {(runControl: RunControl, now: number | null) => number} */
export function shownTime({ cursor, history, setup, watch }, now) {
  const isEven = now !== null && cursor === null && !watch && state.value.phase === 'running';
  const time = cursor ?? (isEven ? timeToShow(history, setup?.speed ?? 1, now) : history.now);
  return watch && history.length > 0 ? time - history.columns.time[0] : time;
}
