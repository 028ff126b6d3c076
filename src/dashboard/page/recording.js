// A recording of an arm as a ghost: its posture, its tool and its target at any time.

import { MAX_BYTES, TARGETS, jointColumns, listed, numberOf, readTable, textOf } from './recording_file.js';

/**
 * @typedef {import('./kinematics.js').Kinematics} Kinematics
 * @typedef {import('./recording_file.js').Table} Table
 * @typedef {import('./types.js').Robot} Robot
 * @typedef {import('./types.js').Vec3} Vec3
 *
 * @typedef {object} Path places of a tool over time; the interface of `History` that paths and plots use
 * @property {Record<string, Float64Array>} columns
 * @property {number} length
 * @property {(time: number) => number} indexAt
 */

/** Largest position of a joint that is accepted, rad or m. */
const LARGEST = 1000;

/** Largest number of points of a path. */
const PATH_POINTS = 2000;

/** Distance beyond the range of a joint above which the numbers look like degrees, rad. */
const FAR = 7;

let made = 0;

export class Recording {
  /** @param {string} name @param {Robot} robot @param {number[]} times s, from 0 @param {number[][]} positions rad or m @param {Vec3[] | null} targets m */
  constructor(name, robot, times, positions, targets) {
    made += 1;
    this.id = `recording:${made}`;
    this.name = name;
    this.robot = robot.name;
    this.times = times;
    this.positions = positions;
    this.targets = targets;
    /** Joints that go so far beyond their range that the numbers may be degrees. */
    this.suspicious = robot.joints.filter(({ kind, position_limit: range }, joint) =>
      kind === 'revolute' && positions.some((row) => Math.abs(row[joint]) > FAR + Math.max(...(range ?? [0, 0]).map(Math.abs)))).map(({ name: joint }) => joint);
    /** @type {{kinematics: Kinematics, path: Path} | null} */
    this.known = null;
  }

  /** Returns its last time, s. */
  get duration() {
    return this.times[this.times.length - 1];
  }

  /** Returns the posture at a time, rad or m; the first and the last one before and after the recording. @param {number} time s */
  positionAt(time) {
    return between(this.times, this.positions, time);
  }

  /** Returns the target of the tool at a time, m; null if the recording has none. @type {(time: number) => Vec3 | null} */
  targetAt(time) {
    return this.targets && /** @type {Vec3} */ (between(this.times, this.targets, time));
  }

  /** Returns the path of the tool, with its distance from the target of the recording as `linear0`. @type {(kinematics: Kinematics) => Path} */
  path(kinematics) {
    if (this.known?.kinematics !== kinematics) this.known = { kinematics, path: pathOf(this, kinematics) };
    return this.known.path;
  }
}

/** @type {(recording: Recording, kinematics: Kinematics) => Path} */
function pathOf(recording, kinematics) {
  const step = Math.ceil(recording.times.length / PATH_POINTS);
  const isKept = (/** @type {unknown} */ _, /** @type {number} */ row) => row % step === 0;
  const [times, positions, targets] = [recording.times.filter(isKept), recording.positions.filter(isKept), recording.targets?.filter(isKept)];
  const tools = positions.map((position) => kinematics.tool(kinematics.frames(position)).position);
  const [x, y, z] = [0, 1, 2].map((axis) => Float64Array.from(tools, (tool) => tool[axis]));
  const away = targets ? tools.map((tool, row) => Math.hypot(...tool.map((value, axis) => value - targets[row][axis]))) : [];
  return {
    columns: { time: Float64Array.from(times), x, y, z, ...(targets && { linear0: Float64Array.from(away) }) },
    length: times.length,
    indexAt: (time) => indexAt(times, time),
  };
}

/** Returns the index of the last time at or before a time; −1 if there is none. @type {(times: number[], time: number) => number} */
function indexAt(times, time) {
  let [low, high] = [0, times.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle] <= time) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}

/** @type {(times: number[], rows: number[][], time: number) => number[]} */
function between(times, rows, time) {
  const before = indexAt(times, time);
  if (before < 0) return rows[0];
  const after = rows[before + 1];
  if (!after) return rows[before];
  const part = (time - times[before]) / (times[before + 1] - times[before]);
  return rows[before].map((value, i) => value + part * (after[i] - value));
}

/**
 * Reads a recording. It belongs to the first of the robots that has its joints.
 * @param {File} file
 * @param {Robot[]} robots the shown one first
 */
export async function readRecording(file, robots) {
  if (file.size > MAX_BYTES) throw new Error(`${file.name} has ${Math.round(file.size / 1e6)} MB; recordings up to ${MAX_BYTES / 1e6} MB are read, so leave out columns or rows`);
  const table = readTable(file.name, textOf(await file.arrayBuffer()));
  const { robot, columns } = robotOf(file.name, table, robots);
  const start = table.times[0];
  const positions = table.times.map((_, row) => columns.map((column, joint) => {
    const value = numberOf(table.cell(column, row));
    if (Math.abs(value) <= LARGEST) return value;
    throw new Error(`${file.name}, ${table.place(row)}: joint ${robot.joints[joint].name} is at “${table.cell(column, row) ?? ''}”, which is no position in rad or m`);
  }));
  const name = file.name.replace(/\.(csv|json|jsonl|txt)$/i, '').slice(0, 60);
  return new Recording(name, robot, table.times.map((time) => time - start), positions, targetsOf(table, columns.length));
}

/** @type {(file: string, table: Table, robots: Robot[]) => {robot: Robot, columns: number[]}} */
function robotOf(file, { names, joints }, robots) {
  if (names.length === 0) {
    const [robot] = robots;
    if (robot.joints.length === joints) return { robot, columns: robot.joints.map((_, joint) => joint) };
    throw new Error(`${file} names no joints, and has ${joints} of them; ${robot.name} has ${robot.joints.length}. Choose its robot first, or add joint_names`);
  }
  for (const robot of robots) {
    const columns = jointColumns(names, robot.joints.map((joint) => joint.name));
    if (columns) return { robot, columns };
  }
  const wanted = robots[0]?.joints.map((joint) => joint.name) ?? [];
  throw new Error(`${file}: no robot has joints with the names of its columns ${listed(names)}. ${robots[0]?.name} needs ${listed(wanted)}`);
}

/** Returns the targets of the tool; null if a number is missing. @type {(table: Table, joints: number) => Vec3[] | null} */
function targetsOf({ names, times, cell }, joints) {
  const columns = names.length > 0 ? TARGETS.map((name) => names.indexOf(name)) : TARGETS.map((_, i) => joints + i);
  if (columns.includes(-1)) return null;
  const targets = times.map((_, row) => /** @type {Vec3} */ (columns.map((column) => numberOf(cell(column, row)))));
  return targets.every((target) => target.every((value) => Math.abs(value) <= LARGEST)) ? targets : null;
}
