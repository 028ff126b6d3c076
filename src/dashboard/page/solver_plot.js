// The plot of the solver: the path of each period, and a histogram of the computing times.

import { PATHS } from './history.js';
import { microseconds } from './number.js';
import { atX, atY, axes, hint } from './plot.js';
import { BOTTOM, LEFT, RIGHT, drawMarks, timeFrame } from './time_axis.js';

/**
 * @typedef {import('./theme.js').Palette} Palette
 * @typedef {import('./plot.js').Surface} Surface
 * @typedef {import('./plot.js').Frame} Frame
 * @typedef {import('./history.js').History} History
 */

/** @type {import('./time_axis.js').Draw} */
export function solver(surface, width, height, view, colours) {
  const { history, solveTime } = view;
  const strip = timeFrame(width, height, view, { low: 0, high: 1 }, 6, height - 22);
  surface.strokeStyle = colours.grid;
  surface.lineWidth = 1;
  surface.strokeRect(strip.left + 0.5, strip.top + 0.5, strip.width, strip.height);
  drawPaths(surface, strip, history, colours);
  drawMarks(surface, strip, view, colours);
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
  if (counts.every((count) => count === 0)) {
    hint('no answers yet', surface, frame.left + frame.width / 2, frame.top + frame.height / 2, colours);
  }
  const at = (/** @type {number} */ x, /** @type {number} */ y) => {
    const bin = counts.findIndex((_, i) => x >= atX(frame, edge(i)) && x < atX(frame, edge(i + 1)));
    if (y < frame.top || bin < 0 || bin < low || bin >= high) return [];
    return [`${microseconds(edge(bin))} to ${microseconds(edge(bin + 1))}`, `${counts[bin]} periods`];
  };
  return { at };
}

/** @type {(surface: Surface, frame: Frame, history: History, colours: Palette) => void} */
function drawPaths(surface, frame, history, colours) {
  const { time, path } = history.columns;
  for (let i = 0; i < history.length; ) {
    let end = i + 1;
    while (end < history.length && path[end] === path[i]) end += 1;
    const x = Math.max(frame.left, atX(frame, time[i]));
    const endX = Math.min(frame.left + frame.width, atX(frame, time[Math.min(end, history.length - 1)]));
    const at = PATHS[path[i]];
    if (at && endX >= x) {
      surface.fillStyle = colours.paths[at];
      // Each path also has its own height, for readers who cannot distinguish the colours.
      const high = frame.height * [0.45, 0.72, 1][path[i]];
      surface.fillRect(x, frame.top + frame.height - high, Math.max(1, endX - x), high);
    }
    i = end;
  }
}
