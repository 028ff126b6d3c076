// Links to what is on the screen: made here, and restored when the page opens.

import * as compare from './compare.js';
import { element, notify } from './notices.js';
import { fixed } from './number.js';
import { toFragment } from './setup.js';
import { MAX_LINK, packed, registerShared } from './shared_robot.js';
import { isDamaged, viewText } from './shared_state.js';
import { state } from './state.js';
import { shownSample } from './view.js';

/**
 * @typedef {import('./run_control.js').RunControl} RunControl
 * @typedef {import('./scene.js').Scene} Scene
 */

/** Longest time that a link restores, s, and the longest time for which the page waits for it, ms. */
const LONGEST = 60;
const PATIENCE = 60_000;

/** Number of steps in which the page runs to the time of a link, and the largest number of periods of them together. */
const PIECES = 40;
const MAX_STEPS = 100_000;

/** What a link cannot restore, by its word in the link. @type {Record<string, string>} */
const LOSSES = {
  changes: 'changes during the run (the link applies them from the start)',
  pushes: 'pushes',
  recordings: 'recordings (send the files, too)',
  following: 'the target of a recording',
  meshes: 'the meshes of the robot',
  robot: 'the robot, whose URDF file is too long',
  session: 'the live session',
};

/** Returns the words of what a link cannot restore. @type {(runControl: RunControl) => string[]} */
function lossesOf(runControl) {
  const { run, watch, recordings, setup, robot, wasPushed, history, visuals, dropped } = runControl;
  const shapes = (dropped.has(robot?.name ?? '') && visuals.get(robot?.name ?? '')?.shapes) || [];
  const words = {
    changes: run !== null && history.marks.length > 0, pushes: run !== null && wasPushed, recordings: recordings.length > 0,
    following: setup?.motion === 'recorded', meshes: shapes.some(({ shape }) => shape.geometry.kind === 'mesh'), session: watch !== null,
  };
  return Object.entries(words).flatMap(([word, isLost]) => (isLost ? [word] : []));
}

/** Returns a link to the setup, the view, the shown time and a dropped robot, and what it cannot restore. @type {(runControl: RunControl, scene: Scene) => Promise<{link: string, lost: string}>} */
export async function linkOf(runControl, scene) {
  const { setup, scenario, dropped, cursor } = runControl;
  const lost = lossesOf(runControl);
  const text = new URLSearchParams(setup && scenario ? toFragment(setup, scenario) : '');
  const isAtRest = ['paused', 'finished', 'cancelled'].includes(state.value.phase);
  const time = cursor !== null || isAtRest ? (shownSample(runControl)?.time_s ?? 0) : 0;
  if (time > 0) text.set('time', String(Number(time.toFixed(4))));
  if (compare.toText()) text.set('compare', compare.toText());
  const registration = dropped.get(setup?.robot ?? '');
  const robot = registration && typeof CompressionStream !== 'undefined' ? await packed(registration) : '';
  if (robot.length > MAX_LINK || (registration && !robot)) lost.push('robot');
  else if (robot) text.set('urdf', robot);
  if (lost.length > 0) text.set('lost', lost.join(','));
  return { link: `${location.origin}${location.pathname}#${text}&view=${viewText(scene.camera)}`, lost: listed(lost) };
}

/** @type {(words: string[]) => string} */
const listed = (words) => Object.keys(LOSSES).filter((word) => words.includes(word)).map((word) => LOSSES[word]).join('; ');

/** The fragment with which the page was opened. It is read once. */
const opened = new URLSearchParams(location.hash.slice(1));

/** Lets a run control read what links have besides the setup. @param {RunControl} runControl */
export function bind(runControl) {
  compare.fromText(opened.get('compare'));
  if (isDamaged(opened.get('state'))) notify('A part of the link is damaged', 'planes, obstacles or targets that cannot be read are left out');
  // The page reads a link when it is opened.
  addEventListener('hashchange', () => {
    if (new URLSearchParams(location.hash.slice(1)).has('scenario')) location.reload();
  });
  const skip = /** @type {HTMLAnchorElement} */ (document.querySelector('.skip'));
  skip.onclick = () => {
    element('go').focus();
    return false;
  };
  runControl.robotOfLink = async () => {
    const text = opened.get('urdf');
    if (!text) return '';
    opened.delete('urdf');
    try {
      return await registerShared(runControl, text, opened.get('robot') ?? '');
    } catch (error) {
      notify('The robot of the link was not loaded', error instanceof Error ? error.message : String(error));
      return '';
    }
  };
}

/** Runs to the time of the link and shows it; says what the link could not restore. Returns whether it has a time. @type {(runControl: RunControl) => Promise<boolean>} */
export async function restore(runControl) {
  const wanted = Number(opened.get('time'));
  const lost = listed((opened.get('lost') ?? '').slice(0, 200).split(','));
  opened.delete('time');
  opened.delete('lost');
  const hasTime = Number.isFinite(wanted) && wanted > 0;
  const time = hasTime ? await showTime(runControl, wanted) : null;
  const reached = time === null ? '' : `The scenario was run again up to ${fixed(time, 3)} s.`;
  const shown = `${fixed(Math.min(wanted, 1e6), 3)} s`;
  const isShort = time !== null && time < wanted - 1e-3;
  const limit = isShort ? ` The link shows ${shown}, which is beyond the end of the scenario or ${LONGEST} s.` : hasTime && time === null ? ` The run did not get to the ${shown} of the link.` : '';
  const missing = lost ? ` The link does not have: ${lost}.` : '';
  if (limit || missing) notify('Opened from a link', `${reached}${limit}${missing}`.trim());
  return hasTime;
}

/** Runs up to a time and shows it. @type {(runControl: RunControl, wanted: number) => Promise<number | null>} the shown time, s; null if the run did not get there */
async function showTime(runControl, wanted) {
  const { applied } = runControl;
  if (!applied) return null;
  const period = applied.controller.period_s ?? 0.001;
  const time = Math.min(wanted, applied.duration_s, LONGEST, MAX_STEPS * period);
  await runControl.start(true);
  const { run } = runControl;
  const periods = Math.round(time / period) + 1;
  const end = performance.now() + PATIENCE;
  // The service sends a few samples per frame, so many small steps give a past that can be replayed.
  for (let part = 1, done = 0; part <= PIECES && done < periods; part += 1) {
    const next = Math.ceil((periods * part) / PIECES);
    if (next === done) continue;
    await runControl.sendControl({ step: next - done });
    done = next;
    if (!(await hasReached(runControl, (done - 1.5) * period, () => runControl.run !== run || performance.now() > end))) return null;
  }
  return runControl.history.now;
}

/** Waits until all runs have reached a time or ended. @type {(runControl: RunControl, time: number, isLate: () => boolean) => Promise<boolean>} */
async function hasReached(runControl, time, isLate) {
  const isThere = () => [runControl.run, ...runControl.ghosts].every((run) => run && (run.history.now >= time || run.ended));
  while (!isThere()) {
    if (isLate()) return false;
    await new Promise((resolve) => { setTimeout(resolve, 20); });
  }
  return true;
}
