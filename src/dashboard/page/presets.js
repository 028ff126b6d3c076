// The presets `push` and `wipe`: the tasks of the clients' presets and of `revprio push`, against a wall next to the tool.

import { dot } from './geometry.js';
import { SIDES, normalOf } from './planes.js';

/**
 * @typedef {import('./types.js').Axis} Axis
 * @typedef {import('./types.js').ControllerTask} ControllerTask
 * @typedef {import('./types.js').Scenario} Scenario
 *
 * @typedef {object} Press
 * @property {'push' | 'wipe'} kind
 * @property {string} side direction in which the tool presses, as in `−z`
 * @property {number} newtons
 * @property {string} along axis of the motion of `wipe`
 * @property {number | null} speed of the approach, m/s; null: the largest that keeps 1.2 times the force
 */

/** Lag and delay of the simulated arm and of the controller's drive: the defaults of the controller. */
const DRIVE = { lag_s: 0.03, delay_periods: 2 };

/** Way of `wipe`, m, and its largest speed, m/s. */
const STROKE = 0.1;
const SPEED = 0.05;

/** Largest force, N, and largest speed of the approach, m/s: more than any arm of the page has. */
export const MOST_NEWTONS = 1000;
export const MOST_SPEED = 1;

/** Noise of the simulated force sensor, N: a reading that never changes looks like that of a sensor that sticks. */
const NOISE = 0.05;

/** Largest gain of a pose law, 1/s. */
const POSE_GAIN = 2;

/** The wall: its distance from the tool, m, and its stiffness, N/m, which the controller does not know. */
export const DISTANCE = 0.01;
const STIFFNESS = 2e4;

/** Axis of a side. @type {(side: string) => Axis} */
const axisOf = (side) => /** @type {Axis} */ (side[1]);

/** Changes a playground so that its tool presses. @type {(scenario: Scenario, press: Press, mobile: Axis[]) => Scenario} `mobile`: axes along which the tool can move */
export function pressing(scenario, press, mobile) {
  const { kind, side, newtons, along, speed } = press;
  const axis = axisOf(side);
  const { controller } = scenario;
  const wiped = kind === 'wipe' ? [/** @type {Axis} */ (along)] : [];
  for (const needed of [axis, ...wiped]) {
    if (!mobile.includes(needed)) throw new Error(`the tool of ${controller.robot} cannot move along ${needed}`);
  }
  if (wiped[0] === axis) throw new Error(`the tool presses along ${axis}: choose another axis for the motion`);
  const normal = normalOf(side);
  const sign = Math.sign(dot(normal, [1, 1, 1]));
  const gain = Math.min(POSE_GAIN, 1 / (8 * (DRIVE.lag_s + DRIVE.delay_periods * controller.period_s)));
  const force = /** @type {const} */ ({ kind: 'contact', target_force: { kind: 'constant', value: sign * newtons } });
  /** @type {any[]} */
  const tasks = [{ name: 'push', axes: [axis], law: { ...force, ...(speed && { approach_speed: speed }) } }];
  if (kind === 'wipe') {
    const way = { kind: 'sine', offset: STROKE / 2, amplitude: STROKE / 2, angular_frequency_rad_s: (2 * SPEED) / STROKE, phase_rad: -Math.PI / 2 };
    tasks.push({ name: 'wipe', axes: wiped, law: { kind: 'pose', gain, target_displacement: way } });
  }
  const held = mobile.filter((other) => other !== axis && !wiped.includes(other));
  if (held.length > 0) tasks.push({ name: 'hold', axes: held, law: { kind: 'pose', gain } });
  const words = kind === 'wipe' ? `presses towards ${side} with ${newtons} N and wipes along ${along}` : `presses towards ${side} with ${newtons} N`;
  return {
    ...scenario,
    description: `${controller.robot} ${words}, on a wall whose stiffness it does not know.`,
    controller: { ...controller, drive: DRIVE, tasks },
    velocity_loop: DRIVE,
    sensors: /** @type {any} */ ({ force: { noise: NOISE } }),
    contacts: [{ kind: 'plane', normal: normal.map((part) => -part), offset_m: DISTANCE, stiffness: STIFFNESS }],
  };
}

/** @type {(press: Press) => string} for the fragment of an address */
export const pressText = ({ kind, side, newtons, along, speed }) => [kind, side, newtons, along, speed ?? ''].join(',');

/** Reads what `pressText` wrote; null if it is invalid. @type {(text: string | null) => Press | null} */
export function pressFrom(text) {
  const [kind, side, newtons, along, speed] = (text ?? '').split(',');
  const isValid = (kind === 'push' || kind === 'wipe') && SIDES.includes(side) && 'xyz'.includes(along) && along.length === 1;
  if (!isValid || !isWithin(Number(newtons), MOST_NEWTONS) || (speed && !isWithin(Number(speed), MOST_SPEED))) return null;
  return { kind, side, newtons: Number(newtons), along, speed: speed ? Number(speed) : null };
}

/** @type {(value: number, most: number) => boolean} */
const isWithin = (value, most) => value > 0 && value <= most;
