// The setup of a run: a scenario and the user's changes to it. The fragment of the page's address can store a setup.

import { addFigureOfEight } from './figure_of_eight.js';
import { inTaskFrame, positionDirections } from './goals.js';
import { setObstacles } from './obstacles.js';
import { addPlanes } from './planes.js';
import { pressFrom, pressText } from './presets.js';
import { fromText, toText } from './shared_state.js';

/**
 * @typedef {import('./types.js').Scenario} Scenario
 * @typedef {import('./types.js').Method} Method
 * @typedef {import('./types.js').Solver} Solver
 * @typedef {import('./types.js').SimulationRequest} SimulationRequest
 * @typedef {import('./types.js').ControllerTask} Task
 * @typedef {import('./types.js').Vec3} Vec3
 * @typedef {'inertia' | 'damping' | 'stiffness'} Gain
 *
 * @typedef {object} Setup
 * @property {string} scenario
 * @property {Method} method
 * @property {Solver} solver
 * @property {Method[]} ghosts methods of the arms that run the same for comparison
 * @property {number} speed simulated seconds per second
 * @property {number | null} lag of the arm's velocity loop, s; null: as in the scenario
 * @property {Record<string, number[]>} gains changed gains, by `task.gain`
 * @property {Record<string, number>} stiffness changed stiffness of contacts, by index, N/m
 * @property {string} robot robot of the playground; empty in the other scenarios
 * @property {'' | 'eight' | 'recorded'} motion of the target of the playground; `recorded`: as in a recording
 * @property {import('./presets.js').Press | null} press what the tool of the playground does instead
 * @property {number[]} order order of the tasks as indices, highest priority first; empty: as in the scenario
 * @property {import('./planes.js').Plane[]} planes planes and walls that the user added
 * @property {import('./types.js').RoomObstacle[] | null} obstacles of the controller; null: as in the scenario
 * @property {Record<string, import('./types.js').Pose>} targets moved targets by task, base frame
 * @typedef {Partial<Setup> | ((setup: Setup) => Partial<Setup>)} Change a change of the setup, or one of the setup of its moment
 */

/** @type {{value: Method, name: string}[]} */
export const METHODS = [
  { value: 'reverse_priority', name: 'Reverse priority' },
  { value: 'strict_reverse_priority', name: 'Strict reverse priority' },
  { value: 'task_priority', name: 'Task priority' },
  { value: 'singularity_robust', name: 'Singularity robust' },
  { value: 'damped_least_squares', name: 'Damped least squares' },
  { value: 'pseudoinverse', name: 'Pseudo-inverse' },
];

/** @type {{value: Solver, name: string}[]} */
export const SOLVERS = [
  { value: 'auto', name: 'Automatic' },
  { value: 'qp', name: 'QP cascade' },
  { value: 'closed_form', name: 'Closed form, no limits' },
];

/** Name of the scenario that the page makes for any robot. */
export const PLAYGROUND = 'playground';

/** Maximum number of ghosts with a method: the service runs four simulations at a time. */
export const MAX_GHOSTS = 3;

/** Maximum number of control periods of all runs of the page: the service keeps 250 000 of all its runs. */
const MAX_PERIODS = 240_000;

/** @type {Gain[]} */
export const GAINS = ['inertia', 'damping', 'stiffness'];

/** @type {(value: string) => string} */
export function methodName(value) {
  return METHODS.find((method) => method.value === value)?.name ?? value;
}

/** @type {(scenario: Scenario) => Setup} the setup without changes */
export function defaults(scenario) {
  return {
    scenario: scenario.name,
    method: scenario.controller.method ?? 'reverse_priority',
    solver: scenario.controller.solver ?? 'auto',
    ghosts: [],
    speed: 1,
    lag: null,
    gains: {},
    stiffness: {},
    robot: scenario.name === PLAYGROUND ? scenario.controller.robot : '',
    motion: '',
    press: null,
    order: [],
    planes: [],
    obstacles: null,
    targets: {},
  };
}

