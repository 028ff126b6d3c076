// Plots over time: their axis, marks of changes, the cursor, and what the pointer reads.

import { atX, FONT, line } from './plot.js';

/**
 * @typedef {import('./theme.js').Palette} Palette
 * @typedef {import('./plot.js').Surface} Surface
 * @typedef {import('./plot.js').Frame} Frame
 * @typedef {import('./view.js').View} View
 *
 * @typedef {object} Reading what the pointer reads in a plot
 * @property {Frame} [frame] of a plot over time; without it, `at` receives a position instead of a time
 * @property {(time: number, y: number) => string[]} at lines of text for a time in s, or for a position x, y in px
 *
 * @typedef {(surface: Surface, width: number, height: number, view: View, colours: Palette) => Reading | null} Draw
 */

export const LEFT = 50;
export const RIGHT = 12;
export const BOTTOM = 20;

/** Length of the time axis of a long run, s, and the duration from which a run is long. */
const WINDOW = 20;
const LONG_RUN = 60;

/** @type {(view: View) => {low: number, high: number}} */
export function timeRange({ history, duration, cursor }) {
  if (duration > 0 && duration <= LONG_RUN) return { low: 0, high: Math.max(duration, history.now) };
  const latest = Math.max(WINDOW, history.now);
  const end = cursor !== null && cursor < latest - WINDOW ? Math.max(WINDOW, cursor + WINDOW / 4) : latest;
  return { low: Math.max(0, end - WINDOW), high: end };
}

/** @type {(width: number, height: number, view: View, y: import('./plot.js').Range, top?: number, bottom?: number) => Frame} */
export function timeFrame(width, height, view, y, top = 8, bottom = BOTTOM) {
  return { left: LEFT, top, width: width - LEFT - RIGHT, height: height - top - bottom, x: timeRange(view), y };
}

/** Draws the marks of changes and the cursor over a plot. @type {(surface: Surface, frame: Frame, view: View, colours: Palette, labels?: boolean) => void} */
export function drawMarks(surface, frame, view, colours, labels = false) {
  const { marks } = view.history;
  surface.lineWidth = 1;
  surface.font = FONT;
  surface.textBaseline = 'top';
  surface.textAlign = 'left';
  let free = -Infinity;
  for (const { time, text } of marks) {
    if (time < frame.x.low || time > frame.x.high) continue;
    const x = Math.round(atX(frame, time)) + 0.5;
    surface.strokeStyle = colours.muted;
    surface.setLineDash([2, 3]);
    line(surface, x, frame.top, x, frame.top + frame.height);
    surface.setLineDash([]);
    surface.fillStyle = colours.text;
    surface.fillRect(x - 2.5, frame.top - 2, 5, 5);
    const room = frame.left + frame.width - x;
    const width = 6 * text.length;
    if (!labels || x < free || width > room) continue;
    surface.fillText(text, x + 4, frame.top + 1);
    free = x + width + 8;
  }
  if (view.cursor === null || view.cursor < frame.x.low || view.cursor > frame.x.high) return;
  const x = Math.round(atX(frame, view.cursor)) + 0.5;
  surface.strokeStyle = colours.text;
  surface.lineWidth = 1.2;
  line(surface, x, frame.top - 3, x, frame.top + frame.height + 3);
}

/** Draws the line under the pointer. @type {(surface: Surface, frame: Frame, time: number, height: number, colours: Palette) => void} */
export function drawHover(surface, frame, time, height, colours) {
  if (time < frame.x.low || time > frame.x.high) return;
  const x = Math.round(atX(frame, time)) + 0.5;
  surface.strokeStyle = colours.accent;
  surface.lineWidth = 1;
  line(surface, x, frame.top, x, height - BOTTOM);
}

/** Returns the marks near a time, as text. @type {(view: View, time: number) => string[]} */
export function marksNear(view, time) {
  const { low, high } = timeRange(view);
  return view.history.marks.filter((mark) => Math.abs(mark.time - time) < (high - low) / 60).map(({ text }) => `◆ ${text}`);
}

/**
 * Returns a reading that shows one line per curve.
 * @param {View} view
 * @param {Frame} frame
 * @param {(index: number) => string[]} lines for the sample with this index
 * @returns {Reading}
 */
export function timeReading(view, frame, lines) {
  const at = (/** @type {number} */ time) => {
    const index = view.history.indexAt(time);
    if (index < 0) return [];
    return [`t = ${view.history.columns.time[index].toFixed(3)} s`, ...lines(index), ...marksNear(view, time)];
  };
  return { frame, at };
}
