// Draws the plots, their legends and the numbers next to the scene.

import { positions, velocities } from './bars.js';
import { element } from './notices.js';
import { DASHES, activeLimits, force, forceAxes, microseconds, residuals, roundTrips, singularity, solver } from './plots.js';
import { methodName } from './setup.js';
import { state } from './state.js';
import { palette } from './theme.js';

/**
 * @typedef {import('./run_control.js').RunControl} RunControl
 * @typedef {import('./plots.js').View} View
 * @typedef {import('./plots.js').Draw} Draw
 * @typedef {import('./theme.js').Palette} Palette
 */

/** Draw functions by the `data-plot` value of their card. @type {Record<string, Draw>} */
export const DRAWINGS = {
  force, velocities, positions, residuals, limits: activeLimits, singularity, solver, trips: roundTrips,
};

const AXES = 'xyz';

/** @type {() => NodeListOf<HTMLElement>} */
const cards = () => document.querySelectorAll('[data-plot]');

/** Draws the plots that are visible on the screen. @type {(view: View) => void} */
export function drawFigures(view) {
  const colours = palette();
  for (const card of cards()) {
    const { top, bottom } = card.getBoundingClientRect();
    if (bottom < 0 || top > innerHeight) continue;
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
    DRAWINGS[card.dataset.plot ?? ''](context, width, height, view, colours);
  }
}

/** @type {(kind: string, colour: string, text: string) => HTMLElement} */
function entry(kind, colour, text) {
  const [line, key] = [document.createElement('span'), document.createElement('i')];
  key.className = `key ${kind}`;
  if (kind === 'block') key.style.background = colour;
  else key.style.borderTopColor = colour;
  line.append(key, text);
  return line;
}

let shownLegends = '';

/** Updates the legends of the plots when they have changed. @type {(view: View) => void} */
export function drawLegends(view) {
  const colours = palette();
  const shown = forceAxes(view);
  const total = view.paths ?? { closed_form: 0, active_set: 0, qp: 0 };
  const all = Math.max(1, total.closed_form + total.active_set + total.qp);
  const share = (/** @type {number} */ count) => `${Math.round((100 * count) / all)} %`;
  const ghost = view.ghost ? [entry('ghost', colours.ghost, 'ghost')] : [];
  /** @type {Record<string, HTMLElement[]>} */
  const content = {
    force: [
      ...shown.map((axis) => entry('', colours.axes[axis], `measured ${AXES[axis]}`)),
      entry('dot', colours.text, 'desired'), ...ghost,
    ],
    residuals: view.tasks.slice(0, 6).map((name, k) => entry((DASHES[k] ?? []).length > 0 ? 'dash' : '', colours.axes[k % 3], `${k + 1}. ${name}`)),
    velocities: [entry('block', colours.accent, 'rad/s or m/s'), entry('block', colours.allowed, 'current bounds'), entry('block', colours.alarm, '▶ at a limit')],
    positions: [entry('block', colours.accent, 'rad or m'), entry('block', colours.allowed, 'allowed range')],
    limits: [entry('block', colours.alarm, 'upper limit'), entry('block', colours.axes[0], 'lower limit')],
    singularity: [entry('', colours.accent, 'all tasks'), ...ghost],
    solver: [
      entry('block', colours.paths.closed_form, `closed form ${share(total.closed_form)}`),
      entry('block', colours.paths.active_set, `active set ${share(total.active_set)}`),
      entry('block', colours.paths.qp, `QP ${share(total.qp)}`),
    ],
    trips: [],
  };
  const text = JSON.stringify(Object.values(content).map((parts) => parts.map((part) => part.outerHTML)));
  if (text === shownLegends) return;
  shownLegends = text;
  for (const card of cards()) {
    card.querySelector('[data-legend]')?.replaceChildren(...(content[card.dataset.plot ?? ''] ?? []));
  }
}

/** @type {(value: number | null | undefined, digits: number) => string} */
function fixed(value, digits) {
  return value === null || value === undefined || Number.isNaN(value) ? '–' : value.toFixed(digits).replace('-', '−');
}

/** @type {(value: number | null | undefined) => string} */
function short(value) {
  if (value === null || value === undefined) return '–';
  return value === 0 ? '0' : value.toExponential(1).replace('e-', 'e−').replace('e+', 'e');
}

