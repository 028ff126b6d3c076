// The plot of the pose errors: the distance and the angle from each task's target.

import { frameLabel } from './force_plot.js';
import { ghostCurves, lengthOf } from './ghost_curves.js';
import { angle, distance } from './number.js';
import { axes, curve, hint } from './plot.js';
import { DASHES } from './plots.js';
import { BOTTOM, drawMarks, timeFrame, timeReading } from './time_axis.js';

/**
 * @typedef {import('./theme.js').Palette} Palette
 * @typedef {import('./plot.js').Surface} Surface
 * @typedef {import('./plot.js').Range} Range
 * @typedef {import('./view.js').View} View
 * @typedef {{name: string, factor: number, unit: string}} Part
 */

/** @type {Part} */
const LINEAR = { name: 'linear', factor: 1e3, unit: 'mm' };
/** @type {Part} */
const ANGULAR = { name: 'angular', factor: 180 / Math.PI, unit: '°' };

/** Ratio of the largest to the smallest shown value above which the scale is logarithmic. */
const LOG_RATIO = 300;

/** Smallest shown error, mm or °; smaller ones are rounding of the single-precision samples. */
const SMALLEST = 1e-4;

/** Returns the tasks that have an error of a part. @type {(view: View, part: Part) => number[]} */
function tasksWith({ history }, part) {
  const indices = Array.from({ length: history.tasks }, (_, k) => k);
  return indices.filter((k) => history.length > 0 && !Number.isNaN(history.columns[`${part.name}${k}`][history.length - 1]));
}

/** Additional room between both parts, px: the numbers at the ends of their axes are one above the other. */
const GAP = 8;

/** @type {import('./time_axis.js').Draw} */
export function pose(surface, width, height, view, colours) {
  const parts = [LINEAR, ANGULAR].filter((part) => tasksWith(view, part).length > 0);
  if (parts.length === 0) {
    const frame = timeFrame(width, height, view, { low: 0, high: 1 });
    axes(surface, frame, colours, { xLabel: 's' });
    hint('starts with the run', surface, frame.left + frame.width / 2, frame.top + frame.height / 2, colours);
    return null;
  }
  const each = (height - BOTTOM - 8) / parts.length;
  const frames = parts.map((part, i) => {
    const isLast = i + 1 === parts.length;
    const top = 8 + i * each + (i > 0 ? 6 : 0);
    const bottom = height - (8 + (i + 1) * each) + (isLast ? 0 : GAP);
    const frame = timeFrame(width, height, view, range(view, part), top, bottom);
    axes(surface, frame, colours, { x: isLast, xLabel: 's', yTicks: Math.max(2, each / 30) });
    drawPart(surface, frame, view, part, colours);
    frameLabel(surface, part.unit, frame, colours);
    drawMarks(surface, frame, view, colours, i === 0);
    return frame;
  });
  return timeReading(view, frames[0], (i) => tasksShown(view).map((k) => {
    const [linear, angular] = [view.history.columns[`linear${k}`][i], view.history.columns[`angular${k}`][i]];
    const values = [Number.isNaN(linear) ? '' : distance(linear), Number.isNaN(angular) ? '' : angle(angular)];
    return `${view.tasks[k] ?? k + 1}: ${values.filter(Boolean).join(', ')}`;
  }));
}

/** Returns the tasks with any error. @type {(view: View) => number[]} */
export function tasksShown(view) {
  const all = new Set([...tasksWith(view, LINEAR), ...tasksWith(view, ANGULAR)]);
  return [...all].sort((a, b) => a - b);
}

/** @type {(view: View, part: Part) => Range} */
function range(view, part) {
  let [low, high] = [Infinity, SMALLEST];
  const shown = [{ history: view.history, length: view.history.length }, ...view.ghosts.map((ghost) => ({ history: ghost.history, length: lengthOf(ghost, view) }))];
  for (const { history, length } of shown) {
    for (const k of tasksWith(view, part)) {
      const column = history.columns[`${part.name}${k}`] ?? [];
      for (let i = 0; i < length; i += 1) {
        const value = column[i] * part.factor;
        if (value > high) high = value;
        if (value > SMALLEST && value < low) low = value;
      }
    }
  }
  if (high / low < LOG_RATIO) return { low: 0, high: high * 1.08 };
  return { low: Math.max(SMALLEST, 10 ** Math.floor(Math.log10(low))), high: 10 ** Math.ceil(Math.log10(high)), log: true };
}

/** @type {(surface: Surface, frame: import('./plot.js').Frame, view: View, part: Part, colours: Palette) => void} */
function drawPart(surface, frame, view, part, colours) {
  const scaled = { ...frame, y: { ...frame.y, low: frame.y.low / part.factor, high: frame.y.high / part.factor } };
  const floor = frame.y.log ? scaled.y.low : undefined;
  for (const k of tasksWith(view, part)) {
    const name = `${part.name}${k}`;
    const { history } = view;
    ghostCurves(surface, scaled, view, name, colours, { width: 1.2, dash: DASHES[k], floor });
    const style = { colour: colours.axes[k % 3], width: 1.7, dash: DASHES[k], floor };
    curve(surface, scaled, history.columns.time, history.columns[name], history.length, style);
  }
}
