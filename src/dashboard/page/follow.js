// A playground whose target moves as in a recording, so that the run and the recording have the same task.

import { PLAYGROUND } from './setup.js';
import { post } from './transport.js';

/**
 * @typedef {import('./recording.js').Recording} Recording
 * @typedef {import('./run_control.js').RunControl} RunControl
 * @typedef {import('./types.js').Scenario} Scenario
 */

/** Largest number of points of the target, and time for which the scenario goes on after the recording, s. */
const POINTS = 400;
const AFTER = 1;

/** Starts a run that begins in the first posture of a recording and follows its target. @type {(runControl: RunControl, recording: Recording) => Promise<void>} */
export async function follow(runControl, recording) {
  const { setup } = runControl;
  if (setup) runControl.undoable.push(setup);
  await runControl.makePlayground(recording.robot);
  const plain = runControl.scenarios.find(({ name }) => name === PLAYGROUND);
  const robot = runControl.robots.find(({ name }) => name === recording.robot);
  if (!plain || !robot) throw new Error(`there is no robot ${recording.robot}`);
  const start = recording.positionAt(0).map((value, joint) => {
    const [low, high] = robot.joints[joint].position_limit ?? [-Infinity, Infinity];
    return Math.max(low, Math.min(high, value));
  });
  /** @type {import('./types.js').KinematicsAnswer} */
  const { pose } = await post('/v1/kinematics', { robot: recording.robot, joint_position: start });
  const scenario = following(plain, recording, start, pose.position);
  runControl.scenarios = runControl.scenarios.map((known) => (known === plain ? scenario : known));
  await runControl.selectScenario(PLAYGROUND);
  if (runControl.setup) runControl.setup = { ...runControl.setup, motion: 'recorded' };
  runControl.showSetup();
  await runControl.start(false);
}

/** @type {(plain: Scenario, recording: Recording, start: number[], tool: number[]) => Scenario} */
function following(plain, recording, start, tool) {
  const scenario = structuredClone(plain);
  scenario.description = `${recording.robot} follows the target of ${recording.name}.`;
  scenario.duration_s = recording.duration + AFTER;
  scenario.start_joint_position = start;
  for (const task of scenario.controller.tasks) {
    const law = /** @type {any} */ (task.law);
    if (law.kind === 'posture') law.target_position = { kind: 'constant', value: [...start] };
    if (law.kind === 'pose' && task.axes?.includes('x')) law.target_displacement = displacement(recording, task.axes, tool);
  }
  return scenario;
}

/** @type {(recording: Recording, axes: string[], tool: number[]) => import('./types.js').Profile} */
function displacement(recording, axes, tool) {
  const { times, duration } = recording;
  const count = Math.min(POINTS, times.length);
  const points = Array.from({ length: count }, (_, i) => {
    const time_s = (duration * i) / (count - 1);
    const target = recording.targetAt(time_s) ?? tool;
    return { time_s, value: axes.map((axis) => target['xyz'.indexOf(axis)] - tool['xyz'.indexOf(axis)]) };
  });
  return { kind: 'waypoints', points };
}