/** Returns the setup of a newly chosen scenario. It keeps what the user chose, but not what the scenario before chose. @type {(scenario: Scenario, before: Setup, old: Scenario | null) => Setup} */
export function forScenario(scenario, before, old) {
  const setup = defaults(scenario);
  const { ghosts, speed } = before;
  const method = old && before.method !== defaults(old).method ? before.method : setup.method;
  const solver = old && before.solver !== defaults(old).solver ? before.solver : setup.solver;
  return { ...setup, method, solver, ghosts, speed };
}

/**
 * Returns a gain of a task as a list; null if its law does not have this gain.
 * @param {Scenario} scenario
 * @param {number} task
 * @param {Gain} gain
 * @returns {number[] | null}
 */
export function gainOf(scenario, task, gain) {
  const law = /** @type {Record<string, unknown> | undefined} */ (scenario.controller.tasks[task].law);
  const value = law?.[gain];
  if (typeof value === 'number') return [value];
  return Array.isArray(value) ? value : null;
}

/**
 * Returns the scenario with the changes of the setup.
 * @param {Scenario} scenario
 * @param {Setup} setup
 * @param {Vec3} start position of the tool at the start, m
 * @returns {Scenario}
 */
export function applyTo(scenario, setup, start) {
  /** @type {Scenario} */
  const changed = structuredClone(scenario);
  const { controller } = changed;
  controller.method = setup.method;
  controller.solver = setup.solver;
  controller.why = true;
  if (setup.lag !== null) {
    changed.velocity_loop = { delay_periods: 0, ...changed.velocity_loop, lag_s: setup.lag };
  }
  for (const [index, stiffness] of Object.entries(setup.stiffness)) {
    const contact = changed.contacts?.[Number(index)];
    if (contact) contact.stiffness = stiffness;
  }
  if (setup.motion === 'eight') addFigureOfEight(changed, start);
  controller.tasks = inOrder(controller.tasks.map(moved(setup.targets)), setup.order);
  setGains(controller, setup);
  addPlanes(changed, setup.planes, start);
  setObstacles(changed, setup.obstacles);
  return changed;
}

/** Returns the gains of a scenario, by task and gain. @type {(scenario: Scenario) => Setup['gains']} */
export function gainsOf(scenario) {
  const all = scenario.controller.tasks.flatMap((_, k) => GAINS.map((gain) => /** @type {const} */ ([`${k}.${gain}`, gainOf(scenario, k, gain)])));
  return Object.fromEntries(all.flatMap(([key, values]) => (values ? [[key, values]] : [])));
}

/** Changes the gains of a controller. @type {(controller: Scenario['controller'], setup: Setup) => void} */
export function setGains(controller, { gains, order }) {
  for (const [key, values] of Object.entries(gains)) {
    const [task, gain] = key.split('.');
    const place = order.length > 0 ? order.indexOf(Number(task)) : Number(task);
    const law = /** @type {Record<string, unknown> | undefined} */ (controller.tasks[place]?.law);
    if (law && gain in law) law[gain] = values.length === 1 && !Array.isArray(law[gain]) ? values[0] : values;
  }
}

/** @type {<T>(list: T[], order: number[]) => T[]} */
export function inOrder(list, order) {
  return order.length === list.length ? order.map((index) => list[index]) : list;
}

/** Returns tasks with their moved targets; targets that the page sends stay in force. @type {(targets: Setup['targets']) => (task: Task) => Task} */
function moved(targets) {
  return (task) => {
    if (positionDirections(task).length === 0) return task;
    const streaming = { hold_after_s: 0.05, brake_after_s: 10, ...task.streaming };
    const pose = targets[task.name];
    if (!pose || !task.law) return { ...task, streaming };
    const law = { ...task.law, target_pose: inTaskFrame(task, pose), target_displacement: null };
    return { ...task, streaming, law: /** @type {any} */ (law) };
  };
}

/** Returns the request of one of several runs; long ones are shortened so that the service can keep all. @type {(scenario: Scenario, setup: Setup, method: Method, paused: boolean, runs: number) => SimulationRequest} */
export function request(given, { solver, speed }, method, paused, runs) {
  const longest = (MAX_PERIODS / runs) * (given.controller.period_s ?? 0.001);
  const scenario = given.duration_s > longest ? { ...given, duration_s: longest } : given;
  return { scenario, method, solver, interactive: { speed, paused } };
}

