// The plot of the contact force: measured and desired force, and the error.

import { ghostCurves, lengthOf } from './ghost_curves.js';
import { fixed } from './number.js';
import { axes, bounds, curve, FONT } from './plot.js';
import { BOTTOM, drawMarks, timeFrame, timeReading } from './time_axis.js';

/**
 * @typedef {import('./theme.js').Palette} Palette
 * @typedef {import('./plot.js').Surface} Surface
 * @typedef {import('./plot.js').Frame} Frame
 * @typedef {import('./view.js').View} View
 */

/** Returns the directions with a desired force; without any, those whose measured force changes; otherwise the first. @type {(view: View) => number[]} */
export function forceAxes({ history }) {
  const own = history.measures?.rows.length ?? 0;
  if (own > 0) return Array.from({ length: own }, (_, row) => row);
  const withTarget = [0, 1, 2].filter((axis) => history.hasTarget(axis));
  if (withTarget.length > 0) return withTarget;
  const changing = [0, 1, 2].filter((axis) => {
    const { low, high } = bounds([history.columns[`force${axis}`]], history.length);
    return high - low > 1e-9;
  });
  return changing.length > 0 ? changing : [0];
}

/** @type {(view: View, axis: number) => string} */
export const forceLabel = (view, axis) => view.history.measures?.forceLabels[axis] ?? 'xyz'[axis];

/** @type {import('./time_axis.js').Draw} */
export function force(surface, width, height, view, colours) {
  const { history } = view;
  const shown = forceAxes(view);
  const hasTarget = shown.some((axis) => history.hasTarget(axis)) || (history.measures?.rows.length ?? 0) > 0;
  const below = hasTarget ? Math.round(0.3 * height) : 0;
  const frame = timeFrame(width, height, view, forceRange(view, shown), 8, hasTarget ? below + 31 : BOTTOM);
  axes(surface, frame, colours, hasTarget ? { x: false } : { xLabel: 's' });
  for (const axis of shown) {
    const [columns, colour] = [history.columns, colours.axes[axis]];
    ghostCurves(surface, frame, view, `force${axis}`, colours, { width: 1.4, dash: [5, 3] });
    curve(surface, frame, columns.time, columns[`force${axis}`], history.length, { colour, width: 1.8 });
    const target = { colour: colours.text, width: 1.3, dash: [2, 3] };
    curve(surface, frame, columns.time, columns[`target${axis}`], history.length, target);
  }
  frameLabel(surface, 'N', frame, colours);
  drawMarks(surface, frame, view, colours, true);
  if (hasTarget) drawErrors(surface, width, height, view, shown, below, colours);
  return timeReading(view, frame, (i) => shown.map((axis) => {
    const [value, target] = [history.columns[`force${axis}`][i], history.columns[`target${axis}`][i]];
    const desired = Number.isNaN(target) ? '' : `, desired ${fixed(target, 2)} N`;
    return `force ${forceLabel(view, axis)} ${fixed(value, 2)} N${desired}`;
  }));
}

/** @type {(surface: Surface, width: number, height: number, view: View, shown: number[], below: number, colours: Palette) => void} */
function drawErrors(surface, width, height, view, shown, below, colours) {
  const { history } = view;
  const errors = bounds(shown.map((axis) => history.columns[`error${axis}`]), history.length);
  const limit = roundUp(view.closeUp ? 10 : Math.max(1, Math.abs(errors.low), Math.abs(errors.high)));
  const strip = timeFrame(width, height, view, { low: -limit, high: limit }, height - below - BOTTOM + 4);
  axes(surface, strip, colours, { xLabel: 's', yTicks: 2 });
  for (const axis of shown) {
    const style = { colour: colours.axes[axis], width: 1.3 };
    curve(surface, strip, history.columns.time, history.columns[`error${axis}`], history.length, style);
  }
  frameLabel(surface, 'error, N', strip, colours);
  drawMarks(surface, strip, view, colours);
}

/** @type {(surface: Surface, text: string, frame: Frame, colours: Palette) => void} */
export function frameLabel(surface, text, frame, colours) {
  surface.font = FONT;
  surface.fillStyle = colours.muted;
  surface.textAlign = 'left';
  surface.textBaseline = 'top';
  surface.fillText(text, frame.left + 5, frame.top + 3);
}

/** @type {(view: View, shown: number[]) => {low: number, high: number}} */
function forceRange(view, shown) {
  const { history, ghosts, closeUp } = view;
  const names = shown.flatMap((axis) => [`force${axis}`, `target${axis}`]);
  const targets = bounds(shown.map((axis) => history.columns[`target${axis}`]), history.length);
  if (closeUp && targets.high >= targets.low) return { low: targets.low - 12, high: targets.high + 12 };
  const own = bounds(names.map((name) => history.columns[name]), history.length);
  const others = ghosts.filter((ghost) => ghost.history.columns.force0).map((ghost) => bounds(shown.map((axis) => ghost.history.columns[`force${axis}`]), lengthOf(ghost, view)));
  const [low, high] = [Math.min(0, own.low, ...others.map((other) => other.low)), Math.max(20, own.high, ...others.map((other) => other.high))];
  const margin = 0.04 * (high - low);
  return { low: low < 0 ? low - margin : 0, high: high + margin };
}

/** @type {(value: number) => number} the next larger round number */
export function roundUp(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  return ([1, 2, 3, 5, 10].find((factor) => factor * power >= value) ?? 10) * power;
}
