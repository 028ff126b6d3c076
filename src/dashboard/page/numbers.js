// The numbers next to the scene, and the descriptions for screen readers.

import { contactSigns } from './contact_signs.js';
import { forceAxes, forceLabel } from './force_plot.js';
import { toolPose } from './measures.js';
import { element } from './notices.js';
import { angle, distance, fixed, microseconds, scientific } from './number.js';
import { nearestText } from './overlay.js';
import { reason } from './reason.js';
import { methodName } from './setup.js';
import { state } from './state.js';
import { distanceTo, handle } from './target.js';
import { showsForces } from './world.js';

/**
 * @typedef {import('./run_control.js').RunControl} RunControl
 * @typedef {import('./view.js').View} View
 */

/** @type {(counts: number[], part: number) => number} quantile of the times, µs */
function quantile(counts, part) {
  const wanted = part * counts.reduce((sum, count) => sum + count, 0);
  let sum = 0;
  const bin = counts.findIndex((count) => (sum += count) >= wanted);
  return 10 ** (bin / 10);
}

const STATUS = { optimal: 'optimal', not_certified: 'uncertified', failed: 'failed' };

/** @type {(id: string, text: string) => void} */
function setText(id, text) {
  const shown = element(id);
  if (shown.textContent !== text) shown.textContent = text;
}

/** Shows the current numbers. @type {(runControl: RunControl, view: View, room: import('./room.js').Room | null) => void} */
export function drawNumbers(runControl, view, room) {
  const { run, watch } = runControl;
  const { sample } = view;
  const running = watch ? watch.session.controller : run?.simulation;
  setText('caption', methodName(running?.method ?? runControl.setup?.method ?? ''));
  setText('clock', `${fixed(sample?.time_s ?? 0, 3)} s`);
  /** @type {HTMLProgressElement} */ (element('progress')).value = run?.simulation.progress ?? 0;
  const isForce = showsForces(runControl);
  const main = isForce ? drawForce(view) : drawError(runControl, view);
  const why = reason(view);
  setText('reason', why.text);
  element('reason').dataset.kind = why.kind;
  drawReadouts(runControl, view, main);
  const nearest = room?.pairs[0];
  const contacts = contactSigns(view.controller, sample).map(({ text }) => `; ${text}`).join('');
  const text = `${main.text}${contacts}${nearest ? `; nearest ${nearestText(nearest)}` : ''}`;
  describe(runControl, view, text, why.text);
}

/** @type {(view: View) => {text: string, row: [string, string]}} */
function drawForce(view) {
  const { history, sample } = view;
  const [axis] = forceAxes(view);
  const index = view.cursor === null ? history.length - 1 : Math.max(0, history.indexAt(view.cursor));
  const [value, target] = [history.columns[`force${axis}`][index], history.columns[`target${axis}`][index]];
  const hasTarget = index >= 0 && !Number.isNaN(target);
  const shown = sample && index >= 0 ? value : null;
  setText('force-value', fixed(shown, 1));
  setText('force-unit', 'N');
  const desired = hasTarget ? `, desired ${fixed(target, 1)} N` : '';
  // Before the first sample, nothing is known of directions.
  setText('force-target', index < 0 ? '' : `along ${forceLabel(view, axis)}${desired}`);
  element('force-target').title = 'Force of the tool on the environment';
  return {
    text: `contact force ${fixed(shown, 1)} N${desired}`,
    row: ['Force error', hasTarget && shown !== null ? `${fixed(shown - target, 2)} N` : '–'],
  };
}

/** @type {(runControl: RunControl, view: View) => {text: string, row: [string, string]}} */
function drawError(runControl, view) {
  const { history } = view;
  const index = view.cursor === null ? history.length - 1 : Math.max(0, history.indexAt(view.cursor));
  const goal = handle(runControl);
  const controller = view.controller;
  const first = (controller?.tasks ?? []).findIndex((_, k) => index >= 0 && !Number.isNaN(history.columns[`linear${view.order[k] ?? k}`][index]));
  const place = view.order[first] ?? first;
  const linear = first < 0 ? NaN : history.columns[`linear${place}`][index];
  const angular = first < 0 ? NaN : history.columns[`angular${place}`][index];
  setText('force-value', Number.isNaN(linear) ? '–' : fixed(linear * 1e3, 1));
  setText('force-unit', 'mm');
  const name = controller?.tasks[first]?.name ?? goal?.task.name ?? '';
  setText('force-target', name ? `error of “${name}”` : 'pose error');
  const tool = (view.sample ? toolPose(view.sample) : runControl.tool)?.position;
  const away = goal && tool ? distance(distanceTo(goal, tool)) : distance(linear);
  const text = `error of ${name} ${distance(linear)}${Number.isNaN(angular) ? '' : `, ${angle(angular)}`}`;
  return { text, row: ['To the target', away] };
}

/** @type {(runControl: RunControl, view: View, main: {row: [string, string]}) => void} */
function drawReadouts(runControl, view, { row }) {
  const { run, watch } = runControl;
  const { sample } = view;
  const frame = run?.frame;
  const trips = frame?.round_trip;
  const hasTrips = trips && trips.counts.some((count) => count > 0);
  const { sigma } = view;
  /** @type {[string, string, boolean?][]} */
  const numbers = [
    row,
    ['σ min', (sigma ?? 1) < 1e-3 ? scientific(sigma) : fixed(sigma, 4), view.threshold !== null && (sigma ?? 1) < view.threshold],
    ['KKT residual', scientific(sample?.kkt_residual)],
    ['Status', sample ? STATUS[sample.status] : '–', sample !== undefined && sample.status !== 'optimal'],
    watch
      ? ['Compute time', sample ? microseconds(sample.solve_us) : '–']
      : ['Round trip', hasTrips ? microseconds(quantile(trips.counts, 0.5)) : '–'],
    watch
      ? ['Missed periods', String(watch.session.missed_periods ?? 0)]
      : ['Speed', state.value.phase === 'running' ? `${fixed(frame?.reached_speed, 2)}×` : '–'],
  ];
  for (const [name, value] of Object.entries(sample?.channels ?? {})) numbers.push([name, fixed(value, 4)]);
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
}

/** Describes the scene and the plots for screen readers. @type {(runControl: RunControl, view: View, main: string, why: string) => void} */
function describe(runControl, view, main, why) {
  const tool = view.arm?.tool.position;
  const at = tool ? `, tool at ${tool.map((part) => fixed(part, 3)).join(', ')} m` : '';
  const text = `${view.robot?.name ?? 'The arm'}${at}; ${main}. ${why}`;
  const scene = element('scene');
  if (scene.ariaLabel !== text) scene.ariaLabel = text;
  for (const plot of ['force', 'pose']) {
    const canvas = document.querySelector(`[data-plot="${plot}"] canvas`);
    const isMain = showsForces(runControl) === (plot === 'force');
    if (canvas && isMain) canvas.ariaLabel = main.charAt(0).toUpperCase() + main.slice(1);
  }
}
