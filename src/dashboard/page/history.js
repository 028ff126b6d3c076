// The samples of a run, stored as one array per quantity for fast drawing, with postures and marks.

import { toolPose } from './measures.js';

/**
 * @typedef {import('./types.js').ArmView} ArmView
 * @typedef {import('./types.js').LiveSample} LiveSample
 * @typedef {import('./types.js').Pose} Pose
 * @typedef {import('./measures.js').Measures} Measures
 * @typedef {{time: number, text: string}} Mark a change by the user, at a time in s
 *
 * @typedef {object} Segment a part of the history with one scenario
 * @property {number} from its first time, s
 * @property {import('./types.js').Scenario} scenario
 * @property {Measures | null} measures
 * @property {number[]} order column of each task
 * @property {Pose | null} start pose of the tool at its first time; null: that of the first sample
 */

/** Maximum number of samples. When it is reached, every second sample is removed. */
const CAPACITY = 8192;

/** Maximum number of latest samples that are kept without gaps. */
const RECENT = 256;

/** Maximum number of tasks whose residuals are stored. */
export const MAX_TASKS = 6;

/** Names of the solver paths; the column `path` has their index. */
export const PATHS = /** @type {const} */ (['closed_form', 'active_set', 'qp']);

const NAMES = [
  'time', 'x', 'y', 'z', 'force0', 'force1', 'force2', 'target0', 'target1', 'target2', 'error0', 'error1', 'error2',
  'sigma', 'roundTrip', 'solve', 'path', 'lower', 'upper',
  ...Array.from({ length: MAX_TASKS }, (_, k) => [`residual${k}`, `linear${k}`, `angular${k}`]).flat(),
];

export class History {
  /** @param {Measures | null} measures computes forces and pose errors from the samples */
  constructor(measures = null) {
    this.measures = measures;
    this.length = 0;
    /** @type {LiveSample | undefined} */
    this.last = undefined;
    /** @type {Pose | undefined} pose of the tool in the first sample */
    this.start = undefined;
    /** @type {Record<string, Float64Array>} */
    this.columns = {};
    for (const name of NAMES) this.columns[name] = new Float64Array(CAPACITY);
    /** The latest samples, without gaps. @type {LiveSample[]} */
    this.recent = [];
    /** The stored samples; same indices as the columns. @type {LiveSample[]} */
    this.samples = [];
    /** @type {{time: number, arm: ArmView}[]} */
    this.arms = [];
    /** @type {Mark[]} */
    this.marks = [];
    this.tasks = 0;
    this.stride = 1;
    this.skipped = 0;
    /** The runs that this history continues, oldest first. @type {Segment[]} */
    this.segments = [];
    /** Time of the first sample of the current run, s; above 0 if the run continues another one. */
    this.offset = 0;
    /** Column of each task of the current run. @type {number[]} */
    this.order = [];
  }

  /** @param {LiveSample} given with the time of its own run */
  push(given) {
    const measured = this.measures?.of(given);
    const sample = this.offset > 0 ? later(given, this.offset) : given;
    this.last = sample;
    this.recent.push(sample);
    if (this.recent.length > RECENT) this.recent.splice(0, RECENT / 2);
    this.start ??= toolPose(sample);
    this.tasks = Math.min(sample.residual_norms.length, MAX_TASKS);
    this.skipped += 1;
    if (this.skipped < this.stride) return;
    this.skipped = 0;
    if (this.length === CAPACITY) this.halve();
    const at = this.length;
    const column = this.columns;
    this.samples[at] = sample;
    column.time[at] = sample.time_s;
    [column.x[at], column.y[at], column.z[at]] = sample.position;
    for (let axis = 0; axis < 3; axis += 1) {
      const force = measured?.force[axis] ?? sample.force[axis];
      const target = (measured ? measured.target : sample.target_force)[axis] ?? NaN;
      column[`force${axis}`][at] = force;
      column[`target${axis}`][at] = target;
      column[`error${axis}`][at] = force - target;
    }
    column.sigma[at] = this.measures?.singularValue(given) ?? sample.smallest_singular_value;
    column.roundTrip[at] = sample.round_trip_us;
    column.solve[at] = sample.solve_us;
    column.path[at] = PATHS.indexOf(sample.path);
    column.lower[at] = mask(sample.at_lower);
    column.upper[at] = mask(sample.at_upper);
    for (let k = 0; k < this.tasks; k += 1) {
      const place = this.order[k] ?? k;
      column[`residual${place}`][at] = sample.residual_norms[k];
      column[`linear${place}`][at] = measured?.errors[k]?.linear ?? NaN;
      column[`angular${place}`][at] = measured?.errors[k]?.angular ?? NaN;
    }
    this.length += 1;
  }

