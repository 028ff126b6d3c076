// Changes to the setup: applied to the current run where possible, recorded for undo, and marked in the plots.

import { continued } from './continuation.js';
import { targetPose } from './goals.js';
import { Measures } from './measures.js';
import * as setups from './setup.js';
import { state } from './state.js';
import { sendTarget } from './target.js';
import { shownController } from './view.js';

/**
 * @typedef {import('./run_control.js').RunControl} RunControl
 * @typedef {import('./run.js').Run} Run
 * @typedef {import('./setup.js').Setup} Setup
 * @typedef {import('./types.js').Scenario} Scenario
 * @typedef {import('./types.js').ControllerTask} Task
 * @typedef {import('./types.js').SimulationControl} SimulationControl
 */

/** Maximum number of changes that can be undone. */
const MAX_UNDO = 100;

/** Movements of a target with less time between them are one change, ms. */
const SAME_MOVE = 1000;

/** The change that is being applied; the next one waits for it. @type {Promise<unknown>} */
let busy = Promise.resolve();

/** @type {(work: () => Promise<void>) => Promise<void>} */
function afterOthers(work) {
  const done = busy.then(work);
  busy = done.catch(() => {});
  return done;
}

/** Gives a run control its changes of the setup. @param {RunControl} runControl */
export function bind(runControl) {
  runControl.change = (change) => afterOthers(() => record(runControl, change));
}

/** Records the setup, then changes it. @type {(runControl: RunControl, given: setups.Change) => Promise<void>} */
async function record(runControl, given) {
  const { setup, undoable } = runControl;
  // The setup of the moment: an earlier change may have waited for the service.
  const change = typeof given === 'function' ? (setup ? given(setup) : {}) : given;
  const keys = Object.keys(change);
  const isNew = (/** @type {string} */ key) => JSON.stringify(/** @type {any} */ (setup)?.[key]) !== JSON.stringify(/** @type {any} */ (change)[key]);
  const isUndoable = setup && keys.some((key) => key !== 'speed' && isNew(key));
  const now = performance.now();
  const continues = keys.length === 1 && keys[0] === 'targets' && now - runControl.lastMoveTime < SAME_MOVE;
  if (change.targets) runControl.lastMoveTime = now;
  if (isUndoable && !continues) undoable.push(setup);
  if (undoable.length > MAX_UNDO) undoable.shift();
  try {
    await apply(runControl, change, continues);
  } catch (error) {
    if (isUndoable && !continues) undoable.pop();
    throw error;
  }
}

/** Undoes the last change. @type {(runControl: RunControl) => Promise<void>} */
export const undo = (runControl) => afterOthers(() => restore(runControl));

/** @type {(runControl: RunControl) => Promise<void>} */
async function restore(runControl) {
  const before = runControl.undoable.pop();
  const { setup } = runControl;
  if (!before || !setup) return;
  const isRecorded = [before, setup].some(({ motion }) => motion === 'recorded') && before.motion !== setup.motion;
  const isOther = before.scenario !== setup.scenario || before.robot !== setup.robot || JSON.stringify(before.press) !== JSON.stringify(setup.press);
  if (isOther || isRecorded) {
    if (before.robot) await runControl.makePlayground(before.robot, before.press);
    await runControl.selectScenario(before.scenario);
    runControl.setup = before.motion === 'recorded' ? { ...before, motion: '' } : before;
    runControl.onChange();
    return;
  }
  /** @type {any} */
  const change = {};
  for (const key of /** @type {(keyof Setup)[]} */ (Object.keys(before))) {
    if (key !== 'speed' && JSON.stringify(before[key]) !== JSON.stringify(setup[key])) change[key] = before[key];
  }
  await apply(runControl, change);
  // A run that was continued has the targets.
  if (change.targets && !movesAgain(runControl, setup)) resendTargets(runControl, setup);
}

