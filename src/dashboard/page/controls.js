// The setup form and the buttons of a run.

import * as drop from './drop.js';
import * as editing from './editing.js';
import { read } from './fields.js';
import * as ghostsForm from './ghosts_form.js';
import { element } from './notices.js';
import * as obstaclesForm from './obstacles_form.js';
import * as planesForm from './planes_form.js';
import * as pressForm from './press_form.js';
import * as robotsForm from './robots_form.js';
import * as sessionsForm from './sessions_form.js';
import * as setups from './setup.js';
import { state } from './state.js';
import { focusMoved, gainFields, numberField, taskItems } from './tasks_form.js';
import { isInBrowser } from './transport.js';
import { showsForces } from './world.js';

/**
 * @typedef {import('./run_control.js').RunControl} RunControl
 * @typedef {import('./setup.js').Setup} Setup
 * @typedef {(work: () => Promise<unknown>) => void} Attempt runs `work` and shows its error
 */

/** @type {(id: string) => HTMLSelectElement} */
const select = (id) => element(id);
/** @type {(id: string) => HTMLInputElement} */
const input = (id) => element(id);
/** @type {(id: string) => HTMLButtonElement} */
const button = (id) => element(id);

/**
 * @param {RunControl} runControl
 * @param {Attempt} attempt
 */
export function bind(runControl, attempt) {
  options(select('method'), setups.METHODS);
  options(select('solver'), setups.SOLVERS);
  bindSetup(runControl, attempt);
  bindRun(runControl, attempt);
  sessionsForm.bind(runControl, attempt);
  robotsForm.bind(runControl, attempt);
  pressForm.bind(runControl, attempt);
  drop.bind(attempt, (files) => (ghostsForm.areRecordings(files)
    ? ghostsForm.addRecordings(runControl, attempt, [...files.values()]) : robotsForm.register(runControl, files)));
  state.subscribe(() => showState(runControl));
}

/** @type {(list: HTMLSelectElement, words: {value: string, name: string}[]) => void} */
function options(list, words) {
  list.replaceChildren(...words.map(({ value, name }) => new Option(name, value)));
}

/** @type {(runControl: RunControl, attempt: Attempt) => void} */
function bindSetup(runControl, attempt) {
  const saveInAddress = () => {
    const { setup, scenario } = runControl;
    if (setup && scenario) history.replaceState(null, '', `#${setups.toFragment(setup, scenario)}`);
  };
  const change = (/** @type {setups.Change} */ part) => {
    attempt(async () => {
      await runControl.change(part);
      saveInAddress();
      if (typeof part === 'function' || part.order) showLists(runControl, change);
    });
  };
  planesForm.bind(runControl, change);
  obstaclesForm.bind(runControl, change);
  ghostsForm.bind(runControl, attempt, change);
  button('undo').onclick = () => attempt(async () => {
    await editing.undo(runControl);
    showSetup(runControl, change);
    saveInAddress();
  });
  select('scenario').onchange = () => attempt(async () => {
    const name = select('scenario').value;
    await editing.select(runControl, name, name === setups.PLAYGROUND ? (runControl.robot?.name ?? '') : '');
    showSetup(runControl, change);
    saveInAddress();
  });
  select('method').onchange = () => change({ method: /** @type {Setup['method']} */ (select('method').value) });
  select('motion').onchange = () => attempt(async () => {
    const motion = /** @type {Setup['motion']} */ (select('motion').value);
    if (runControl.setup?.motion === 'recorded') await editing.select(runControl, setups.PLAYGROUND, runControl.setup.robot);
    await runControl.change({ motion, targets: {} });
    runControl.showSetup();
  });
  select('solver').onchange = () => change({ solver: /** @type {Setup['solver']} */ (select('solver').value) });
  input('lag').onchange = () => {
    const lag = read(input('lag'));
    if (lag) change({ lag: lag[0] / 1000 });
  };
  input('speed').oninput = () => {
    const speed = speedOf(Number(input('speed').value));
    element('speed-value').textContent = `${speed}×`;
    change({ speed });
  };
  button('apply').onclick = () => attempt(() => runControl.start(runControl.isPaused));
  runControl.showSetup = () => {
    showSetup(runControl, change);
    saveInAddress();
  };
}

