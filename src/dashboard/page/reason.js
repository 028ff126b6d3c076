// One sentence that says why tasks give way: which limits, planes or singularities hold them back, and by how much.

import { residualParts } from './goals.js';
import { angle, distance, quantity } from './number.js';

/**
 * @typedef {import('./view.js').View} View
 * @typedef {import('./types.js').LiveSample} LiveSample
 * @typedef {import('./types.js').RobotJoint} RobotJoint
 *
 * @typedef {{text: string, kind: 'none' | 'ok' | 'limited'}} Reason
 */

/** Distance to the end of a joint's range below which the joint is at its limit, rad or m. */
const AT_RANGE = 0.02;

/** Part of the maximum speed from which a joint is at its speed limit. */
const AT_SPEED = 0.98;

/** Smallest velocity that a task gives up, m/s or rad/s. */
const MIN_GIVEN_UP = 1e-4;

/** Distance of the tool from a plane at which it has reached it, m. */
const AT_PLANE = 0.005;

/** Speed of all joints below which the arm rests, rad/s or m/s. */
const RESTING = 2e-3;

/** Maximum number of causes and of tasks in the sentence. */
const MAX_PARTS = 3;

/** Time over which active limits and planes are collected, s: near a bound they change from period to period. */
const RECENT = 0.25;

/** Returns the shown sample with everything that was active shortly before. @type {(view: View) => LiveSample | undefined} */
function recent({ history, sample }) {
  if (!sample) return undefined;
  const [lower, upper, names] = [new Set(sample.at_lower), new Set(sample.at_upper), new Set(sample.active_inequalities)];
  for (let i = history.indexAt(sample.time_s); i >= 0 && history.columns.time[i] > sample.time_s - RECENT; i -= 1) {
    const before = history.samples[i];
    before.at_lower.forEach((joint) => lower.add(joint));
    before.at_upper.forEach((joint) => upper.add(joint));
    before.active_inequalities.forEach((name) => names.add(name));
  }
  const sorted = (/** @type {Set<number>} */ joints) => [...joints].sort((a, b) => a - b);
  return { ...sample, at_lower: sorted(lower), at_upper: sorted(upper), active_inequalities: [...names] };
}

/** @type {(view: View) => Reason} */
export function reason(view) {
  const sample = recent(view);
  if (!sample) return { text: 'Run shows which tasks are achieved, and what holds the others back.', kind: 'none' };
  const causes = [...pairCauses(sample), ...limitCauses(view, sample), ...planeCauses(view, sample), ...singularCause(view)];
  const losses = lossesOf(view, sample);
  if (sample.why) return { text: capital(`${sample.why.join('; ')}.`), kind: losses.length > 0 && !isOrdinary(view, losses) ? 'limited' : 'ok' };
  if (losses.length === 0) {
    const text = causes.length > 0 ? `${joined(causes)}; every task is achieved.` : 'Every task is achieved; no limit is active.';
    return { text: capital(text), kind: 'ok' };
  }
  const lost = losses.map(({ name, amount }, i) => `${name}${amount.startsWith('stays') ? ' ' : i === 0 ? ' gives up ' : ': '}${amount}`);
  if (isOrdinary(view, losses)) {
    const held = causes.length > 0 ? `${joined(causes)}; ` : '';
    return { text: capital(`${held}every task above is achieved; ${joined(lost)}, since it has the motion that is left.`), kind: 'ok' };
  }
  const why = causes.length > 0 ? joined(causes) : rests(sample) ? 'the arm rests' : 'the tasks are in conflict';
  return { text: capital(`${why}; ${joined(lost)}.`), kind: 'limited' };
}

/** Returns whether only the lowest task gives way, and that task is a posture: a redundant arm that moves does so all the time. @type {(view: View, losses: Loss[]) => boolean} */
function isOrdinary({ controller }, losses) {
  const tasks = controller?.tasks ?? [];
  return losses.length === 1 && losses[0].task === tasks.length - 1 && tasks.length > 1 && tasks.at(-1)?.law?.kind === 'posture';
}

/** Returns the limits that are active, each joint once. @type {(view: View, sample: LiveSample) => string[]} */
function limitCauses(view, sample) {
  return activeLimits(view, sample).map(({ label, text }) => `${label} ${text}`);
}

/**
 * @typedef {object} ActiveLimit
 * @property {number} joint
 * @property {string} label
 * @property {string} text what it is at
 * @property {('lower' | 'upper')[]} sides
 */

/** Returns the limits that are active in a sample, each joint once. @type {(view: Pick<View, 'robot' | 'labels'>, sample: LiveSample) => ActiveLimit[]} */
export function activeLimits({ robot, labels }, sample) {
  /** @type {Map<number, ('lower' | 'upper')[]>} */
  const sides = new Map();
  for (const side of /** @type {const} */ (['lower', 'upper'])) {
    for (const joint of side === 'lower' ? sample.at_lower : sample.at_upper) sides.set(joint, [...(sides.get(joint) ?? []), side]);
  }
  return [...sides].sort(([a], [b]) => a - b).flatMap(([joint, of]) => {
    const limits = robot?.joints[joint];
    if (!limits) return [];
    const texts = of.map((side) => cause(limits, sample, joint, side));
    const text = texts.find((known) => !known.endsWith('velocity bound')) ?? (of.length > 1 ? 'is at its velocity bounds' : texts[0]);
    return [{ joint, label: labels[joint], text, sides: of }];
  });
}

