// Colours of ghosts, and their curves in the plots.

import { curve } from './plot.js';

/** @typedef {import('./view.js').View} View */

/** Colours that are used, by the id of the ghost, as indices in `Palette.ghosts`. @type {Map<string, number>} */
const used = new Map();

/** Returns the colour of a ghost: the first one that no other has. @type {(id: string) => number} */
export function colourOf(id) {
  const known = used.get(id);
  if (known !== undefined) return known;
  const taken = new Set(used.values());
  const free = Array.from({ length: used.size + 1 }, (_, i) => i).find((i) => !taken.has(i)) ?? 0;
  used.set(id, free);
  return free;
}

/** Frees the colours of ghosts that are no longer there. @param {string[]} ids those that are there */
export function keepColours(ids) {
  for (const id of [...used.keys()].filter((known) => !ids.includes(known))) used.delete(id);
}

/** Returns the number of samples of a ghost up to the latest time of the run. @type {(ghost: View['ghosts'][number], view: View) => number} */
export const lengthOf = ({ history }, view) => history.indexAt(view.history.now) + 1;

/** Draws a quantity of all ghosts that have it. @type {(surface: import('./plot.js').Surface, frame: import('./plot.js').Frame, view: View, name: string, colours: import('./theme.js').Palette, style: {width?: number, dash?: number[], floor?: number}) => void} */
export function ghostCurves(surface, frame, view, name, colours, style) {
  for (const ghost of view.ghosts) {
    const { columns } = ghost.history;
    if (columns[name]) curve(surface, frame, columns.time, columns[name], lengthOf(ghost, view), { colour: hexOf(colours, ghost.colour), ...style });
  }
}

/** @type {(colours: import('./theme.js').Palette, index: number) => string} */
export const hexOf = ({ ghosts }, index) => ghosts[index % ghosts.length];
