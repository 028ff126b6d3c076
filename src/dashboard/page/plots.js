// Plots of the hierarchy over time: residuals, smallest singular value, round trips.

import { ghostCurves } from './ghost_curves.js';
import { microseconds, quantity, scientific } from './number.js';
import { atX, atY, axes, bounds, curve, level } from './plot.js';
import { drawMarks, timeFrame, timeReading } from './time_axis.js';

/** @typedef {import('./time_axis.js').Draw} Draw */

/** Lower end of the residual axis; smaller residuals are rounding errors. */
const MIN_RESIDUAL = 1e-16;

/** Dash patterns of the task curves, highest priority first. */
export const DASHES = [[], [6, 3], [2, 2], [8, 3, 2, 3], [1, 2], [4, 4]];

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
  drawMarks(surface, frame, view, colours);
  return timeReading(view, frame, (i) =>
    columns.map((column, k) => `${view.tasks[k] ?? k + 1}: ${scientific(column[i])} ${view.residualUnits[k] ?? ''}`));
}

/** Ratio of the largest to the smallest singular value above which the scale is logarithmic. */
const LOG_RATIO = 300;

/** @type {Draw} */
export function singularity(surface, width, height, view, colours) {
  const { history, threshold } = view;
  const { low, high } = bounds([history.columns.sigma], history.length);
  const top = Math.max(0.1, (threshold ?? 0) * 1.6, Number.isFinite(high) ? high * 1.15 : 0);
  const log = top / low > LOG_RATIO;
  const bottom = Math.max(1e-16, 10 ** Math.floor(Math.log10(Math.max(low, 1e-16))));
  const frame = timeFrame(width, height, view, { low: log ? bottom : 0, high: top, log });
  const floor = log ? bottom : undefined;
  axes(surface, frame, colours, { xLabel: 's' });
  if (threshold) level(surface, frame, threshold, colours.alarm, `damping below ${threshold}`);
  ghostCurves(surface, frame, view, 'sigma', colours, { dash: [5, 3], floor });
  curve(surface, frame, history.columns.time, history.columns.sigma, history.length, { colour: colours.accent, floor });
  drawMarks(surface, frame, view, colours);
  return timeReading(view, frame, (i) => [`σ min ${quantity(history.columns.sigma[i], '')}`.trim()]);
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
  axes(surface, frame, colours, { xLabel: 's', yUnit: microseconds });
  surface.fillStyle = colours.accent;
  const step = Math.max(1, Math.floor(length / 1500));
  for (let i = 0; i < length; i += step) {
    if (columns.roundTrip[i] > 0) {
      surface.fillRect(atX(frame, columns.time[i]) - 0.8, atY(frame, columns.roundTrip[i]) - 0.8, 1.6, 1.6);
    }
  }
  level(surface, frame, periodMicros, colours.alarm, `period ${microseconds(periodMicros)}`);
  drawMarks(surface, frame, view, colours);
  return timeReading(view, frame, (i) => [`state to answer ${microseconds(columns.roundTrip[i])}`]);
}