/** @type {(limits: RobotJoint, sample: LiveSample, joint: number, side: 'lower' | 'upper') => string} */
function cause({ position_limit: range, velocity_limit: fastest }, sample, joint, side) {
  const [q, speed] = [sample.joint_position[joint], Math.abs(sample.joint_velocity[joint])];
  if (range) {
    const left = side === 'lower' ? q - range[0] : range[1] - q;
    if (left < AT_RANGE) return `is at its ${side} limit`;
  }
  if (typeof fastest === 'number' && speed >= AT_SPEED * fastest) return 'is at its speed limit';
  return `is at its ${side} velocity bound`;
}

/** Beginning of the name of an inequality that keeps a pair of shapes clear of each other. */
const PAIR = 'collision:';

/** @type {(sample: LiveSample) => string[]} */
function pairCauses({ active_inequalities: names }) {
  return names.filter((name) => name.startsWith(PAIR)).map((name) => name.slice(PAIR.length).replace('/', ' keeps clear of '));
}

/** @type {(view: View, sample: LiveSample) => string[]} */
function planeCauses({ controller }, sample) {
  const reached = rests(sample) ? planesAt(controller, sample) : [];
  const others = new Set([...sample.active_inequalities.filter((name) => !name.startsWith(PAIR)), ...reached]);
  return [...others].map((name) => (name.startsWith('plane') ? `${name} holds the arm back` : `“${name}” is active`));
}

/** Returns the planes that the tool has reached. They are not active once the arm rests and its requests have faded. @type {(controller: View['controller'], sample: LiveSample) => string[]} */
function planesAt(controller, { position: tool }) {
  return (controller?.inequalities ?? []).flatMap((inequality) => {
    if (inequality.kind !== 'plane') return [];
    const { normal, offset_m: offset, name } = inequality;
    const along = normal.reduce((sum, part, i) => sum + part * tool[i], 0) / Math.hypot(...normal);
    return along > offset - AT_PLANE ? [name ?? 'a plane'] : [];
  });
}

/** @type {(view: View) => string[]} */
function singularCause({ threshold, controller, sigma, history }) {
  const { measures } = history;
  if (!controller || sigma === undefined || (measures?.isDependent && !measures.kinematics)) return [];
  const isDamped = threshold !== null && sigma < threshold;
  return isDamped ? [`the arm is near a singularity (σ = ${quantity(sigma, '', 2).trim()})`] : [];
}

/** Returns whether the arm rests. @type {(sample: LiveSample) => boolean} */
export const rests = ({ joint_velocity: speeds }) => speeds.every((speed) => Math.abs(speed) < RESTING);

/** @typedef {{task: number, name: string, amount: string}} Loss */

/** Returns what each task gives up; while the arm rests, how far it stays from its target. @type {(view: View, sample: LiveSample) => Loss[]} */
function lossesOf(view, sample) {
  return (view.controller?.tasks ?? []).flatMap((task, k) => {
    if ((sample.residual_norms[k] ?? 0) < MIN_GIVEN_UP) return [];
    const { linear, angular } = residualParts(task, sample.task_residuals[k] ?? []);
    const parts = [
      linear >= MIN_GIVEN_UP ? quantity(linear, 'm/s', 2) : '',
      angular >= MIN_GIVEN_UP ? quantity(angular, 'rad/s', 2) : '',
    ].filter(Boolean);
    if (parts.length === 0) return [];
    const away = rests(sample) ? distanceLeft(view, k) : '';
    return [{ task: k, name: `task ${k + 1} “${task.name}”`, amount: away ? `stays ${away} from its target` : parts.join(' and ') }];
  });
}

/** Returns how far a task is from its target; empty if that is not known. @type {(view: View, k: number) => string} */
function distanceLeft({ history, sample, order }, k) {
  const place = order[k] ?? k;
  const index = history.indexAt(sample?.time_s ?? 0);
  const [linear, angular] = [history.columns[`linear${place}`]?.[index], history.columns[`angular${place}`]?.[index]];
  return [linear >= 0 ? distance(linear) : '', angular >= 0 ? angle(angular) : ''].filter(Boolean).join(' and ');
}

/** @type {(parts: string[]) => string} */
function joined(parts) {
  if (parts.length > MAX_PARTS) return `${parts.slice(0, MAX_PARTS).join(', ')} and ${parts.length - MAX_PARTS} more`;
  return parts.length > 1 ? `${parts.slice(0, -1).join(', ')} and ${parts.at(-1)}` : parts[0];
}

/** @type {(text: string) => string} */
const capital = (text) => text.charAt(0).toUpperCase() + text.slice(1);
