// The plots. Each is a function that draws one plot from the view.

import { History, PATHS } from './history.js';
import { atX, atY, axes, bounds, curve, FONT, hint, level, line } from './plot.js';

/**
 * @typedef {import('./theme.js').Palette} Palette
 * @typedef {import('./plot.js').Surface} Surface
 * @typedef {import('./plot.js').Frame} Frame
 * @typedef {import('./types.js').ArmView} ArmView
 * @typedef {import('./types.js').Robot} Robot
 * @typedef {import('./types.js').TimeHistogram} TimeHistogram
 * @typedef {import('./types.js').PathCounts} PathCounts
 *
 * @typedef {object} View data of all plots
 * @property {History} history
 * @property {History | null} ghost
 * @property {number} duration of the run, s; 0 if it has no end
 * @property {ArmView | null} arm
 * @property {Robot | null} robot
 * @property {number[]} position q, rad or m
 * @property {number[]} velocity q̇, rad/s or m/s
 * @property {string[]} tasks names, highest priority first
 * @property {number | null} threshold δ of the damping
 * @property {number} period T, s
 * @property {PathCounts | null} paths
 * @property {TimeHistogram | null} solveTime
 * @property {boolean} closeUp whether the force axis is zoomed to the desired force
 *
 * @typedef {(surface: Surface, width: number, height: number, view: View, colours: Palette) => void} Draw
 */

const LEFT = 44;
const RIGHT = 12;
const BOTTOM = 20;

/** Length of the time axis for a run without end, s. */
const WINDOW = 20;

/** @type {(view: View) => {low: number, high: number}} */
function timeRange({ history, duration }) {
  if (duration > 0) return { low: 0, high: duration };
  return { low: Math.max(0, history.now - WINDOW), high: Math.max(WINDOW, history.now) };
}

/** @type {(width: number, height: number, view: View, y: import('./plot.js').Range, top?: number, bottom?: number) => Frame} */
function timeFrame(width, height, view, y, top = 8, bottom = BOTTOM) {
  return { left: LEFT, top, width: width - LEFT - RIGHT, height: height - top - bottom, x: timeRange(view), y };
}

/** Returns the axes with a desired force; without any, those whose measured force changes; otherwise x. @type {(view: View) => number[]} */
export function forceAxes({ history }) {
  const withTarget = [0, 1, 2].filter((axis) => history.hasTarget(axis));
  if (withTarget.length > 0) return withTarget;
  const changing = [0, 1, 2].filter((axis) => {
    const { low, high } = bounds([history.columns[`force${axis}`]], history.length);
    return high - low > 1e-9;
  });
  return changing.length > 0 ? changing : [0];
}

/** @type {Draw} */
export function force(surface, width, height, view, colours) {
  const { history, ghost } = view;
  const shown = forceAxes(view);
  const column = (/** @type {string} */ name) => shown.map((axis) => history.columns[`${name}${axis}`]);
  const below = Math.round(0.3 * height);
  const frame = timeFrame(width, height, view, forceRange(view, shown), 8, below + 26);
  axes(surface, frame, colours, { x: false });
  for (const axis of shown) {
    const [columns, colour] = [history.columns, colours.axes[axis]];
    if (ghost) {
      const style = { colour: colours.ghost, width: 1.4, dash: [5, 3] };
      curve(surface, frame, ghost.columns.time, ghost.columns[`force${axis}`], ghost.length, style);
    }
    curve(surface, frame, columns.time, columns[`force${axis}`], history.length, { colour, width: 1.8 });
    const target = { colour: colours.text, width: 1.3, dash: [2, 3] };
    curve(surface, frame, columns.time, columns[`target${axis}`], history.length, target);
  }
  const errors = bounds(column('error'), history.length);
  const limit = roundUp(view.closeUp ? 10 : Math.max(1, Math.abs(errors.low), Math.abs(errors.high)));
  const strip = timeFrame(width, height, view, { low: -limit, high: limit }, height - below - BOTTOM + 4);
  axes(surface, strip, colours, { xLabel: 's', yTicks: 2 });
  for (const axis of shown) {
    curve(surface, strip, history.columns.time, history.columns[`error${axis}`], history.length, { colour: colours.axes[axis], width: 1.3 });
  }
  frameLabel(surface, 'error', strip, colours);
  frameLabel(surface, 'N', frame, colours);
}

/** @type {(surface: Surface, text: string, frame: Frame, colours: Palette) => void} */
function frameLabel(surface, text, frame, colours) {
  surface.font = FONT;
  surface.fillStyle = colours.muted;
  surface.textAlign = 'left';
  surface.textBaseline = 'top';
  surface.fillText(text, frame.left + 5, frame.top + 3);
}

