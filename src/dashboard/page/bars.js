// Plots with one row per joint: velocities with their current bounds, positions with their limits.

import { labelWidth } from './labels.js';
import { fixed } from './number.js';
import { FONT, line } from './plot.js';

/**
 * @typedef {import('./time_axis.js').Draw} Draw
 * @typedef {import('./view.js').View} View
 * @typedef {import('./plot.js').Surface} Surface
 * @typedef {import('./theme.js').Palette} Palette
 *
 * @typedef {object} Row
 * @property {number} top px
 * @property {number} high px
 * @property {number} left px
 * @property {number} width px
 */

/** @type {(surface: Surface, width: number, height: number, names: string[], values: string[], colours: Palette) => Row[]} */
function rows(surface, width, height, names, values, colours) {
  const [left, right] = [labelWidth(names), 54];
  const high = (height - 12) / Math.max(1, names.length);
  surface.font = FONT;
  surface.textBaseline = 'middle';
  return names.map((name, i) => {
    const row = { top: 6 + i * high, high, left, width: width - left - right };
    surface.fillStyle = colours.muted;
    surface.textAlign = 'right';
    surface.fillText(name, left - 8, row.top + high / 2);
    surface.fillStyle = colours.text;
    surface.fillText(values[i] ?? '', width - 4, row.top + high / 2);
    return row;
  });
}

/** @type {(value: number | undefined) => string} */
const format = (value) => (value === undefined ? '' : fixed(value, 3));

/** @type {(rows: Row[], lines: (joint: number) => string[]) => import('./time_axis.js').Reading} */
function rowReading(rows, lines) {
  const at = (/** @type {number} */ _, /** @type {number} */ y) => {
    const joint = rows.findIndex(({ top, high }) => y >= top && y < top + high);
    return joint < 0 ? [] : lines(joint);
  };
  return { at };
}

/** @type {Draw} */
export function velocities(surface, width, height, view, colours) {
  const joints = view.robot?.joints ?? [];
  const fastest = Math.max(0.1, ...joints.map((joint) => joint.velocity_limit ?? 0));
  const all = rows(surface, width, height, view.labels, view.velocity.map(format), colours);
  all.forEach((row, i) => {
    const at = (/** @type {number} */ v) => row.left + (row.width * (clamp(v / fastest, 1.04) + 1.04)) / 2.08;
    const { lower, upper } = view.arm?.joints[i] ?? { lower: null, upper: null };
    const [low, high] = [lower ?? -Infinity, upper ?? Infinity];
    const middle = row.top + row.high / 2;
    const thickness = Math.min(15, row.high - 5);
    const velocity = view.velocity[i] ?? 0;
    surface.strokeStyle = colours.grid;
    surface.lineWidth = 1;
    line(surface, row.left, middle, row.left + row.width, middle);
    surface.fillStyle = colours.allowed;
    surface.globalAlpha = 0.5;
    if (lower !== null || upper !== null) surface.fillRect(at(low), middle - thickness / 2, at(high) - at(low), thickness);
    surface.globalAlpha = 1;
    surface.strokeStyle = colours.muted;
    for (const bound of [low, high]) {
      if (Math.abs(bound) > fastest * 1.001) continue;
      line(surface, at(bound), middle - thickness / 2, at(bound), middle + thickness / 2);
    }
    const side = view.sample?.at_upper.includes(i) ? 1 : view.sample?.at_lower.includes(i) ? -1 : 0;
    surface.fillStyle = side ? colours.alarm : colours.accent;
    const length = Math.max(1, Math.abs(at(velocity) - at(0)));
    surface.fillRect(Math.min(at(0), at(velocity)), middle - thickness / 4, length, thickness / 2);
    surface.strokeStyle = colours.text;
    line(surface, at(0), middle - thickness / 2 - 1, at(0), middle + thickness / 2 + 1);
    if (side) drawMarker(surface, at(velocity) + side * 7, middle, side, colours.alarm);
  });
  return rowReading(all, (joint) => {
    const { lower, upper } = view.arm?.joints[joint] ?? { lower: null, upper: null };
    const unit = `${joints[joint]?.unit ?? 'rad'}/s`;
    return [`${joints[joint]?.name}: ${fixed(view.velocity[joint] ?? 0, 4)} ${unit}`, `allowed now: ${fixed(lower, 3)} to ${fixed(upper, 3)} ${unit}`];
  });
}

/** @type {Draw} */
export function positions(surface, width, height, view, colours) {
  const joints = view.robot?.joints ?? [];
  const all = rows(surface, width, height, view.labels, view.position.map(format), colours);
  all.forEach((row, i) => {
    const range = joints[i].position_limit;
    const q = view.position[i];
    const middle = row.top + row.high / 2;
    const thickness = Math.min(7, row.high / 2);
    surface.strokeStyle = colours.muted;
    surface.lineWidth = 1;
    if (range) {
      surface.fillStyle = colours.allowed;
      surface.globalAlpha = 0.5;
      surface.fillRect(row.left, middle - thickness / 2, row.width, thickness);
      surface.globalAlpha = 1;
      for (const end of [row.left, row.left + row.width]) line(surface, end, middle - thickness, end, middle + thickness);
    }
    line(surface, row.left + row.width / 2, middle - thickness / 2, row.left + row.width / 2, middle + thickness / 2);
    if (q === undefined) return;
    // Without limits: the angle from −π to π.
    const part = range ? (q - range[0]) / (range[1] - range[0]) : 0.5 + Math.atan2(Math.sin(q), Math.cos(q)) / (2 * Math.PI);
    const isNear = range && (part < 0.03 || part > 0.97);
    surface.fillStyle = isNear ? colours.alarm : colours.accent;
    surface.beginPath();
    surface.arc(row.left + row.width * Math.max(0, Math.min(1, part)), middle, Math.min(6, row.high / 2.6), 0, 2 * Math.PI);
    surface.fill();
    const side = part > 0.5 ? 1 : -1;
    if (isNear) drawMarker(surface, row.left + row.width * part - 12 * side, middle, side, colours.alarm);
  });
  return rowReading(all, (joint) => {
    const { name, unit, position_limit: range } = joints[joint];
    const allowed = range ? `range ${fixed(range[0], 3)} to ${fixed(range[1], 3)} ${unit}` : 'no limits';
    return [`${name}: ${fixed(view.position[joint], 4)} ${unit}`, allowed];
  });
}

/** Draws a triangle that points to the bound. @type {(surface: Surface, x: number, y: number, side: number, colour: string) => void} */
function drawMarker(surface, x, y, side, colour) {
  surface.fillStyle = colour;
  surface.beginPath();
  surface.moveTo(x + 4 * side, y);
  surface.lineTo(x - 3 * side, y - 4.5);
  surface.lineTo(x - 3 * side, y + 4.5);
  surface.closePath();
  surface.fill();
}

/** @type {(value: number, max: number) => number} */
function clamp(value, max) {
  return Math.max(-max, Math.min(max, value));
}
