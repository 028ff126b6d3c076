// One sentence that says why tasks give way: which limits, planes or singularities hold them back, and by how much.

import { areDependent, residualParts } from './goals.js';
import { quantity } from './number.js';

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
  const causes = [...pairCauses(sample), ...limitCauses(view, sample), ...planeCauses(sample), ...singularCause(view, sample)];
  const losses = lossesOf(view, sample);
  if (losses.length === 0) {
    const text = causes.length > 0 ? `${joined(causes)}; every task is achieved.` : 'Every task is achieved; no limit is active.';
    return { text: capital(text), kind: 'ok' };
  }
  const why = causes.length > 0 ? joined(causes) : 'the tasks are in conflict';
  return { text: capital(`${why}; ${joined(losses)}.`), kind: 'limited' };
}

/** @type {(view: View, sample: LiveSample) => string[]} */
function limitCauses({ robot, labels }, sample) {
  const at = (/** @type {number} */ joint, /** @type {'lower' | 'upper'} */ side) => {
    const limits = robot?.joints[joint];
    return limits ? `${labels[joint]} ${cause(limits, sample, joint, side)}` : '';
  };
  const lower = sample.at_lower.map((joint) => at(joint, 'lower'));
  return [...lower, ...sample.at_upper.map((joint) => at(joint, 'upper'))].filter(Boolean);
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

/** @type {(sample: LiveSample) => string[]} */
function planeCauses({ active_inequalities: names }) {
  const others = names.filter((name) => !name.startsWith(PAIR));
  return others.map((name) => (name.startsWith('plane') ? `${name} holds the arm back` : `“${name}” is active`));
}

/** @type {(view: View, sample: LiveSample) => string[]} */
function singularCause({ threshold, controller, robot }, { smallest_singular_value: sigma }) {
  // Tasks that ask for several velocities in one direction are singular in every posture.
  if (!controller || areDependent(controller, robot?.joints.length ?? 0)) return [];
  const isDamped = threshold !== null && sigma < threshold;
  return isDamped ? [`the arm is near a singularity (σ = ${quantity(sigma, '', 2).trim()})`] : [];
}

/** Returns what each task gives up. @type {(view: View, sample: LiveSample) => string[]} */
function lossesOf({ controller }, sample) {
  return (controller?.tasks ?? []).flatMap((task, k) => {
    if ((sample.residual_norms[k] ?? 0) < MIN_GIVEN_UP) return [];
    const { linear, angular } = residualParts(task, sample.task_residuals[k] ?? []);
    const parts = [
      linear >= MIN_GIVEN_UP ? quantity(linear, 'm/s', 2) : '',
      angular >= MIN_GIVEN_UP ? quantity(angular, 'rad/s', 2) : '',
    ].filter(Boolean);
    return parts.length > 0 ? [{ name: `task ${k + 1} “${task.name}”`, amount: parts.join(' and ') }] : [];
  }).map(({ name, amount }, i) => `${name}${i === 0 ? ' gives up' : ':'} ${amount}`);
}

/** @type {(parts: string[]) => string} */
function joined(parts) {
  if (parts.length > MAX_PARTS) return `${parts.slice(0, MAX_PARTS).join(', ')} and ${parts.length - MAX_PARTS} more`;
  return parts.length > 1 ? `${parts.slice(0, -1).join(', ')} and ${parts.at(-1)}` : parts[0];
}

/** @type {(text: string) => string} */
const capital = (text) => text.charAt(0).toUpperCase() + text.slice(1);