/** @type {(power: number) => number} 10 to this power, with two digits */
function speedOf(power) {
  return Number((10 ** power).toPrecision(2));
}

/** @type {(runControl: RunControl, change: (part: setups.Change) => void) => void} */
function showSetup(runControl, change) {
  const { setup, scenario } = runControl;
  if (!setup || !scenario) return;
  const names = runControl.scenarios.map(({ name }) => name).filter((name) => name !== setups.PLAYGROUND);
  const entries = names.map((name) => ({ value: name, name: name.replaceAll('_', ' ') }));
  options(select('scenario'), [{ value: setups.PLAYGROUND, name: 'playground, any robot' }, ...entries]);
  select('scenario').value = setup.scenario;
  element('description').textContent = setup.motion === 'eight' ? scenario.description.replace('at rest', 'follows a figure of eight') : scenario.description;
  select('method').value = setup.method;
  const recorded = /** @type {HTMLOptionElement} */ (element('recorded'));
  recorded.hidden = setup.motion !== 'recorded';
  recorded.disabled = recorded.hidden;
  select('motion').value = setup.motion;
  element('motion-field').hidden = setup.scenario !== setups.PLAYGROUND || setup.press !== null;
  select('solver').value = setup.solver;
  input('speed').value = String(Math.log10(setup.speed));
  element('speed-value').textContent = `${setup.speed}×`;
  input('lag').value = String(1000 * (setup.lag ?? scenario.velocity_loop?.lag_s ?? 0));
  const isOpen = Boolean(element('gains').querySelector('details[open]'));
  element('gains').replaceChildren(gainFields(runControl, change, isOpen));
  showLists(runControl, change);
  robotsForm.showRobots(runControl);
  pressForm.show(setup.press);
  element('contacts').replaceChildren(...contactFields(runControl, change));
}

/** Shows tasks, planes and obstacles. @type {(runControl: RunControl, change: (part: setups.Change) => void) => void} */
function showLists(runControl, change) {
  element('tasks').replaceChildren(...taskItems(runControl, change));
  focusMoved();
  element('planes').replaceChildren(...planesForm.planeItems(runControl, change));
  obstaclesForm.show(runControl, change);
}

/** @type {(runControl: RunControl, change: (part: setups.Change) => void) => HTMLElement[]} */
function contactFields(runControl, change) {
  const contacts = runControl.scenario?.contacts ?? [];
  return contacts.map((contact, i) => {
    const values = [runControl.setup?.stiffness[i] ?? contact.stiffness];
    const name = `Stiffness of the ${contact.kind}${contact.axis ? `, ${contact.axis}` : ''}`;
    return numberField(name, 'N/m', values, ([stiffness]) =>
      change({ stiffness: { ...runControl.setup?.stiffness, [i]: stiffness } }));
  });
}

/** @type {(runControl: RunControl, attempt: Attempt) => void} */
function bindRun(runControl, attempt) {
  const step = () => attempt(() => runControl.step(Number(select('step-size').value)));
  button('go').onclick = () => attempt(() => runControl.togglePause());
  button('step').onclick = step;
  button('reset').onclick = () => attempt(async () => runControl.reset());
  button('end').onclick = () => attempt(() => runControl.end());
  /** @type {Record<string, () => void>} */
  const keys = {
    ' ': () => button('go').click(), s: () => button('step').click(), r: () => button('reset').click(), e: () => button('end').click(),
  };
  addEventListener('keydown', (event) => {
    const isText = /** @type {HTMLElement} */ (event.target).matches('input:not([type="range"], [type="radio"]), textarea');
    if ((event.ctrlKey || event.metaKey) && event.key === 'z' && !isText) {
      event.preventDefault();
      button('undo').click();
    }
    const target = /** @type {HTMLElement} */ (event.target);
    const isControl = target.closest('input:not([type="range"]), select, textarea, dialog, summary, a') || (event.key === ' ' && target.closest('button'));
    if (isControl || event.ctrlKey || event.metaKey || event.altKey || event.repeat) return;
    const act = keys[event.key];
    if (!act || state.value.source === 'session') return;
    event.preventDefault();
    act();
  });
}

