// The set-up form and the buttons of a run.

import { element } from './notices.js';
import * as setups from './setup.js';
import { state } from './state.js';
import { sessions } from './watch.js';

/**
 * @typedef {import('./desk.js').Desk} Desk
 * @typedef {import('./setup.js').Setup} Setup
 * @typedef {import('./setup.js').Gain} Gain
 * @typedef {(work: () => Promise<unknown>) => void} Attempt does something and explains why it fails
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
 * @param {Desk} desk
 * @param {Attempt} attempt
 */
export function bind(desk, attempt) {
  options(select('method'), setups.METHODS);
  options(select('ghost'), [{ value: '', name: 'nothing' }, ...setups.METHODS]);
  options(select('solver'), setups.SOLVERS);
  bindSetup(desk, attempt);
  bindRun(desk, attempt);
  bindSessions(desk, attempt);
  state.subscribe(() => showState(desk));
}

/** @type {(list: HTMLSelectElement, words: {value: string, name: string}[]) => void} */
function options(list, words) {
  list.replaceChildren(...words.map(({ value, name }) => new Option(name, value)));
}

/** @type {(desk: Desk, attempt: Attempt) => void} */
function bindSetup(desk, attempt) {
  const keep = () => {
    if (desk.setup && desk.scenario) history.replaceState(null, '', `#${setups.toFragment(desk.setup, desk.scenario)}`);
  };
  const change = (/** @type {Partial<Setup>} */ part) => {
    attempt(() => desk.change(part));
    keep();
  };
  select('scenario').onchange = () => attempt(async () => {
    await desk.choose(select('scenario').value);
    showSetup(desk, change);
    keep();
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
  button('apply').onclick = () => attempt(() => desk.start(state.value.phase === 'paused'));
  desk.showSetup = () => showSetup(desk, change);
}

/** @type {(power: number) => number} a round speed */
function speedOf(power) {
  return Number((10 ** power).toPrecision(2));
}

/** @type {(desk: Desk, change: (part: Partial<Setup>) => void) => void} */
function showSetup(desk, change) {
  const { setup, scenario } = desk;
  if (!setup || !scenario) return;
  options(select('scenario'), desk.scenarios.map(({ name }) => ({ value: name, name: name.replaceAll('_', ' ') })));
  select('scenario').value = setup.scenario;
  element('description').textContent = scenario.description;
  select('method').value = setup.method;
  select('ghost').value = setup.ghost;
  select('solver').value = setup.solver;
  input('speed').value = String(Math.log10(setup.speed));
  element('speed-value').textContent = `${setup.speed}×`;
  input('lag').value = String(1000 * (setup.lag ?? scenario.velocity_loop?.lag_s ?? 0));
  const isOpen = Boolean(element('gains').querySelector('details[open]'));
  element('gains').replaceChildren(gainFields(desk, change, isOpen));
  element('contacts').replaceChildren(...contactFields(desk, change));
}

/** @type {(desk: Desk, change: (part: Partial<Setup>) => void, open: boolean) => HTMLElement} */
function gainFields(desk, change, open) {
  const { setup, scenario } = desk;
  const box = document.createElement('details');
  box.className = 'inner';
  box.open = open;
  box.append(summary('Gains of the tasks'));
  scenario?.controller.tasks.forEach((task, k) => {
    const title = document.createElement('h3');
    title.textContent = `${k + 1}. ${task.name}, ${task.law.kind}`;
    const known = setups.GAINS.filter((gain) => setups.gainOf(scenario, k, gain));
    const fields = known.map((gain) => {
      const place = `${k}.${gain}`;
      const values = setup?.gains[place] ?? setups.gainOf(scenario, k, gain) ?? [];
      return numberField(GAIN_NAMES[gain], GAIN_SIGNS[gain], values, (changed) =>
        change({ gains: { ...desk.setup?.gains, [place]: changed } }));
    });
    if (fields.length > 0) box.append(title, ...fields);
  });
  return box;
}

/** @type {(desk: Desk, change: (part: Partial<Setup>) => void) => HTMLElement[]} */
function contactFields(desk, change) {
  const contacts = desk.scenario?.contacts ?? [];
  return contacts.map((contact, i) => {
    const values = [desk.setup?.stiffness[i] ?? contact.stiffness];
    const name = `Stiffness of the ${contact.kind}${contact.axis ? `, ${contact.axis}` : ''}`;
    return numberField(name, 'N/m', values, ([stiffness]) =>
      change({ stiffness: { ...desk.setup?.stiffness, [i]: stiffness } }));
  });
}

/** @type {(text: string) => HTMLElement} */
function summary(text) {
  const line = document.createElement('summary');
  line.textContent = text;
  return line;
}

/**
 * A field of numbers, one for each axis.
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
  field.title = values.length > 1 ? 'One number for each axis' : '';
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

/** @type {(desk: Desk, attempt: Attempt) => void} */
function bindRun(desk, attempt) {
  const step = () => attempt(() => desk.step(Number(select('step-size').value)));
  button('go').onclick = () => attempt(() => desk.go());
  button('step').onclick = step;
  button('reset').onclick = () => attempt(async () => desk.reset());
  button('end').onclick = () => attempt(() => desk.end());
  /** @type {Record<string, () => void>} */
  const keys = {
    ' ': () => button('go').click(), s: () => button('step').click(), r: () => button('reset').click(), e: () => button('end').click(),
  };
  addEventListener('keydown', (event) => {
    const target = /** @type {HTMLElement} */ (event.target);
    const types = target.closest('input, select, textarea, dialog, summary, a') || (event.key === ' ' && target.closest('button'));
    if (types || event.ctrlKey || event.metaKey || event.altKey || event.repeat) return;
    const act = keys[event.key];
    if (!act || state.value.source === 'session') return;
    event.preventDefault();
    act();
  });
}

/** @type {(desk: Desk, attempt: Attempt) => void} */
function bindSessions(desk, attempt) {
  for (const choice of /** @type {NodeListOf<HTMLInputElement>} */ (document.querySelectorAll('input[name="source"]'))) {
    choice.onchange = () => {
      const source = choice.value === 'session' ? 'session' : 'simulation';
      state.set({ source });
      if (source === 'session') {
        desk.reset();
        attempt(() => listSessions(desk, attempt));
      } else {
        attempt(() => desk.leaveSession());
      }
    };
  }
  select('session').onchange = () => attempt(() => desk.watchSession(select('session').value));
  setInterval(() => {
    const looks = state.value.source === 'session' && state.value.link === 'ready' && document.activeElement !== select('session');
    if (looks) attempt(() => listSessions(desk, attempt));
  }, 3000);
}

/** @type {(desk: Desk, attempt: Attempt) => Promise<void>} */
async function listSessions(desk, attempt) {
  const { controllers } = await sessions();
  const { session } = state.value;
  const known = controllers.map(({ id, robot, steps, idle_s }) => ({
    value: id, name: `${robot}, ${id.slice(0, 8)}: ${steps} steps, ${idle_s < 2 ? 'active' : `idle ${Math.round(idle_s)} s`}`,
  }));
  const none = { value: '', name: known.length > 0 ? 'choose one' : 'no session is open' };
  options(select('session'), [none, ...known]);
  const chosen = session === '' && known.length === 1 ? known[0].value : session;
  select('session').value = controllers.some(({ id }) => id === chosen) ? chosen : '';
  if (chosen !== session) attempt(() => desk.watchSession(chosen));
}

const LINKS = { connecting: 'Connecting', ready: 'Connected', overloaded: 'Overloaded', gone: 'Server gone, trying again', locked: 'Token needed' };
const PHASES = {
  none: 'No run yet', starting: 'Starting', running: 'Running', paused: 'Paused', finished: 'Finished', failed: 'Failed',
  cancelled: 'Cancelled', lost: 'Connection lost', watching: 'Watching, read-only',
};

/** @type {(desk: Desk) => void} */
function showState(desk) {
  const { link, phase, source, pending } = state.value;
  pill('link', link, LINKS[link]);
  pill('phase', phase, source === 'session' && phase === 'none' ? 'No session chosen' : PHASES[phase]);
  element('simulation-form').hidden = source === 'session';
  element('session-form').hidden = source !== 'session';
  for (const part of document.querySelectorAll('.transport, .push')) {
    /** @type {HTMLElement} */ (part).hidden = source === 'session';
  }
  const goesOn = phase === 'running' || phase === 'paused';
  button('go').textContent = phase === 'running' ? 'Pause' : phase === 'paused' ? 'Resume' : phase === 'none' ? 'Run' : 'Run again';
  button('go').disabled = link !== 'ready' || phase === 'starting' || !desk.setup;
  button('step').disabled = link !== 'ready' || phase === 'starting';
  button('reset').disabled = phase === 'none';
  button('end').disabled = !goesOn || link !== 'ready';
  for (const push of /** @type {NodeListOf<HTMLButtonElement>} */ (document.querySelectorAll('[data-push]'))) push.disabled = !goesOn;
  element('pending').hidden = !pending || !goesOn;
  const hasTrace = phase === 'finished' && source === 'simulation';
  for (const id of ['export-csv', 'export-mcap']) {
    button(id).disabled = !hasTrace;
    button(id).title = hasTrace ? 'The trace of this run' : 'The trace can be had once the run has ended: press End';
  }
}

/** @type {(id: string, value: string, text: string) => void} */
function pill(id, value, text) {
  const shown = element(id);
  shown.dataset[id] = value;
  if (shown.textContent !== text) shown.textContent = text;
}
