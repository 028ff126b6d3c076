// The samples of a run, stored as one array per quantity for fast drawing.

/** @typedef {import('./types.js').LiveSample} LiveSample */

/** Maximum number of samples. When it is reached, every second sample is removed. */
const CAPACITY = 8192;

/** Maximum number of tasks whose residuals are stored. */
export const MAX_TASKS = 6;

/** Names of the solver paths; the column `path` has their index. */
export const PATHS = /** @type {const} */ (['closed_form', 'active_set', 'qp']);

const NAMES = [
  'time', 'x', 'y', 'z', 'force0', 'force1', 'force2', 'target0', 'target1', 'target2', 'error0', 'error1', 'error2',
  'sigma', 'roundTrip', 'solve', 'path', 'lower', 'upper',
  ...Array.from({ length: MAX_TASKS }, (_, k) => `residual${k}`),
];

export class History {
  constructor() {
    this.length = 0;
    /** @type {LiveSample | undefined} */
    this.last = undefined;
    /** @type {number[] | undefined} position of the tool in the first sample, m */
    this.start = undefined;
    /** @type {Record<string, Float64Array>} */
    this.columns = {};
    for (const name of NAMES) this.columns[name] = new Float64Array(CAPACITY);
    this.tasks = 0;
    this.stride = 1;
    this.skipped = 0;
  }

  /** @param {LiveSample} sample */
  push(sample) {
    this.last = sample;
    this.start ??= sample.position;
    this.tasks = Math.min(sample.residual_norms.length, MAX_TASKS);
    this.skipped += 1;
    if (this.skipped < this.stride) return;
    this.skipped = 0;
    if (this.length === CAPACITY) this.halve();
    const at = this.length;
    const column = this.columns;
    column.time[at] = sample.time_s;
    column.x[at] = sample.position[0];
    column.y[at] = sample.position[1];
    column.z[at] = sample.position[2];
    for (let axis = 0; axis < 3; axis += 1) {
      const target = sample.target_force[axis] ?? NaN;
      column[`force${axis}`][at] = sample.force[axis];
      column[`target${axis}`][at] = target;
      column[`error${axis}`][at] = sample.force[axis] - target;
    }
    column.sigma[at] = sample.smallest_singular_value;
    column.roundTrip[at] = sample.round_trip_us;
    column.solve[at] = sample.solve_us;
    column.path[at] = PATHS.indexOf(sample.path);
    column.lower[at] = mask(sample.at_lower);
    column.upper[at] = mask(sample.at_upper);
    for (let k = 0; k < this.tasks; k += 1) column[`residual${k}`][at] = sample.residual_norms[k];
    this.length += 1;
  }

  /** Removes every second sample. Limits that were active in it are added to its neighbour. */
  halve() {
    const half = CAPACITY / 2;
    for (const name of NAMES) {
      const column = this.columns[name];
      const isMask = name === 'lower' || name === 'upper';
      for (let i = 0; i < half; i += 1) column[i] = isMask ? column[2 * i] | column[2 * i + 1] : column[2 * i + 1];
    }
    this.length = half;
    this.stride *= 2;
  }

  /** Returns the time of the latest sample, s. */
  get now() {
    return this.length > 0 ? this.columns.time[this.length - 1] : 0;
  }

  /**
   * Returns whether the last sample has a desired force along an axis.
   * @param {number} axis
   */
  hasTarget(axis) {
    return this.length > 0 && !Number.isNaN(this.columns[`target${axis}`][this.length - 1]);
  }
}

/** Returns joint indices as a bit mask; bit 30 stands for index 30 and above. @param {number[]} joints */
function mask(joints) {
  return joints.reduce((bits, joint) => bits | (1 << Math.min(joint, 30)), 0);
}
