// The list of ghosts in the setup: methods and recordings are added and removed here.

import { select as selectScenario } from './editing.js';
import { follow } from './follow.js';
import { entries } from './ghosts.js';
import { colourOf, hexOf } from './ghost_curves.js';
import { element, notify } from './notices.js';
import { readRecording } from './recording.js';
import { MAX_GHOSTS, METHODS, PLAYGROUND } from './setup.js';
import { palette } from './theme.js';

/**
 * @typedef {import('./controls.js').Attempt} Attempt
 * @typedef {import('./ghosts.js').Entry} Entry
 * @typedef {import('./recording.js').Recording} Recording
 * @typedef {import('./run_control.js').RunControl} RunControl
 * @typedef {import('./types.js').Method} Method
 */

/** Maximum number of recordings at a time. */
const MAX_RECORDINGS = 6;

/** Files that are recordings, and files that belong to a robot. */
const RECORDINGS = /\.(csv|json|jsonl|txt)$/i;
const ROBOTS = /\.(urdf|xml|zip|stl|obj|dae|gltf|glb|bin)$/i;

/** The description of a run that revprio writes next to its CSV. */
const DESCRIPTION = /\.recording\.json$/i;

/** Returns whether dropped files are recordings. @type {(files: Map<string, File>) => boolean} */
export const areRecordings = (files) => [...files.keys()].some((name) => RECORDINGS.test(name)) && ![...files.keys()].some((name) => ROBOTS.test(name));

/** @type {(runControl: RunControl, attempt: Attempt, change: (part: Partial<import('./setup.js').Setup>) => void) => void} */
export function bind(runControl, attempt, change) {
  /** @type {HTMLSelectElement} */
  const methods = element('ghost');
  methods.onchange = () => {
    const ghosts = [...new Set([...(runControl.setup?.ghosts ?? []), /** @type {Method} */ (methods.value)])];
    if (methods.value) change({ ghosts });
  };
  /** @type {HTMLInputElement} */
  const picker = element('recordings');
  picker.onchange = () => attempt(async () => {
    const files = Array.from(picker.files ?? []);
    picker.value = '';
    await addRecordings(runControl, attempt, files);
  });
  element('ghosts').onclick = ({ target }) => {
    const button = /** @type {HTMLElement} */ (target).closest('button');
    const entry = entries(runControl).find(({ id }) => id === button?.dataset.id);
    if (!button || !entry) return;
    if (button.dataset.act === 'follow' && entry.recording) attempt(() => follow(runControl, /** @type {Recording} */ (entry.recording)));
    else remove(runControl, entry, change);
  };
}

/** @type {(runControl: RunControl, entry: Entry, change: (part: Partial<import('./setup.js').Setup>) => void) => void} */
function remove(runControl, { id, recording }, change) {
  if (recording) runControl.recordings = runControl.recordings.filter((kept) => kept !== recording);
  else change({ ghosts: (runControl.setup?.ghosts ?? []).filter((method) => `method:${method}` !== id) });
  runControl.onChange();
  element('ghost').focus();
}

/** Reads recordings and shows them as ghosts. @type {(runControl: RunControl, attempt: Attempt, files: File[]) => Promise<void>} */
export async function addRecordings(runControl, attempt, files) {
  const shown = runControl.robot;
  const robots = [...(shown ? [shown] : []), ...runControl.robots.filter(({ name }) => name !== shown?.name)];
  /** @type {Recording[]} */
  const read = [];
  for (const file of files.filter(({ name }) => RECORDINGS.test(name) && !DESCRIPTION.test(name))) read.push(await readRecording(file, robots));
  if (read.length === 0) throw new Error('there is no recording among the files; recordings are CSV, JSON or JSON lines');
  if (runControl.recordings.length + read.length > MAX_RECORDINGS) throw new Error(`the page shows up to ${MAX_RECORDINGS} recordings; remove one first`);
  runControl.recordings = [...runControl.recordings, ...read];
  const [first] = read;
  if (!runControl.watch && first.robot !== runControl.robot?.name) {
    await selectScenario(runControl, PLAYGROUND, first.robot);
    runControl.showSetup();
  }
  runControl.onChange();
  tell(runControl, attempt, read);
}

/** @type {(runControl: RunControl, attempt: Attempt, read: Recording[]) => void} */
function tell(runControl, attempt, read) {
  const facts = read.map(({ name, robot, times, duration }) => `${name}: ${times.length} postures of ${robot} in ${Number(duration.toPrecision(3))} s.`);
  const odd = read.flatMap(({ name, suspicious }) => (suspicious.length > 0 ? [` Joint ${suspicious[0]} of ${name} goes far beyond its range: a recording has rad, not degrees.`] : []));
  const aimed = read.find(({ targets }) => targets !== null);
  const act = aimed && !runControl.watch ? { act: 'Follow its target', onAct: () => attempt(() => follow(runControl, aimed)) } : {};
  notify(read.length === 1 ? 'Recording added as a ghost' : `${read.length} recordings added as ghosts`, `${facts.join(' ')} They play with the time of the run.${odd.join('')}`, { info: odd.length === 0, stays: odd.length > 0 || aimed !== undefined, ...act });
}

/** Shows the list, if it has changed. @type {(runControl: RunControl) => void} */
export function show(runControl) {
  const list = element('ghosts');
  const all = entries(runControl);
  const chosen = runControl.setup?.ghosts ?? [];
  const text = JSON.stringify([all.map(({ id, name, isKnown }) => [id, name, isKnown, runControl.run !== null]), palette().dark, runControl.watch !== null]);
  if (list.dataset.shown === text) return;
  list.dataset.shown = text;
  list.replaceChildren(...all.map((entry) => item(runControl, entry)));
  list.hidden = all.length === 0;
  /** @type {HTMLSelectElement} */
  const methods = element('ghost');
  const free = METHODS.filter(({ value }) => !chosen.includes(value));
  methods.replaceChildren(new Option('add a method …', ''), ...free.map(({ value, name }) => new Option(name, value)));
  methods.disabled = chosen.length >= MAX_GHOSTS;
}

/** @type {(runControl: RunControl, entry: Entry) => HTMLElement} */
function item({ run, watch }, { id, name, isKnown, recording }) {
  const [line, key, label, note] = ['li', 'i', 'span', 'small'].map((tag) => document.createElement(tag));
  key.className = 'key ghost';
  key.style.borderTopColor = hexOf(palette(), colourOf(id));
  label.className = 'task-name';
  label.textContent = name;
  if (recording && !isKnown) note.textContent = `of ${recording.robot}`;
  if (!recording && !isKnown && run) note.textContent = 'next run';
  line.append(key, label, note);
  if (recording?.targets && !watch) line.append(button(id, 'follow', '◎', `Let the run follow the target of ${name}`));
  line.append(button(id, 'remove', '✕', `Remove ghost ${name}`));
  return line;
}

/** @type {(id: string, act: string, text: string, label: string) => HTMLElement} */
function button(id, act, text, label) {
  const made = document.createElement('button');
  Object.assign(made, { type: 'button', className: 'quiet', textContent: text, title: label, ariaLabel: label });
  Object.assign(made.dataset, { id, act });
  return made;
}
