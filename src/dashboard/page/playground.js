// The playground: a scenario that the page makes for any robot.

import { quantity } from './number.js';
import { DISTANCE, pressing } from './presets.js';
import { post } from './transport.js';

/**
 * @typedef {import('./types.js').KinematicsAnswer} KinematicsAnswer
 * @typedef {import('./types.js').Robot} Robot
 * @typedef {import('./types.js').RobotJoint} RobotJoint
 * @typedef {import('./types.js').Scenario} Scenario
 */

const AXES = /** @type {const} */ (['x', 'y', 'z', 'rx', 'ry', 'rz']);

/** Control period, s, and duration of a run, s. A simulation has at most 100 000 periods. */
const PERIOD = 0.004;
const DURATION = 400;

/** Postures that are tried: a position in the range of each joint, repeated along the arm. */
const PATTERNS = [
  [0.5], [0.55, 0.35, 0.5, 0.3, 0.5, 0.7], [0.5, 0.4, 0.6, 0.35], [0.6, 0.3, 0.45], [0.5, 0.15, 0.93, 0.22, 0.88, 0.5], [0.5, 0.25, 0.85, 0.4, 0.1, 0.5],
];

/** Widest range that is used of a joint, rad or m. */
const WIDEST = Math.PI;

/** Smallest norm of a row of the Jacobian of a direction in which the tool can move, m/rad. */
const MIN_MOBILITY = 1e-6;

/** Number of further postures that are tried if all of these are near singularities, and the steps between them. */
const FURTHER = 16;
const STEPS = [0.618, 0.755, 0.382, 0.57, 0.245, 0.819, 0.467];

/** @type {(robot: Robot, press?: import('./presets.js').Press | null) => Promise<Scenario>} `press`: what the tool does instead of holding its pose */
export async function playground(robot, press = null) {
  const first = await Promise.all(PATTERNS.map((pattern) => tried(robot, pattern)));
  const isMobile = (/** @type {number} */ row) => first.some(({ answer }) => Math.hypot(...answer.jacobian[row]) > MIN_MOBILITY);
  const mobile = AXES.filter((_, row) => isMobile(row));
  const directions = Math.min(mobile.length, robot.joints.length);
  const regularity = (/** @type {Tried} */ { answer }) => answer.singular_values[directions - 1] ?? 0;
  let candidates = first.filter((one) => regularity(one) >= REGULAR);
  if (candidates.length === 0) {
    const more = Array.from({ length: FURTHER }, (_, k) => STEPS.map((step) => 0.15 + 0.7 * ((0.5 + (k + 1) * step) % 1)));
    candidates = [...first, ...(await Promise.all(more.map((pattern) => tried(robot, pattern))))];
    candidates.sort((a, b) => regularity(b) - regularity(a)).splice(1);
  }
  const best = candidates.reduce((at, one) => (one.answer.manipulability > at.answer.manipulability ? one : at));
  const linear = mobile.filter((axis) => axis.length === 1);
  const angular = mobile.filter((axis) => axis.length === 2);
  const made = scenario(robot, best.posture, linear, angular);
  return press ? withApproach(pressing(made, press, mobile)) : made;
}

/** Adds to the description how fast the tool approaches the wall: without a stated speed, only the law knows. @type {(scenario: Scenario) => Promise<Scenario>} */
async function withApproach(scenario) {
  const joint_position = scenario.start_joint_position;
  const none = [0, 0, 0];
  const state = { sequence: 0, time_s: 0, joint_position, joint_velocity: joint_position.map(() => 0), wrench: { force: none, torque: none } };
  /** @type {import('./types.js').StepAnswer} */
  const { tasks } = await post('/v1/step', { controller: scenario.controller, state, memory: null });
  const speed = tasks[0].contact?.[0].approach_speed;
  if (!speed) return scenario;
  const approach = `It approaches at ${quantity(1000 * speed, 'mm/s', 2)} and needs about ${quantity(DISTANCE / speed, 's', 2)} to the wall.`;
  return { ...scenario, description: `${scenario.description} ${approach}` };
}

/** @typedef {{posture: number[], answer: KinematicsAnswer}} Tried */

/** @type {(robot: Robot, pattern: number[]) => Promise<Tried>} */
async function tried(robot, pattern) {
  const posture = robot.joints.map((joint, i) => within(joint, pattern[i % pattern.length]));
  return { posture, answer: await post('/v1/kinematics', { robot: robot.name, joint_position: posture }) };
}

/** Smallest singular value from which a posture is far enough from singularities: the default threshold of the damping. */
const REGULAR = 0.15;

/** @type {(joint: RobotJoint, part: number) => number} */
function within({ position_limit: range }, part) {
  const [low, high] = range ?? [-Math.PI, Math.PI];
  const middle = (low + high) / 2;
  const reach = Math.min(high - low, WIDEST);
  return Math.round((middle + (part - 0.5) * reach) * 1e4) / 1e4;
}

/**
 * @param {Robot} robot
 * @param {number[]} posture
 * @param {import('./types.js').Axis[]} linear axes along which the tool can move
 * @param {import('./types.js').Axis[]} angular axes about which it can turn
 * @returns {Scenario}
 */
function scenario(robot, posture, linear, angular) {
  /** @type {import('./types.js').ControllerTask[]} */
  const tasks = [];
  if (linear.length > 0) tasks.push({ name: 'position', axes: linear, law: { kind: 'pose', gain: 4 } });
  if (angular.length > 0) tasks.push({ name: 'orientation', axes: angular, law: { kind: 'pose', gain: 4 } });
  const hold = /** @type {const} */ ({ kind: 'constant', value: posture });
  tasks.push({ name: 'posture', law: { kind: 'posture', gain: 1, target_position: { ...hold, value: [...posture] } } });
  return /** @type {Scenario} */ ({
    name: 'playground',
    description: `${robot.name} at rest. Drag the target, reorder the tasks, and add planes.`,
    duration_s: DURATION,
    start_joint_position: posture,
    controller: {
      // Limits, drive and damping are the defaults of the service, as on a real arm.
      robot: robot.name, period_s: PERIOD, method: 'strict_reverse_priority', solver: 'auto', tasks,
    },
  });
}