  /** Begins a part with another scenario. @type {(scenario: import('./types.js').Scenario, measures: Measures | null, order: number[]) => void} */
  begin(scenario, measures, order) {
    this.measures = measures;
    this.offset = this.now;
    this.order = order;
    this.segments.push({ from: this.now, scenario, measures, order, start: this.last ? toolPose(this.last) : null });
  }

  /** Returns the part at a time; the latest one for null. @type {(time: number | null) => Segment | undefined} */
  segmentAt(time) {
    if (time === null) return this.segments.at(-1);
    return this.segments.findLast(({ from }) => from <= time) ?? this.segments[0];
  }

  /** Removes every second sample. Limits that were active in it are added to its neighbour. */
  halve() {
    const half = CAPACITY / 2;
    for (const name of NAMES) {
      const column = this.columns[name];
      const isMask = name === 'lower' || name === 'upper';
      for (let i = 0; i < half; i += 1) column[i] = isMask ? column[2 * i] | column[2 * i + 1] : column[2 * i + 1];
    }
    this.samples = this.samples.filter((_, i) => i % 2 === 1);
    this.length = half;
    this.stride *= 2;
  }

  /** @type {(time: number, arm: ArmView) => void} stores the posture of a sample; `time` is that of its own run, s */
  pushArm(time, arm) {
    this.arms.push({ time: time + this.offset, arm });
    if (this.arms.length > CAPACITY) this.arms = this.arms.filter((_, i) => i % 2 === 1);
  }

  /** @type {(text: string) => void} marks the present time */
  mark(text) {
    this.marks.push({ time: this.now, text });
  }

  /** Returns the time of the latest sample, s. */
  get now() {
    return this.last?.time_s ?? 0;
  }

  /** Time at which the shown past begins, s: that of the first sample of a session of others. */
  get first() {
    return this.length > 0 && this.measures?.knowsStart === false ? this.columns.time[0] : 0;
  }

  /** Returns the index of the last sample at or before a time; −1 if there is none. @type {(time: number) => number} */
  indexAt(time) {
    let [low, high] = [0, this.length];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.columns.time[middle] <= time) low = middle + 1;
      else high = middle;
    }
    return low - 1;
  }

  /** Returns the posture nearest to a time, with its time. @type {(time: number) => {time: number, arm: ArmView} | undefined} */
  armAt(time) {
    const next = this.arms.findIndex((entry) => entry.time >= time);
    if (next < 0) return this.arms.at(-1);
    const [before, after] = [this.arms[next - 1], this.arms[next]];
    return before && time - before.time < after.time - time ? before : after;
  }

  /**
   * Returns whether the last sample has a desired force in a direction.
   * @param {number} axis
   */
  hasTarget(axis) {
    return this.length > 0 && !Number.isNaN(this.columns[`target${axis}`][this.length - 1]);
  }
}

/** Returns the bit of a joint in a mask; 0 where it has none. @type {(joint: number) => number} */
export const bitOf = (joint) => (joint < 32 ? 1 << joint : 0);

/** Returns a sample on the clock of the page, which goes on where runs continue; `why` names times too. @type {(given: LiveSample, offset: number) => LiveSample} */
function later(given, offset) {
  const shifted = (/** @type {string} */ text) => text.replace(/\bt = ([\d.]+) s/g, (_, time) => `t = ${(Number(time) + offset).toFixed(4)} s`);
  return { ...given, time_s: given.time_s + offset, ...(given.why && { why: given.why.map(shifted) }) };
}

/** Returns the first 32 joint indices as a bit mask. Others are not shown. @param {number[]} joints */
function mask(joints) {
  return joints.reduce((bits, joint) => bits | bitOf(joint), 0);
}
