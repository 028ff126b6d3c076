// The legends of the plots and of the scene.

import { cards } from './figures.js';
import { forceAxes, forceLabel } from './force_plot.js';
import { hexOf } from './ghost_curves.js';
import { element } from './notices.js';
import { distance } from './number.js';
import { DASHES } from './plots.js';
import { tasksShown } from './pose_plot.js';
import { nearestText } from './overlay.js';
import { distanceTo } from './target.js';
import { palette } from './theme.js';

/**
 * @typedef {import('./view.js').View} View
 */

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
  const others = (/** @type {string} */ column) => view.ghosts.filter(({ history }) => history.columns[column]).map(({ colour, name }) => entry('ghost', hexOf(colours, colour), name));
  const task = (/** @type {string} */ name, /** @type {number} */ k) =>
    entry((DASHES[k] ?? []).length > 0 ? 'dash' : '', colours.axes[k % 3], name);
  const hasTarget = shown.some((axis) => view.history.hasTarget(axis)) || (view.history.measures?.rows.length ?? 0) > 0;
  /** @type {Record<string, HTMLElement[]>} */
  const content = {
    force: [
      ...shown.map((axis) => entry('', colours.axes[axis], `measured ${forceLabel(view, axis)}`)),
      ...(hasTarget ? [entry('dot', colours.text, 'desired')] : []), ...others('force0'),
    ],
    pose: [...tasksShown(view).map((k) => task(view.tasks[k] ?? String(k + 1), k)), ...others('linear0')],
    residuals: view.tasks.slice(0, 6).map(task),
    velocities: [entry('block', colours.accent, 'rad/s or m/s'), entry('block', colours.allowed, 'current bounds'), entry('block', colours.alarm, '▶ at a limit')],
    positions: [entry('block', colours.accent, 'rad or m'), entry('block', colours.allowed, 'allowed range')],
    limits: [entry('block', colours.alarm, 'upper limit'), entry('block', colours.axes[0], 'lower limit')],
    singularity: [entry('', colours.accent, view.history.measures?.isDependent ? 'directions of the tool' : 'all tasks'), ...others('sigma')],
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

/** Shows in the scene what is drawn: the arms that are compared, shapes, obstacles, and the nearest pair. @type {(world: import('./scene.js').World) => void} */
export function drawSceneLegend({ arm, ghosts, goal, name, room }) {
  const list = element('scene-legend');
  const colours = palette();
  const away = (/** @type {number | null} */ length) => (length === null ? '' : `: ${distance(length)}`);
  const own = ghosts.length > 0 && arm ? [entry('', colours.accent, `${name}${goal ? `${away(distanceTo(goal, arm.tool.position))} to the target` : ''}`)] : [];
  const others = ghosts.map((ghost) => entry('ghost', hexOf(colours, ghost.colour), `${ghost.name}${away(ghost.away)}`));
  const items = [...own, ...others, ...roomEntries(room)].map((line) => {
    const item = document.createElement('li');
    item.append(line);
    return item;
  });
  const text = items.map((item) => item.outerHTML).join('');
  if (list.dataset.shown === text) return;
  list.dataset.shown = text;
  list.replaceChildren(...items);
}

/** @type {(room: import('./room.js').Room | null) => HTMLElement[]} */
function roomEntries(room) {
  if (!room) return [];
  const { room: colours } = palette();
  const [nearest] = room.pairs;
  return [
    ...(room.shapes.length > 0 ? [entry('block', `rgb(${colours.shape})`, 'shapes of the links')] : []),
    ...(room.unknown.length > 0 ? [entry('block', `rgb(${colours.shape})`, `not drawn: ${room.unknown.join(', ')}`)] : []),
    ...(room.obstacles.length > 0 ? [entry('block', `rgb(${colours.obstacle})`, 'obstacles')] : []),
    ...(nearest ? [entry('', colours[nearest.level], nearestText(nearest))] : []),
  ];
}
