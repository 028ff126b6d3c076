// The plot of the active limits: one row per joint over time.

import { bitOf } from './history.js';
import { labelWidth } from './labels.js';
import { atX, axes, FONT, hint, line } from './plot.js';
import { drawMarks, timeFrame, timeReading } from './time_axis.js';

/**
 * @typedef {import('./plot.js').Frame} Frame
 * @typedef {import('./plot.js').Surface} Surface
 */

/** @type {import('./time_axis.js').Draw} */
export function activeLimits(surface, width, height, view, colours) {
  const { labels } = view;
  const { history } = view;
  const { time, lower, upper } = history.columns;
  const full = timeFrame(width, height, view, { low: 0, high: Math.max(1, labels.length) });
  const left = labelWidth(labels);
  const frame = { ...full, left, width: full.left + full.width - left };
  axes(surface, frame, colours, { y: false, xLabel: 's' });
  const row = frame.height / Math.max(1, labels.length);
  surface.font = FONT;
  let isEmpty = true;
  labels.forEach((label, i) => {
    const top = frame.top + i * row;
    surface.strokeStyle = colours.grid;
    line(surface, frame.left, Math.round(top + row) + 0.5, frame.left + frame.width, Math.round(top + row) + 0.5);
    surface.fillStyle = colours.muted;
    surface.textAlign = 'right';
    surface.textBaseline = 'middle';
    surface.fillText(label, frame.left - 6, top + row / 2);
    const bit = bitOf(i);
    const high = Math.max(1, row / 2 - 1.5);
    const above = drawIntervals(surface, frame, time, upper, bit, history.length, top + 1, high, colours.alarm);
    const below = drawIntervals(surface, frame, time, lower, bit, history.length, top + row / 2 + 0.5, high, colours.axes[0]);
    isEmpty &&= !above && !below;
  });
  if (isEmpty) {
    const text = history.length > 0 ? 'no limit was active so far' : 'starts with the run';
    hint(text, surface, frame.left + frame.width / 2, frame.top + frame.height / 2, colours);
  }
  drawMarks(surface, frame, view, colours);
  return timeReading(view, frame, (i) => {
    const at = (/** @type {number} */ joint) =>
      [lower, upper].flatMap((bits, side) => (bits[i] & bitOf(joint) ? [side ? 'upper' : 'lower'] : []));
    const active = labels.flatMap((label, joint) => at(joint).map((side) => `${label}: ${side} limit`));
    return active.length > 0 ? active : ['no active limit'];
  });
}

/** Returns whether there are any. @type {(surface: Surface, frame: Frame, time: Float64Array, bits: Float64Array, bit: number, length: number, top: number, high: number, colour: string) => boolean} */
function drawIntervals(surface, frame, time, bits, bit, length, top, high, colour) {
  surface.fillStyle = colour;
  let found = false;
  for (let i = 0; i < length; i += 1) {
    if ((bits[i] & bit) === 0) continue;
    found = true;
    let end = i;
    while (end + 1 < length && bits[end + 1] & bit) end += 1;
    const from = Math.max(frame.left, atX(frame, time[i]));
    const to = Math.min(frame.left + frame.width, atX(frame, time[end]));
    if (to >= frame.left && from <= frame.left + frame.width) surface.fillRect(from, top, Math.max(1.5, to - from), high);
    i = end;
  }
  return found;
}
