// Plots with one row per joint: velocities with their current bounds, positions with their limits.

import { FONT, line } from './plot.js';
import { short } from './plots.js';

/**
 * @typedef {import('./plots.js').Draw} Draw
 * @typedef {import('./plot.js').Surface} Surface
 * @typedef {import('./theme.js').Palette} Palette
 *
 * @typedef {object} Row
 * @property {number} top px
 * @property {number} high px
 * @property {number} left px
 * @property {number} width px
 */

/** Distance to a bound below which a velocity counts as limited by it, rad/s or m/s. */
const BOUND_TOLERANCE = 1e-4;

/** @type {(surface: Surface, width: number, height: number, names: string[], values: string[], colours: Palette) => Row[]} */
function rows(surface, width, height, names, values, colours) {
  const [left, right] = [44, 54];
  const high = (height - 12) / Math.max(1, names.length);
  surface.font = FONT;
  surface.textBaseline = 'middle';
  return names.map((name, i) => {
    const row = { top: 6 + i * high, high, left, width: width - left - right };
    surface.fillStyle = colours.muted;
    surface.textAlign = 'right';
    surface.fillText(short(name), left - 8, row.top + high / 2);
    surface.fillStyle = colours.text;
    surface.fillText(values[i] ?? '', width - 4, row.top + high / 2);
    return row;
  });
}

/** @type {(value: number | undefined) => string} */
const format = (value) => (value === undefined ? '' : value.toFixed(3).replace('-', '−'));

/** @type {Draw} */
export function velocities(surface, width, height, view, colours) {
  const joints = view.robot?.joints ?? [];
  const fastest = Math.max(0.1, ...joints.map((joint) => joint.velocity_limit ?? 0));
  const names = joints.map((joint) => joint.name);
  rows(surface, width, height, names, view.velocity.map(format), colours).forEach((row, i) => {
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
    surface.fillRect(at(low), middle - thickness / 2, at(high) - at(low), thickness);
    surface.globalAlpha = 1;
    surface.strokeStyle = colours.muted;
    for (const bound of [low, high]) {
      if (Math.abs(bound) > fastest * 1.001) continue;
      line(surface, at(bound), middle - thickness / 2, at(bound), middle + thickness / 2);
    }
    const side = view.arm && (velocity >= high - BOUND_TOLERANCE ? 1 : velocity <= low + BOUND_TOLERANCE ? -1 : 0);
    surface.fillStyle = side ? colours.alarm : colours.accent;
    const length = Math.max(1, Math.abs(at(velocity) - at(0)));
    surface.fillRect(Math.min(at(0), at(velocity)), middle - thickness / 4, length, thickness / 2);
    surface.strokeStyle = colours.text;
    line(surface, at(0), middle - thickness / 2 - 1, at(0), middle + thickness / 2 + 1);
    if (side) drawMarker(surface, at(velocity) + side * 7, middle, side, colours.alarm);
  });
}

/** @type {Draw} */
export function positions(surface, width, height, view, colours) {
  const joints = view.robot?.joints ?? [];
  const names = joints.map((joint) => joint.name);
  rows(surface, width, height, names, view.position.map(format), colours).forEach((row, i) => {
    const range = joints[i].position_limit ?? [-Math.PI, Math.PI];
    const q = view.position[i];
    const middle = row.top + row.high / 2;
    const thickness = Math.min(7, row.high / 2);
    surface.fillStyle = colours.allowed;
    surface.globalAlpha = 0.5;
    surface.fillRect(row.left, middle - thickness / 2, row.width, thickness);
    surface.globalAlpha = 1;
    surface.strokeStyle = colours.muted;
    surface.lineWidth = 1;
    for (const end of [row.left, row.left + row.width]) line(surface, end, middle - thickness, end, middle + thickness);
    line(surface, row.left + row.width / 2, middle - thickness / 2, row.left + row.width / 2, middle + thickness / 2);
    if (q === undefined) return;
    const part = (q - range[0]) / (range[1] - range[0]);
    const isNear = part < 0.03 || part > 0.97;
    surface.fillStyle = isNear ? colours.alarm : colours.accent;
    surface.beginPath();
    surface.arc(row.left + row.width * Math.max(0, Math.min(1, part)), middle, Math.min(6, row.high / 2.6), 0, 2 * Math.PI);
    surface.fill();
    const side = part > 0.5 ? 1 : -1;
    if (isNear) drawMarker(surface, row.left + row.width * part - 12 * side, middle, side, colours.alarm);
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