/** Selects a scenario or a robot, and records the setup. @type {(runControl: RunControl, name: string, robot?: string, press?: Setup['press']) => Promise<void>} */
export const select = (runControl, name, robot = '', press = null) => afterOthers(async () => {
  const before = runControl.setup;
  if (robot) await runControl.makePlayground(robot, press);
  if (before) runControl.undoable.push(before);
  await runControl.selectScenario(name);
  if (runControl.setup) runControl.setup = { ...runControl.setup, press };
});

/**
 * Changes the setup and applies to the current run what can change during a run. If the service refuses the change, the setup of
 * before is valid again and the run goes on with it.
 * @param {RunControl} runControl
 * @param {Partial<Setup>} change
 * @param {boolean} continues whether it continues the last change, which is marked already
 */
async function apply(runControl, change, continues = false) {
  const { setup: before } = runControl;
  if (!before || !runControl.scenario) return;
  runControl.setup = { ...before, ...change };
  runControl.onChange();
  // A run that is being made gets the change afterwards.
  await runControl.started.catch(() => {});
  if (!runControl.isActive) return;
  if (change.ghosts) dropGhosts(runControl);
  const needsRun = change.order || change.planes || change.obstacles !== undefined || change.motion !== undefined || movesAgain(runControl, before);
  const current = currentRuns(runControl);
  try {
    if (needsRun) {
      await restart(runControl, current);
    } else {
      const command = commandFor(runControl, change);
      if (command) await runControl.sendControl(command, change.method === undefined);
    }
  } catch (error) {
    runControl.setup = before;
    if (needsRun) await restart(runControl, current).catch(() => {});
    runControl.showSetup();
    throw error;
  }
  for (const text of continues ? [] : describe(runControl, change)) runControl.history.mark(text);
  state.set({ pending: isPending(runControl) });
}

/** Ends the ghosts whose methods were removed. @param {RunControl} runControl */
function dropGhosts(runControl) {
  const isWanted = (/** @type {Run} */ { simulation }) => runControl.setup?.ghosts.includes(simulation.method) ?? false;
  runControl.delete(runControl.ghosts.filter((run) => !isWanted(run)));
  runControl.ghosts = runControl.ghosts.filter(isWanted);
}

/** Returns the command for the parts of a change that a run can apply. @type {(runControl: RunControl, change: Partial<Setup>) => SimulationControl | null} */
function commandFor({ running, scenario, setup }, change) {
  if (!running || !setup) return null;
  const { method, solver, speed } = change;
  if (change.gains) {
    const controller = structuredClone(running.controller);
    Object.assign(controller, { method: setup.method, solver: setup.solver });
    // A gain that is no longer in the setup is that of the scenario.
    const gains = { ...(scenario ? setups.gainsOf(scenario) : {}), ...setup.gains };
    setups.setGains(controller, { ...setup, gains });
    return { controller, speed };
  }
  return method ?? solver ?? speed ? { method, solver, speed } : null;
}

/** Returns whether the setup has changes that need a new run. @type {(runControl: RunControl) => boolean} */
function isPending({ applied, running, ghosts, setup }) {
  if (!applied || !running || !setup) return false;
  const stiffness = (/** @type {Scenario} */ scenario) => (scenario.contacts ?? []).map((contact) => contact.stiffness);
  const differ = (/** @type {unknown} */ a, /** @type {unknown} */ b) => JSON.stringify(a) !== JSON.stringify(b);
  return (
    differ(stiffness(applied), stiffness(running)) ||
    differ(applied.velocity_loop, running.velocity_loop) ||
    differ(ghosts.map(({ simulation }) => simulation.method), setup.ghosts)
  );
}

/** @typedef {{run: Run | null, ghosts: Run[], paused: boolean}} Runs */

/** @type {(runControl: RunControl) => Runs} */
const currentRuns = ({ run, ghosts, isPaused }) => ({ run, ghosts, paused: isPaused });