/** @type {(view: View, shown: number[]) => {low: number, high: number}} */
function forceRange({ history, ghost, closeUp }, shown) {
  const names = shown.flatMap((axis) => [`force${axis}`, `target${axis}`]);
  const targets = bounds(shown.map((axis) => history.columns[`target${axis}`]), history.length);
  if (closeUp && targets.high >= targets.low) return { low: targets.low - 12, high: targets.high + 12 };
  const own = bounds(names.map((name) => history.columns[name]), history.length);
  const other = ghost ? bounds(shown.map((axis) => ghost.columns[`force${axis}`]), ghost.length) : own;
  const [low, high] = [Math.min(0, own.low, other.low), Math.max(36, own.high, other.high)];
  const margin = 0.04 * (high - low);
  return { low: low < 0 ? low - margin : 0, high: high + margin };
}

/** @type {(value: number) => number} the next larger round number */
function roundUp(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  return ([1, 2, 3, 5, 10].find((factor) => factor * power >= value) ?? 10) * power;
}

/** Lower end of the residual axis; smaller residuals are rounding errors. */
const MIN_RESIDUAL = 1e-16;

/** @type {Draw} */
export function residuals(surface, width, height, view, colours) {
  const { history } = view;
  const columns = Array.from({ length: history.tasks }, (_, k) => history.columns[`residual${k}`]);
  const { high } = bounds(columns, history.length);
  const top = 10 ** Math.ceil(Math.log10(Math.max(1e-3, high || 0)) + 0.1);
  const frame = timeFrame(width, height, view, { low: MIN_RESIDUAL, high: top, log: true });
  axes(surface, frame, colours, { xLabel: 's' });
  columns.forEach((column, k) => {
    const width = k === 0 ? 1.9 : 1.5;
    const style = { colour: colours.axes[k % 3], dash: DASHES[k] ?? [1, 2], floor: MIN_RESIDUAL, width };
    curve(surface, frame, history.columns.time, column, history.length, style);
  });
}

/** Dash patterns of the task curves, highest priority first. */
export const DASHES = [[], [6, 3], [2, 2], [8, 3, 2, 3], [1, 2], [4, 4]];

/** @type {Draw} */
export function singularity(surface, width, height, view, colours) {
  const { history, ghost, threshold } = view;
  const { high } = bounds([history.columns.sigma], history.length);
  const top = Math.max(0.1, (threshold ?? 0) * 1.6, Number.isFinite(high) ? high * 1.15 : 0);
  const frame = timeFrame(width, height, view, { low: 0, high: top });
  axes(surface, frame, colours, { xLabel: 's' });
  if (threshold) level(surface, frame, threshold, colours.alarm, `damping below ${threshold}`);
  if (ghost) {
    curve(surface, frame, ghost.columns.time, ghost.columns.sigma, ghost.length, { colour: colours.ghost, dash: [5, 3] });
  }
  curve(surface, frame, history.columns.time, history.columns.sigma, history.length, { colour: colours.accent });
}

/** @type {Draw} */
export function roundTrips(surface, width, height, view, colours) {
  const { history, period } = view;
  const { columns, length } = history;
  const { low, high } = bounds([columns.roundTrip], length);
  const periodMicros = period * 1e6;
  const range = {
    low: 10 ** Math.floor(Math.log10(Math.max(1, Math.min(100, low || 100)))),
    high: 10 ** Math.ceil(Math.log10(Math.max(high || 0, 2 * periodMicros, 10))),
    log: true,
  };
  const frame = timeFrame(width, height, view, range);
  axes(surface, frame, colours, { xLabel: 's' });
  surface.fillStyle = colours.accent;
  const step = Math.max(1, Math.floor(length / 1500));
  for (let i = 0; i < length; i += step) {
    if (columns.roundTrip[i] > 0) {
      surface.fillRect(atX(frame, columns.time[i]) - 0.8, atY(frame, columns.roundTrip[i]) - 0.8, 1.6, 1.6);
    }
  }
  level(surface, frame, periodMicros, colours.alarm, `period ${microseconds(periodMicros)}`);
}

/** @type {(micros: number) => string} */
export function microseconds(micros) {
  if (micros >= 1e6) return `${(micros / 1e6).toFixed(1)} s`;
  return micros >= 1000 ? `${Number((micros / 1000).toPrecision(3))} ms` : `${Number(micros.toPrecision(3))} µs`;
}

