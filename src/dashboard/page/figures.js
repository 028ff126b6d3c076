// Draws the plots that are visible, and keeps what the pointer reads in them.

import { positions, velocities } from './bars.js';
import { force } from './force_plot.js';
import { activeLimits } from './limits_plot.js';
import { residuals, roundTrips, singularity } from './plots.js';
import { pose } from './pose_plot.js';
import { solver } from './solver_plot.js';
import { drawHover } from './time_axis.js';
import { palette } from './theme.js';

/**
 * @typedef {import('./view.js').View} View
 * @typedef {import('./time_axis.js').Draw} Draw
 * @typedef {import('./time_axis.js').Reading} Reading
 */

/** Draw functions by the `data-plot` value of their card. @type {Record<string, Draw>} */
export const DRAWINGS = {
  force, pose, velocities, positions, residuals, limits: activeLimits, singularity, solver, trips: roundTrips,
};

/** What the pointer reads in each plot, by the `data-plot` value. @type {Map<string, Reading>} */
export const readings = new Map();

/** The place of the pointer: a plot and a position in it, px. @type {{plot: string, x: number, y: number} | null} */
let pointer = null;

/** @param {{plot: string, x: number, y: number} | null} place */
export function setPointer(place) {
  pointer = place;
}

/** Returns the time under the pointer, s; null if it is not over a plot of time. @type {() => number | null} */
export function hoveredTime() {
  const reading = pointer ? readings.get(pointer.plot) : undefined;
  return reading?.frame && pointer ? timeAt(reading.frame, pointer.x) : null;
}

/** Returns the time at a position of a plot, s; null outside its axes. @type {(frame: import('./plot.js').Frame, x: number) => number | null} */
export function timeAt(frame, x) {
  if (x < frame.left - 4 || x > frame.left + frame.width + 4) return null;
  const part = Math.max(0, Math.min(1, (x - frame.left) / frame.width));
  return frame.x.low + part * (frame.x.high - frame.x.low);
}

/** Returns the lines under the pointer. @type {() => string[]} */
export function hoveredLines() {
  const reading = pointer ? readings.get(pointer.plot) : undefined;
  if (!reading || !pointer) return [];
  if (!reading.frame) return reading.at(pointer.x, pointer.y);
  const time = timeAt(reading.frame, pointer.x);
  return time === null ? [] : reading.at(time, pointer.y);
}

/** @type {() => NodeListOf<HTMLElement>} */
export const cards = () => document.querySelectorAll('[data-plot]');

/** Draws the plots that are visible on the screen. @type {(view: View) => void} */
export function drawFigures(view) {
  const colours = palette();
  const time = hoveredTime();
  for (const card of cards()) {
    const { top, bottom } = card.getBoundingClientRect();
    if (card.hidden || bottom < 0 || top > innerHeight) continue;
    const canvas = /** @type {HTMLCanvasElement} */ (card.querySelector('canvas'));
    const context = canvas.getContext('2d');
    const density = Math.min(2, devicePixelRatio || 1);
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    if (!context || width === 0) continue;
    if (canvas.width !== Math.round(width * density) || canvas.height !== Math.round(height * density)) {
      canvas.width = Math.round(width * density);
      canvas.height = Math.round(height * density);
    }
    context.setTransform(density, 0, 0, density, 0, 0);
    context.clearRect(0, 0, width, height);
    const plot = card.dataset.plot ?? '';
    const reading = DRAWINGS[plot](context, width, height, view, colours);
    if (reading) readings.set(plot, reading);
    else readings.delete(plot);
    if (time !== null && reading?.frame) drawHover(context, reading.frame, time, height, colours);
  }
}

