// The sentence that says why tasks give way: the `why` of the answers, and what they do not know while the arm rests.

import { residualParts } from './goals.js';
import { angle, distance, quantity } from './number.js';
import { state } from './state.js';

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

/** Maximum number of causes in the sentence. */
const MAX_PARTS = 3;

/** Time over which causes are collected, s: near a bound they change from period to period. */
const RECENT = 0.25;

/** What `why` says at its end: what the tasks give up, or that they give up nothing. */
const END = /^(task `.*` (gives up|moves in its direction|approaches its surface|has lost its surface|has given its contact up)|no limit is active|every task )/;

/** What `why` says of a single period, of which the page collects nothing. */
const CONFLICT = 'the tasks are in conflict';

/** @type {(view: View) => Reason} */
export function reason(view) {
  const { sample } = view;
  if (!sample) {
    const isSession = state.value.source === 'session';
    const text = isSession ? 'A live session shows what a client does with its arm. Choose one under Setup.' : 'Run shows which tasks are achieved, and what holds the others back.';
    return { text, kind: 'none' };
  }
  const losses = lossesOf(view, sample);
  const presses = (sample.contacts ?? []).every(({ state }) => state === 'contact');
  const kind = (losses.length > 0 && !isOrdinary(view, losses)) || !presses ? 'limited' : 'ok';
  const parts = sample.why ? sentences(view, sample, losses) : [...losses.map(({ text }) => text), 'the controller says no more without `why`'];
  return { text: capital(`${parts.join('; ')}.`).replace(/`([^`]*)`/g, '“$1”'), kind };
}

/** Returns the causes, and what the tasks give up. @type {(view: View, sample: LiveSample, losses: Loss[]) => string[]} */
function sentences(view, sample, losses) {
  const rest = rests(sample);
  const causes = [...causesOf(view, sample), ...(rest ? planesAt(view.controller, sample) : [])];
  const held = causes.length > MAX_PARTS ? [...causes.slice(0, MAX_PARTS - 1), `${causes.length - MAX_PARTS + 1} more limits are active`] : causes;
  const left = losses.filter(({ isDistance }) => isDistance);
  if (left.length > 0) return [...(held.length > 0 ? held : ['the arm rests']), ...left.map(({ text }) => text)];
  const said = sample.why ?? [];
  const conflict = said.filter((text) => text === CONFLICT && held.length === 0);
  const end = said.filter((text) => END.test(text)).map((text) => (held.length > 0 ? text.replace('no limit is active; ', '') : text));
  return [...held, ...conflict, ...end];
}

/** Returns what `why` said shortly before and says now, each limit with its latest numbers. @type {(view: View, sample: LiveSample) => string[]} */
function causesOf({ history }, sample) {
  /** @type {Map<string, string>} */
  const causes = new Map();
  const collect = (/** @type {LiveSample} */ { why = [] }) => {
    for (const text of why) {
      const subject = /^(joint `[^`]*`)/.exec(text)?.[1] ?? withoutNumbers(text);
      if (!END.test(text) && text !== CONFLICT && !causes.has(subject)) causes.set(subject, text);
    }
  };
  collect(sample);
  for (let i = history.indexAt(sample.time_s); i >= 0 && history.columns.time[i] > sample.time_s - RECENT; i -= 1) collect(history.samples[i]);
  return [...causes.values()].sort();
}

/** Returns a text that stays the same while its numbers change; names keep theirs. @type {(text: string) => string} */
function withoutNumbers(text) {
  return text.replace(/`[^`]*`|\d[\d.]*(e[-+]?\d+)?/g, (part) => (part.startsWith('`') ? part : '#'));
}

/** Returns whether only the lowest task gives way, and that task is a posture: a redundant arm that moves does so all the time. @type {(view: View, losses: Loss[]) => boolean} */
function isOrdinary({ controller }, losses) {
  const tasks = controller?.tasks ?? [];
  return losses.length === 1 && losses[0].task === tasks.length - 1 && tasks.length > 1 && tasks.at(-1)?.law?.kind === 'posture';
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

/** Returns the planes that the tool has reached. They are not active once the arm rests and its requests have faded. @type {(controller: View['controller'], sample: LiveSample) => string[]} */
function planesAt(controller, { position: tool }) {
  return (controller?.inequalities ?? []).flatMap((inequality) => {
    // Where other points are, a sample does not say.
    if (inequality.kind !== 'plane' || (inequality.point ?? 'tool') !== 'tool') return [];
    const { normal, offset_m: offset, name } = inequality;
    const along = normal.reduce((sum, part, i) => sum + part * tool[i], 0) / Math.hypot(...normal);
    return along > offset - AT_PLANE ? [`inequality \`${name ?? 'plane'}\` is at its bound`] : [];
  });
}

/** Returns whether the arm rests. @type {(sample: LiveSample) => boolean} */
export const rests = ({ joint_velocity: speeds }) => speeds.every((speed) => Math.abs(speed) < RESTING);

/** @typedef {{task: number, text: string, isDistance: boolean}} Loss `isDistance`: how far the task is from its target */

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
    return [{ task: k, isDistance: away !== '', text: `task \`${task.name}\` ${away ? `stays ${away} from its target` : `gives up ${parts.join(' and ')}`}` }];
  });
}

/** Returns how far a task is from its target; empty if that is not known. @type {(view: View, k: number) => string} */
function distanceLeft({ history, sample, order }, k) {
  const place = order[k] ?? k;
  const index = history.indexAt(sample?.time_s ?? 0);
  const [linear, angular] = [history.columns[`linear${place}`]?.[index], history.columns[`angular${place}`]?.[index]];
  return [linear >= 0 ? distance(linear) : '', angular >= 0 ? angle(angular) : ''].filter(Boolean).join(' and ');
}

/** @type {(text: string) => string} */
const capital = (text) => text.charAt(0).toUpperCase() + text.slice(1);