/** @type {Draw} */
export function solver(surface, width, height, view, colours) {
  const { history, solveTime } = view;
  const strip = timeFrame(width, height, view, { low: 0, high: 1 }, 6, height - 22);
  surface.strokeStyle = colours.grid;
  surface.lineWidth = 1;
  surface.strokeRect(strip.left + 0.5, strip.top + 0.5, strip.width, strip.height);
  drawPaths(surface, strip, history, colours);
  const counts = solveTime?.counts ?? [];
  const max = Math.max(1, ...counts);
  const first = Math.max(0, counts.findIndex((count) => count > 0) - 2);
  const last = Math.min(counts.length, counts.findLastIndex((count) => count > 0) + 3);
  const [low, high] = last > first ? [first, Math.max(last, first + 12)] : [1, 31];
  const edge = (/** @type {number} */ bin) => 10 ** ((bin - 1) / 10);
  const frame = {
    left: LEFT, top: 36, width: width - LEFT - RIGHT, height: height - 36 - BOTTOM,
    x: { low: edge(low), high: edge(high), log: true }, y: { low: 0, high: max * 1.08 },
  };
  axes(surface, frame, colours, { xLabel: 'µs' });
  surface.fillStyle = colours.accent;
  counts.forEach((count, bin) => {
    if (count === 0 || bin < low || bin >= high) return;
    const [x, next, y] = [atX(frame, edge(bin)), atX(frame, edge(bin + 1)), atY(frame, count)];
    surface.fillRect(x + 0.5, y, Math.max(1, next - x - 1), frame.top + frame.height - y);
  });
  if (max === 1 && counts.every((count) => count === 0)) {
    hint('no answers yet', surface, frame.left + frame.width / 2, frame.top + frame.height / 2, colours);
  }
}

/** @type {(surface: Surface, frame: Frame, history: History, colours: Palette) => void} */
function drawPaths(surface, frame, history, colours) {
  const { time, path } = history.columns;
  for (let i = 0; i < history.length; ) {
    let end = i + 1;
    while (end < history.length && path[end] === path[i]) end += 1;
    const x = atX(frame, time[i]);
    const endX = atX(frame, time[Math.min(end, history.length - 1)]);
    const at = PATHS[path[i]];
    if (at) {
      surface.fillStyle = colours.paths[at];
      // Each path also has its own height, for readers who cannot distinguish the colours.
      const high = frame.height * [0.45, 0.72, 1][path[i]];
      surface.fillRect(x, frame.top + frame.height - high, Math.max(1, endX - x), high);
    }
    i = end;
  }
}

/** @type {Draw} */
export function activeLimits(surface, width, height, view, colours) {
  const joints = view.robot?.joints ?? [];
  const { time, lower, upper } = view.history.columns;
  const frame = timeFrame(width, height, view, { low: 0, high: Math.max(1, joints.length) });
  axes(surface, frame, colours, { y: false, xLabel: 's' });
  const row = frame.height / Math.max(1, joints.length);
  surface.font = FONT;
  joints.forEach((joint, i) => {
    const top = frame.top + i * row;
    surface.strokeStyle = colours.grid;
    line(surface, frame.left, Math.round(top + row) + 0.5, frame.left + frame.width, Math.round(top + row) + 0.5);
    surface.fillStyle = colours.muted;
    surface.textAlign = 'right';
    surface.textBaseline = 'middle';
    surface.fillText(short(joint.name), frame.left - 6, top + row / 2);
    const bit = 1 << Math.min(i, 30);
    drawIntervals(surface, frame, time, upper, bit, view.history.length, top + 1, row / 2 - 1.5, colours.alarm);
    const middle = top + row / 2 + 0.5;
    drawIntervals(surface, frame, time, lower, bit, view.history.length, middle, row / 2 - 1.5, colours.axes[0]);
  });
}

/** @type {(surface: Surface, frame: Frame, time: Float64Array, bits: Float64Array, bit: number, length: number, top: number, high: number, colour: string) => void} */
function drawIntervals(surface, frame, time, bits, bit, length, top, high, colour) {
  surface.fillStyle = colour;
  for (let i = 0; i < length; i += 1) {
    if ((bits[i] & bit) === 0) continue;
    let end = i;
    while (end + 1 < length && bits[end + 1] & bit) end += 1;
    const x = atX(frame, time[i]);
    surface.fillRect(x, top, Math.max(1.5, atX(frame, time[end]) - x), Math.max(1, high));
    i = end;
  }
}

/** @type {(name: string) => string} a joint name shortened to fit next to its row */
export function short(name) {
  return name.length > 6 ? `…${name.slice(-5)}` : name;
}