const CONNECTIONS = {
  connecting: 'Connecting', ready: 'Connected', overloaded: 'Overloaded', unreachable: 'Server not reachable, retrying',
  token_needed: 'Token needed',
};
const PHASES = {
  none: 'No run yet', starting: 'Starting', running: 'Running', paused: 'Paused', finished: 'Finished', failed: 'Failed',
  cancelled: 'Cancelled', lost: 'Connection lost', watching: 'Watching, read-only',
};

/** @type {(runControl: RunControl) => void} */
function showState(runControl) {
  const { connection, phase, source, pending } = state.value;
  const isLocal = connection === 'ready' && isInBrowser();
  setPill('connection', connection, isLocal ? 'In this browser' : CONNECTIONS[connection]);
  document.body.dataset.service = isLocal ? 'browser' : 'server';
  for (const option of select('solver').options) option.disabled = isLocal && option.value === 'qp';
  setPill('phase', phase, source === 'session' && phase === 'none' ? 'No session selected' : PHASES[phase]);
  for (const choice of /** @type {NodeListOf<HTMLInputElement>} */ (document.querySelectorAll('input[name="source"]'))) choice.checked = choice.value === source;
  element('simulation-form').hidden = source === 'session';
  element('session-form').hidden = source !== 'session';
  for (const part of document.querySelectorAll('.transport, .push, #target-keys')) {
    /** @type {HTMLElement} */ (part).hidden = source === 'session';
  }
  const isActive = phase === 'running' || phase === 'paused';
  button('go').textContent = phase === 'running' ? 'Pause' : phase === 'paused' ? 'Resume' : phase === 'none' ? 'Run' : 'Run again';
  button('go').disabled = connection !== 'ready' || phase === 'starting' || !runControl.setup;
  button('step').disabled = connection !== 'ready' || phase === 'starting';
  button('reset').disabled = phase === 'none';
  button('end').disabled = !isActive || connection !== 'ready';
  for (const push of /** @type {NodeListOf<HTMLButtonElement>} */ (document.querySelectorAll('[data-push]'))) push.disabled = !isActive;
  element('pending').hidden = !pending || !isActive;
  refresh(runControl);
  const hasTrace = phase === 'finished' && source === 'simulation';
  for (const id of ['export-csv', 'export-mcap']) {
    button(id).disabled = !hasTrace;
    button(id).title = hasTrace ? 'The trace of this run' : 'The trace is available when the run has ended: press End';
  }
}

/** Hides plots that would stay empty, and enables undo. @type {(runControl: RunControl) => void} */
export function refresh(runControl) {
  ghostsForm.show(runControl);
  button('undo').disabled = runControl.undoable.length === 0 || runControl.watch !== null;
  const controller = runControl.watch?.session.controller ?? runControl.scenario?.controller;
  const hasPoses = (controller?.tasks ?? []).some(({ law }) => law && law.kind !== 'force');
  const shown = /** @type {Record<string, boolean>} */ ({
    force: showsForces(runControl), pose: hasPoses, trips: runControl.watch === null,
  });
  for (const [plot, isShown] of Object.entries(shown)) {
    const card = /** @type {HTMLElement | null} */ (document.querySelector(`[data-plot="${plot}"]`));
    if (card && card.hidden === isShown) card.hidden = !isShown;
  }
}

/** @type {(id: string, value: string, text: string) => void} */
function setPill(id, value, text) {
  const shown = element(id);
  shown.dataset[id] = value;
  if (shown.textContent !== text) shown.textContent = text;
}
