// The setup form and the buttons of a run.

import { element } from './notices.js';
import * as setups from './setup.js';
import { state } from './state.js';
import { sessions } from './watch.js';

/**
 * @typedef {import('./run_control.js').RunControl} RunControl
 * @typedef {import('./setup.js').Setup} Setup
 * @typedef {import('./setup.js').Gain} Gain
 * @typedef {(work: () => Promise<unknown>) => void} Attempt runs `work` and shows its error
 */

/** @type {(id: string) => HTMLSelectElement} */
const select = (id) => element(id);
/** @type {(id: string) => HTMLInputElement} */
const input = (id) => element(id);
/** @type {(id: string) => HTMLButtonElement} */
const button = (id) => element(id);

const GAIN_NAMES = { inertia: 'Inertia', damping: 'Damping', stiffness: 'Stiffness' };
const GAIN_SIGNS = { inertia: 'M_d', damping: 'B_d', stiffness: 'K_d' };

/**
 * @param {RunControl} runControl
 * @param {Attempt} attempt
 */
export function bind(runControl, attempt) {
  options(select('method'), setups.METHODS);
  options(select('ghost'), [{ value: '', name: 'nothing' }, ...setups.METHODS]);
  options(select('solver'), setups.SOLVERS);
  bindSetup(runControl, attempt);
  bindRun(runControl, attempt);
  bindSessions(runControl, attempt);
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
  const change = (/** @type {Partial<Setup>} */ part) => {
    attempt(() => runControl.change(part));
    saveInAddress();
  };
  select('scenario').onchange = () => attempt(async () => {
    await runControl.selectScenario(select('scenario').value);
    showSetup(runControl, change);
    saveInAddress();
  });
  select('method').onchange = () => change({ method: /** @type {Setup['method']} */ (select('method').value) });
  select('ghost').onchange = () => change({ ghost: /** @type {Setup['ghost']} */ (select('ghost').value) });
  select('solver').onchange = () => change({ solver: /** @type {Setup['solver']} */ (select('solver').value) });
  input('lag').onchange = () => {
    const lag = setups.numbers(input('lag').value);
    input('lag').ariaInvalid = String(!lag);
    if (lag) change({ lag: lag[0] / 1000 });
  };
  input('speed').oninput = () => {
    const speed = speedOf(Number(input('speed').value));
    element('speed-value').textContent = `${speed}×`;
    change({ speed });
  };
  button('apply').onclick = () => attempt(() => runControl.start(state.value.phase === 'paused'));
  runControl.showSetup = () => showSetup(runControl, change);
}

/** @type {(power: number) => number} 10 to this power, with two digits */
function speedOf(power) {
  return Number((10 ** power).toPrecision(2));
}

/** @type {(runControl: RunControl, change: (part: Partial<Setup>) => void) => void} */
function showSetup(runControl, change) {
  const { setup, scenario } = runControl;
  if (!setup || !scenario) return;
  options(select('scenario'), runControl.scenarios.map(({ name }) => ({ value: name, name: name.replaceAll('_', ' ') })));
  select('scenario').value = setup.scenario;
  element('description').textContent = scenario.description;
  select('method').value = setup.method;
  select('ghost').value = setup.ghost;
  select('solver').value = setup.solver;
  input('speed').value = String(Math.log10(setup.speed));
  element('speed-value').textContent = `${setup.speed}×`;
  input('lag').value = String(1000 * (setup.lag ?? scenario.velocity_loop?.lag_s ?? 0));
  const isOpen = Boolean(element('gains').querySelector('details[open]'));
  element('gains').replaceChildren(gainFields(runControl, change, isOpen));
  element('contacts').replaceChildren(...contactFields(runControl, change));
}

/** @type {(runControl: RunControl, change: (part: Partial<Setup>) => void, open: boolean) => HTMLElement} */
function gainFields(runControl, change, open) {
  const { setup, scenario } = runControl;
  const box = document.createElement('details');
  box.className = 'inner';
  box.open = open;
  box.append(summary('Task gains'));
  scenario?.controller.tasks.forEach((task, k) => {
    const title = document.createElement('h3');
    title.textContent = `${k + 1}. ${task.name}, ${task.law?.kind ?? 'bounds'}`;
    const known = setups.GAINS.filter((gain) => setups.gainOf(scenario, k, gain));
    const fields = known.map((gain) => {
      const key = `${k}.${gain}`;
      const values = setup?.gains[key] ?? setups.gainOf(scenario, k, gain) ?? [];
      return numberField(GAIN_NAMES[gain], GAIN_SIGNS[gain], values, (changed) =>
        change({ gains: { ...runControl.setup?.gains, [key]: changed } }));
    });
    if (fields.length > 0) box.append(title, ...fields);
  });
  return box;
}

