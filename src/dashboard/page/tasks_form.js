// The list of tasks: their order, changed by drag or with the keyboard, and their gains.

import { read } from './fields.js';
import * as setups from './setup.js';

/**
 * @typedef {import('./run_control.js').RunControl} RunControl
 * @typedef {import('./setup.js').Setup} Setup
 * @typedef {import('./setup.js').Gain} Gain
 * @typedef {(part: setups.Change) => void} Change
 */

const GAIN_NAMES = { inertia: 'Inertia', damping: 'Damping', stiffness: 'Stiffness' };
const GAIN_SIGNS = { inertia: 'M_d', damping: 'B_d', stiffness: 'K_d' };

/** Smallest gains of the service. */
const LEAST = { inertia: 1e-6, damping: 0, stiffness: 0 };

const LAWS = /** @type {Record<string, string>} */ ({
  velocity: 'velocity', pose: 'pose', posture: 'posture', contact: 'contact', force: 'force', impedance: 'impedance', hybrid: 'hybrid',
});

/** The task that is dragged: its place in the order. @type {number | null} */
let dragged = null;

/** The place of the task that was moved. @type {number | null} */
let focusNext = null;

/** Returns the items of the list. @type {(runControl: RunControl, change: Change) => HTMLElement[]} */
export function taskItems({ setup, scenario }, change) {
  if (!setup || !scenario) return [];
  const { tasks } = scenario.controller;
  const order = setup.order.length === tasks.length ? setup.order : tasks.map((_, k) => k);
  const move = (/** @type {number} */ from, /** @type {number} */ to) => {
    if (from === to || to < 0 || to >= order.length) return;
    const next = [...order];
    next.splice(to, 0, ...next.splice(from, 1));
    focusNext = to;
    change({ order: next.every((index, k) => index === k) ? [] : next });
  };
  return order.map((index, place) => {
    const task = tasks[index];
    const item = document.createElement('li');
    item.draggable = true;
    const name = document.createElement('span');
    name.className = 'task-name';
    const kind = document.createElement('small');
    kind.textContent = ` ${(task.axes ?? ['joints']).join(' ')}, ${LAWS[task.law?.kind ?? ''] ?? 'bounds'}`;
    name.append(`${place + 1}. ${task.name}`, kind);
    item.append(name, mover('↑', `Move “${task.name}” up`, place > 0, () => move(place, place - 1)),
      mover('↓', `Move “${task.name}” down`, place + 1 < order.length, () => move(place, place + 1)));
    bindDrag(item, place, move);
    return item;
  });
}

/** Moves the focus to the task that was moved; call it after the list was shown again. */
export function focusMoved() {
  if (focusNext === null) return;
  const item = document.querySelectorAll('#tasks li')[focusNext];
  focusNext = null;
  /** @type {HTMLElement | null} */ (item?.querySelector('button:not(:disabled)'))?.focus();
}

/** @type {(text: string, label: string, enabled: boolean, act: () => void) => HTMLElement} */
function mover(text, label, enabled, act) {
  const button = document.createElement('button');
  button.type = 'button';
  button.className = 'quiet';
  button.textContent = text;
  button.ariaLabel = label;
  button.title = label;
  button.disabled = !enabled;
  button.onclick = act;
  return button;
}

/** @type {(item: HTMLElement, place: number, move: (from: number, to: number) => void) => void} */
function bindDrag(item, place, move) {
  item.ondragstart = (event) => {
    dragged = place;
    event.dataTransfer?.setData('text/plain', String(place));
    item.classList.add('dragged');
  };
  item.ondragend = () => {
    dragged = null;
    item.classList.remove('dragged');
  };
  item.ondragover = (event) => {
    if (dragged === null) return;
    event.preventDefault();
    item.classList.add('over');
  };
  item.ondragleave = () => item.classList.remove('over');
  item.ondrop = (event) => {
    event.preventDefault();
    item.classList.remove('over');
    if (dragged !== null) move(dragged, place);
  };
}

/** Returns the fields of the gains. @type {(runControl: RunControl, change: Change, open: boolean) => HTMLElement | string} */
export function gainFields(runControl, change, open) {
  const { setup, scenario } = runControl;
  const box = document.createElement('details');
  box.className = 'inner';
  box.open = open;
  const line = document.createElement('summary');
  line.textContent = 'Task gains';
  box.append(line);
  scenario?.controller.tasks.forEach((task, k) => {
    const title = document.createElement('h3');
    title.textContent = `${task.name}, ${task.law?.kind ?? 'bounds'}`;
    const known = setups.GAINS.filter((gain) => setups.gainOf(scenario, k, gain));
    const fields = known.map((gain) => {
      const key = `${k}.${gain}`;
      const values = setup?.gains[key] ?? setups.gainOf(scenario, k, gain) ?? [];
      return numberField(GAIN_NAMES[gain], GAIN_SIGNS[gain], values, (changed) => {
        change(({ gains }) => {
          const { [key]: _, ...others } = gains;
          return { gains: { ...others, [key]: changed } };
        });
      }, LEAST[gain]);
    });
    if (fields.length > 0) box.append(title, ...fields);
  });
  return box.children.length > 1 ? box : '';
}

/**
 * Returns an input field for a list of numbers.
 * @param {string} name
 * @param {string} unit
 * @param {number[]} values
 * @param {(values: number[]) => void} onChange
 * @param {number} [least] number that it accepts
 */
export function numberField(name, unit, values, onChange, least = 0) {
  const label = document.createElement('label');
  label.className = 'field row';
  const [side, field] = [document.createElement('span'), document.createElement('input')];
  side.className = 'unit';
  field.inputMode = 'decimal';
  field.value = values.map(String).join(' ');
  field.title = values.length > 1 ? 'One number per axis' : '';
  field.onchange = () => {
    const numbers = read(field, { count: values.length, least });
    if (numbers) onChange(numbers);
  };
  side.append(field, unit);
  label.append(name, side);
  return label;
}