/** @type {(counts: number[], part: number) => number} quantile of the times, µs */
function quantile(counts, part) {
  const wanted = part * counts.reduce((sum, count) => sum + count, 0);
  let sum = 0;
  const bin = counts.findIndex((count) => (sum += count) >= wanted);
  return 10 ** (bin / 10);
}

const STATUS = { optimal: 'optimal', not_certified: 'not certified', failed: 'failed' };

/** Shows the current numbers. @type {(runControl: RunControl, view: View) => void} */
export function drawNumbers(runControl, view) {
  const { sample, run, watch } = runControl;
  const [axis] = forceAxes(view);
  const target = sample?.target_force[axis];
  const frame = run?.frame;
  element('force-value').textContent = fixed(sample?.force[axis], 1);
  element('force-target').textContent = `F${AXES[axis]} on the environment${target === null || target === undefined ? '' : `, desired ${target.toFixed(1)} N`}`;
  const running = runControl.watch ? runControl.watch.session.controller : run?.simulation;
  const method = running?.method ?? runControl.setup?.method ?? '';
  element('caption').textContent = methodName(method);
  element('clock').textContent = `${fixed(sample?.time_s ?? 0, 3)} s`;
  /** @type {HTMLProgressElement} */ (element('progress')).value = run?.simulation.progress ?? 0;
  const trips = frame?.round_trip;
  const hasTrips = trips && trips.counts.some((count) => count > 0);
  /** @type {[string, string, boolean?][]} */
  const numbers = [
    ['Error', `${fixed(sample && target !== null && target !== undefined ? sample.force[axis] - target : null, 2)} N`],
    ['σ min', (sample?.smallest_singular_value ?? 1) < 1e-3 ? short(sample?.smallest_singular_value) : fixed(sample?.smallest_singular_value, 4), view.threshold !== null && (sample?.smallest_singular_value ?? 1) < view.threshold],
    ['KKT residual', short(sample?.kkt_residual)],
    ['Status', sample ? STATUS[sample.status] : '–', sample !== undefined && sample.status !== 'optimal'],
    watch
      ? ['Compute time', sample ? microseconds(sample.solve_us) : '–']
      : ['Round trip', hasTrips ? microseconds(quantile(trips.counts, 0.5)) : '–'],
    watch
      ? ['Missed periods', String(watch.session.missed_periods ?? 0)]
      : ['Speed', state.value.phase === 'running' ? `${fixed(frame?.reached_speed, 2)}×` : '–'],
  ];
  const list = element('readouts');
  if (list.children.length !== numbers.length) {
    list.replaceChildren(...numbers.map(() => {
      const box = document.createElement('div');
      box.append(document.createElement('dt'), document.createElement('dd'));
      return box;
    }));
  }
  numbers.forEach(([name, value, bad], i) => {
    const [term, number] = list.children[i].children;
    if (term.textContent !== name) term.textContent = name;
    if (number.textContent !== value) number.textContent = value;
    list.children[i].classList.toggle('bad', Boolean(bad));
  });
  describe(runControl, view, fixed(sample?.force[axis], 1), target);
}

/** Describes the scene and the force plot for screen readers. @type {(runControl: RunControl, view: View, value: string, target: number | null | undefined) => void} */
function describe(runControl, view, value, target) {
  const [tool] = [runControl.arm?.tool.position];
  const at = tool ? `, tool at ${tool.map((part) => part.toFixed(3)).join(', ')} m` : '';
  const text = `${view.robot?.name ?? 'The arm'}${at}; contact force ${value} N`;
  const scene = element('scene');
  if (scene.ariaLabel !== text) scene.ariaLabel = text;
  const plot = document.querySelector('[data-plot="force"] canvas');
  if (plot) plot.ariaLabel = `Contact force ${value} N${target === null || target === undefined ? '' : `, desired ${target.toFixed(1)} N`}`;
}

/** Shows the method of the ghost arm in the scene. @type {(runControl: RunControl) => void} */
export function drawSceneLegend(runControl) {
  const list = element('scene-legend');
  const ghost = runControl.ghost ? methodName(runControl.ghost.simulation.method) : '';
  if (list.dataset.ghost === ghost) return;
  list.dataset.ghost = ghost;
  if (!ghost) {
    list.replaceChildren();
    return;
  }
  const item = document.createElement('li');
  item.append(entry('ghost', palette().ghost, ghost));
  list.replaceChildren(item);
}