/** Continues runs from their last posture with the changed tasks and planes. @type {(runControl: RunControl, of: Runs) => Promise<void>} */
async function restart(runControl, { run, ghosts, paused }) {
  const { applied, robot, setup } = runControl;
  if (!run || !applied || !robot || !setup) return;
  if (!run.history.last) {
    await runControl.start(paused);
    return;
  }
  const next = (/** @type {Run} */ old) => {
    const { last, measures } = old.history;
    const start = measures?.start ?? runControl.preview?.tool;
    return last && start ? continued(applied, robot, start, last) : applied;
  };
  const scenario = next(run);
  prepare(run.history, scenario, setup.order);
  const others = ghosts.map((ghost) => {
    const { history } = ghost;
    const own = next(ghost);
    prepare(history, own, setup.order);
    return { method: ghost.simulation.method, scenario: own, history };
  });
  state.set({ phase: 'starting' });
  const old = [run, ...ghosts].filter((each) => each === runControl.run || runControl.ghosts.includes(each));
  runControl.ghosts = [];
  runControl.delete(old);
  runControl.started = runControl.startRuns(scenario, run.history, others, paused);
  await runControl.started;
}

/** Prepares a history for the run that continues it. @type {(history: import('./history.js').History, scenario: Scenario, order: number[]) => void} */
function prepare(history, scenario, order) {
  const { measures } = history;
  history.begin(scenario, new Measures(scenario.controller, measures?.start ?? null, measures?.kinematics ?? null), order);
}

/** Returns the task of the setup with this name. @type {(runControl: RunControl, wanted: string) => Task | undefined} */
const ownTask = ({ applied }, wanted) => applied?.controller.tasks.find(({ name }) => name === wanted);

/** Returns whether a task that held a moved target follows the motion of its law again: a streamed target has no motion. @type {(runControl: RunControl, before: Setup) => boolean} */
function movesAgain(runControl, before) {
  return Object.keys(before.targets).some((name) => {
    const law = ownTask(runControl, name)?.law;
    const motion = law && 'target_displacement' in law && law.target_displacement;
    return !runControl.setup?.targets[name] && motion && motion.kind !== 'constant';
  });
}

/** Sends the targets that a change of the setup moved. @type {(runControl: RunControl, before: Setup) => void} */
function resendTargets(runControl, before) {
  const { setup, history, preview } = runControl;
  for (const task of shownController(runControl)?.tasks ?? []) {
    const [old, now] = [before.targets[task.name], setup?.targets[task.name]];
    if (!old || JSON.stringify(old) === JSON.stringify(now)) continue;
    const start = history.measures?.start ?? preview?.tool;
    const own = ownTask(runControl, task.name);
    const pose = now ?? (own && start ? targetPose(own, start, 0) : null);
    if (pose) sendTarget(runControl, task, pose);
  }
}

const GAIN_SIGNS = /** @type {Record<string, string>} */ ({ inertia: 'M_d', damping: 'B_d', stiffness: 'K_d' });

/** Describes a change for the plots. @type {(runControl: RunControl, change: Partial<Setup>) => string[]} */
function describe({ scenario }, change) {
  const texts = [];
  if (change.method) texts.push(setups.methodName(change.method));
  if (change.solver) texts.push(`solver: ${setups.SOLVERS.find(({ value }) => value === change.solver)?.name}`);
  if (change.gains) {
    const [key, values] = Object.entries(change.gains).at(-1) ?? ['', []];
    const [task, gain] = key.split('.');
    const name = scenario?.controller.tasks[Number(task)]?.name ?? '';
    texts.push(key ? `${GAIN_SIGNS[gain]} of “${name}”: ${values.map((value) => Number(value.toPrecision(4))).join(' ')}` : 'gains as in the scenario');
  }
  if (change.order) texts.push('tasks reordered');
  if (change.planes) texts.push(change.planes.length > 0 ? `planes: ${change.planes.map(({ name }) => name).join(', ')}` : 'planes removed');
  if (change.obstacles !== undefined) texts.push(change.obstacles?.length ? `obstacles: ${change.obstacles.map(({ name }) => name).join(', ')}` : 'obstacles removed');
  if (change.motion !== undefined) texts.push(change.motion ? 'figure of eight' : 'target at rest');
  if (change.targets) texts.push('target moved');
  return texts;
}