/** @type {(setup: Setup, scenario: Scenario) => string} */
export function toFragment(setup, scenario) {
  const unchanged = defaults(scenario);
  const text = new URLSearchParams({ scenario: setup.scenario });
  for (const key of /** @type {const} */ (['method', 'solver', 'speed'])) {
    if (setup[key] !== unchanged[key]) text.set(key, String(setup[key]));
  }
  if (setup.ghosts.length > 0) text.set('ghost', setup.ghosts.join(','));
  const more = toText(setup);
  if (more) text.set('state', more);
  if (setup.lag !== null) text.set('lag', String(setup.lag));
  if (setup.robot) text.set('robot', setup.robot);
  if (setup.motion === 'eight') text.set('motion', setup.motion);
  if (setup.press) text.set('press', pressText(setup.press));
  if (setup.order.length > 0) text.set('order', setup.order.join(','));
  for (const [key, values] of Object.entries(setup.gains)) text.set(key, values.join(','));
  for (const [index, value] of Object.entries(setup.stiffness)) text.set(`contact.${index}`, String(value));
  return text.toString();
}

/**
 * Reads a setup from a fragment; invalid entries are ignored.
 * @param {string} fragment
 * @param {Scenario[]} scenarios
 * @returns {Setup | null}
 */
export function fromFragment(fragment, scenarios) {
  const text = new URLSearchParams(fragment.replace(/^#/, ''));
  const scenario = scenarios.find(({ name }) => name === text.get('scenario'));
  if (!scenario) return null;
  const setup = defaults(scenario);
  const known = (/** @type {{value: string}[]} */ words, /** @type {string | null} */ word) =>
    words.some(({ value }) => value === word);
  if (known(METHODS, text.get('method'))) setup.method = /** @type {Method} */ (text.get('method'));
  const ghosts = (text.get('ghost') ?? '').split(',', 10 * MAX_GHOSTS).filter((word) => known(METHODS, word));
  setup.ghosts = /** @type {Method[]} */ ([...new Set(ghosts)].slice(0, MAX_GHOSTS));
  if (known(SOLVERS, text.get('solver'))) setup.solver = /** @type {Solver} */ (text.get('solver'));
  if (setup.robot) setup.press = pressFrom(text.get('press'));
  if (text.get('motion') === 'eight' && setup.robot && !setup.press) setup.motion = 'eight';
  Object.assign(setup, fromText(text.get('state')));
  setup.speed = positive(text.get('speed')) ?? setup.speed;
  const lag = Number(text.get('lag') ?? NaN);
  setup.lag = lag >= 0 ? lag : null;
  const order = (text.get('order') ?? '').split(',').map(Number);
  const isOrder = order.length === scenario.controller.tasks.length && order.every((_, k) => order.includes(k));
  if (text.has('order') && isOrder) setup.order = order;
  for (const [key, value] of text) {
    const contact = /^contact\.(\d+)$/.exec(key);
    const stiffness = positive(value);
    if (contact && stiffness !== null && scenario.contacts?.[Number(contact[1])]) setup.stiffness[contact[1]] = stiffness;
    const gain = /^(\d+)\.(inertia|damping|stiffness)$/.exec(key);
    const values = numbers(value);
    if (gain && values && scenario.controller.tasks[Number(gain[1])]) setup.gains[key] = values;
  }
  return setup;
}

/** @type {(text: string | null) => number | null} */
function positive(text) {
  const value = Number(text ?? NaN);
  return value > 0 && Number.isFinite(value) ? value : null;
}

/** @type {(text: string) => number[] | null} non-negative numbers, separated by commas or spaces; null if invalid */
export function numbers(text) {
  const words = text.split(/[\s,;]+/).filter(Boolean);
  const values = words.map(Number);
  return values.length > 0 && values.every((value) => Number.isFinite(value) && value >= 0) ? values : null;
}