/** @type {(runControl: RunControl, change: (part: Partial<Setup>) => void) => HTMLElement[]} */
function contactFields(runControl, change) {
  const contacts = runControl.scenario?.contacts ?? [];
  return contacts.map((contact, i) => {
    const values = [runControl.setup?.stiffness[i] ?? contact.stiffness];
    const name = `Stiffness of the ${contact.kind}${contact.axis ? `, ${contact.axis}` : ''}`;
    return numberField(name, 'N/m', values, ([stiffness]) =>
      change({ stiffness: { ...runControl.setup?.stiffness, [i]: stiffness } }));
  });
}

/** @type {(text: string) => HTMLElement} */
function summary(text) {
  const line = document.createElement('summary');
  line.textContent = text;
  return line;
}

/**
 * Returns an input field for a list of numbers.
 * @param {string} name
 * @param {string} unit
 * @param {number[]} values
 * @param {(values: number[]) => void} onChange
 */
function numberField(name, unit, values, onChange) {
  const label = document.createElement('label');
  label.className = 'field row';
  const [side, field] = [document.createElement('span'), document.createElement('input')];
  side.className = 'unit';
  field.inputMode = 'decimal';
  field.value = values.map(String).join(' ');
  field.title = values.length > 1 ? 'One number per axis' : '';
  field.onchange = () => {
    const read = setups.numbers(field.value);
    const fits = read !== null && read.length === values.length;
    field.ariaInvalid = String(!fits);
    if (fits) onChange(read);
  };
  side.append(field, unit);
  label.append(name, side);
  return label;
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
    const target = /** @type {HTMLElement} */ (event.target);
    const isControl = target.closest('input, select, textarea, dialog, summary, a') || (event.key === ' ' && target.closest('button'));
    if (isControl || event.ctrlKey || event.metaKey || event.altKey || event.repeat) return;
    const act = keys[event.key];
    if (!act || state.value.source === 'session') return;
    event.preventDefault();
    act();
  });
}

/** @type {(runControl: RunControl, attempt: Attempt) => void} */
function bindSessions(runControl, attempt) {
  for (const choice of /** @type {NodeListOf<HTMLInputElement>} */ (document.querySelectorAll('input[name="source"]'))) {
    choice.onchange = () => {
      const source = choice.value === 'session' ? 'session' : 'simulation';
      state.set({ source });
      if (source === 'session') {
        runControl.reset();
        attempt(() => listSessions(runControl, attempt));
      } else {
        attempt(() => runControl.leaveSession());
      }
    };
  }
  select('session').onchange = () => attempt(() => runControl.watchSession(select('session').value));
  setInterval(() => {
    const { source, connection } = state.value;
    const refreshes = source === 'session' && connection === 'ready' && document.activeElement !== select('session');
    if (refreshes) attempt(() => listSessions(runControl, attempt));
  }, 3000);
}

/** @type {(runControl: RunControl, attempt: Attempt) => Promise<void>} */
async function listSessions(runControl, attempt) {
  const { controllers } = await sessions();
  const { session } = state.value;
  const known = controllers.map(({ id, robot, steps, idle_s }) => ({
    value: id, name: `${robot}, ${id.slice(0, 8)}: ${steps} steps, ${idle_s < 2 ? 'active' : `idle ${Math.round(idle_s)} s`}`,
  }));
  const none = { value: '', name: known.length > 0 ? 'select a session' : 'no session is open' };
  options(select('session'), [none, ...known]);
  const chosen = session === '' && known.length === 1 ? known[0].value : session;
  select('session').value = controllers.some(({ id }) => id === chosen) ? chosen : '';
  if (chosen !== session) attempt(() => runControl.watchSession(chosen));
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
  setPill('connection', connection, CONNECTIONS[connection]);
  setPill('phase', phase, source === 'session' && phase === 'none' ? 'No session selected' : PHASES[phase]);
  element('simulation-form').hidden = source === 'session';
  element('session-form').hidden = source !== 'session';
  for (const part of document.querySelectorAll('.transport, .push')) {
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
  const hasTrace = phase === 'finished' && source === 'simulation';
  for (const id of ['export-csv', 'export-mcap']) {
    button(id).disabled = !hasTrace;
    button(id).title = hasTrace ? 'The trace of this run' : 'The trace is available when the run has ended: press End';
  }
}

/** @type {(id: string, value: string, text: string) => void} */
function setPill(id, value, text) {
  const shown = element(id);
  shown.dataset[id] = value;
  if (shown.textContent !== text) shown.textContent = text;
}
