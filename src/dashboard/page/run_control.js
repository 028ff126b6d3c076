// State and actions of the page: starts and controls runs, watches sessions, and provides the data to draw.

import { axisOf, vec } from './arm.js';
import { add, dot, scale, sub, unit } from './geometry.js';
import { History } from './history.js';
import { Run } from './run.js';
import * as setups from './setup.js';
import { state } from './state.js';
import { get, post } from './transport.js';
import { Watch } from './watch.js';

/**
 * @typedef {import('./types.js').Scenario} Scenario
 * @typedef {import('./types.js').ScenarioList} ScenarioList
 * @typedef {import('./types.js').Robot} Robot
 * @typedef {import('./types.js').ArmView} ArmView
 * @typedef {import('./types.js').KinematicsAnswer} KinematicsAnswer
 * @typedef {import('./types.js').StepRequest} StepRequest
 * @typedef {import('./types.js').SimulationControl} SimulationControl
 * @typedef {import('./types.js').LiveSample} LiveSample
 * @typedef {import('./types.js').Vec3} Vec3
 * @typedef {import('./setup.js').Setup} Setup
 * @typedef {import('./scene.js').World} World
 * @typedef {import('./plots.js').View} View
 */

/** Minimum interval between two commands with a push, ms; the service ends a push after one second. */
const PUSH_INTERVAL = 100;

/** Controls the run, its ghost (a second run with another method, for comparison) and the watched session. */
export class RunControl {
  /**
   * @param {() => void} onChange called when the page must be redrawn
   * @param {(error: unknown) => void} onError
   */
  constructor(onChange, onError) {
    this.onChange = onChange;
    this.onError = onError;
    /** @type {Scenario[]} */
    this.scenarios = [];
    /** @type {Scenario | null} the selected scenario, without the changes of the setup */
    this.scenario = null;
    /** @type {Setup | null} */
    this.setup = null;
    /** @type {Robot | null} */
    this.robot = null;
    /** @type {ArmView | null} the arm at the start of the scenario */
    this.preview = null;
    /** @type {Run | null} */
    this.run = null;
    /** @type {Run | null} */
    this.ghost = null;
    /** @type {Scenario | null} scenario of the current run, with the changes of the setup */
    this.running = null;
    /** @type {Watch | null} */
    this.watch = null;
    /** @type {Vec3} */
    this.push = [0, 0, 0];
    this.lastPushTime = 0;
    this.closeUp = false;
    this.emptyHistory = new History();
    /** Shows the setup in the form; set by the module `controls`. */
    this.showSetup = () => {};
  }

  /** Loads the scenarios. Uses the setup in the address of the page, if there is one. */
  async load() {
    /** @type {ScenarioList} */
    const { scenarios } = await get('/v1/scenarios');
    this.scenarios = scenarios.map(({ scenario }) => scenario);
    const fallback = this.scenarios.find(({ name }) => name === 'stiff_wall') ?? this.scenarios[0];
    this.setup ??= setups.fromFragment(location.hash, this.scenarios) ?? setups.defaults(fallback);
    const { scenario } = this.setup;
    this.scenario = this.scenarios.find(({ name }) => name === scenario) ?? fallback;
    await this.showStart();
  }

  /** Shows the arm at the start of the scenario. */
  async showStart() {
    if (!this.scenario) return;
    const { robot } = this.scenario.controller;
    if (this.robot?.name !== robot) this.robot = await get(`/v1/robots/${robot}`);
    /** @type {KinematicsAnswer} */
    const answer = await post('/v1/kinematics', { robot, joint_position: this.scenario.start_joint_position });
    this.preview = {
      joints: answer.links.map(({ pose }) => ({ origin: pose.position, axis: zOf(pose.orientation), lower: null, upper: null })),
      tool: answer.pose,
    };
    this.onChange();
  }

  /**
   * Selects a scenario and resets the run.
   * @param {string} name
   */
  async selectScenario(name) {
    const scenario = this.scenarios.find((known) => known.name === name);
    if (!scenario || !this.setup) return;
    const { method, solver, ghost, speed } = this.setup;
    this.scenario = scenario;
    this.setup = { ...setups.defaults(scenario), method, solver, ghost, speed };
    this.reset();
    await this.showStart();
  }

  /**
   * Changes the setup and applies to the current run what can change during a run.
   * @param {Partial<Setup>} change
   */
  async change(change) {
    if (!this.setup || !this.scenario) return;
    this.setup = { ...this.setup, ...change };
    this.onChange();
    const command = this.commandFor(change);
    const isActive = ['running', 'paused', 'starting'].includes(state.value.phase) && this.run;
    if (!isActive) return;
    state.set({ pending: this.isPending() });
    if (command) await this.sendControl(command, change.method === undefined);
  }

  /**
   * Returns the command for the parts of a change that can be applied during a run, or null.
   * @param {Partial<Setup>} change
   * @returns {SimulationControl | null}
   */
  commandFor(change) {
    if (!this.setup || !this.scenario) return null;
    if (change.gains) {
      const changed = setups.applyTo(this.scenario, this.setup).controller;
      return { controller: changed };
    }
    const { method, solver, speed } = change;
    return method ?? solver ?? speed ? { method, solver, speed } : null;
  }

  /** Returns whether the setup has changes that need a new run. */
  isPending() {
    if (!this.running || !this.setup || !this.scenario) return false;
    const changed = setups.applyTo(this.scenario, this.setup);
    const differ = (/** @type {unknown} */ a, /** @type {unknown} */ b) => JSON.stringify(a) !== JSON.stringify(b);
    return (
      differ(changed.contacts, this.running.contacts) ||
      differ(changed.velocity_loop, this.running.velocity_loop) ||
      (this.ghost?.simulation.method ?? '') !== this.setup.ghost
    );
  }

  /**
   * Sends a control command to the run.
   * @param {SimulationControl} command
   * @param {boolean} both whether the ghost gets the command too
   */
  async sendControl(command, both = true) {
    const runs = [this.run, both ? this.ghost : null];
    const ghostCommand = command.controller && this.ghost
      ? { ...command, controller: { ...command.controller, method: this.ghost.simulation.method } }
      : command;
    await Promise.all(runs.map((run) => run?.control(run === this.ghost ? ghostCommand : command)));
    this.updatePhase();
  }

  /** Starts, pauses or resumes the run. */
  async togglePause() {
    const { phase } = state.value;
    if (phase === 'running') await this.sendControl({ paused: true });
    else if (phase === 'paused') await this.sendControl({ paused: false });
    else if (phase !== 'starting') await this.start(false);
  }

  /**
   * Advances the run by a number of control periods; starts a paused run first if there is none.
   * @param {number} periods
   */
  async step(periods) {
    const { phase } = state.value;
    if (phase !== 'running' && phase !== 'paused') await this.start(true);
    await this.sendControl({ step: periods });
  }

  /**
   * Deletes the current run, then starts a new run and its ghost.
   * @param {boolean} paused whether the new run waits for a command
   */
  async start(paused) {
    if (!this.setup || !this.scenario) return;
    this.reset();
    state.set({ phase: 'starting' });
    const { setup, scenario } = this;
    this.running = setups.applyTo(scenario, setup);
    const onFrame = () => this.updatePhase();
    const onEnd = (/** @type {Run} */ run, /** @type {'end' | 'lost'} */ reason, /** @type {unknown} */ error) =>
      this.handleEnd(run, reason, error);
    try {
      const waits = paused || setup.ghost !== '';
      this.run = await Run.start(setups.request(scenario, setup, setup.method, waits), onFrame, onEnd);
      if (setup.ghost) {
        this.ghost = await Run.start(setups.request(scenario, setup, setup.ghost, true), onFrame, onEnd);
        if (!paused) await this.sendControl({ paused: false });
      }
    } catch (error) {
      this.reset();
      throw error;
    }
  }

  /** Sets the phase of the page from the state of the run. */
  updatePhase() {
    if (this.run) {
      const { state: now, interactive, error } = this.run.simulation;
      const phase = now === 'queued' ? 'starting' : now === 'running' ? (interactive?.paused ? 'paused' : 'running') : now;
      if (phase === 'failed' && state.value.phase !== 'failed') this.onError(new Error(error ?? 'the run failed'));
      if (state.value.phase !== 'lost') state.set({ phase });
    }
    this.onChange();
  }

  /** Handles the end of the event stream of a run. @type {(run: Run, reason: 'end' | 'lost', error: unknown) => void} */
  handleEnd(run, reason, error) {
    if (run === this.run && reason === 'lost') {
      state.set({ phase: 'lost' });
      if (error) this.onError(error);
    }
    this.onChange();
  }

  /** Ends the run at its current time. */
  async end() {
    await this.sendControl({ end: true });
  }

  /** Deletes the run. */
  reset() {
    this.run?.delete();
    this.ghost?.delete();
    this.run = null;
    this.ghost = null;
    this.running = null;
    state.set({ phase: 'none', pending: false });
    this.onChange();
  }

  /**
   * Pushes the tool, or ends the push.
   * @param {Vec3 | null} force on the tool, N; null ends the push
   */
  pushWith(force) {
    if (!['running', 'paused'].includes(state.value.phase)) return;
    const before = this.push;
    this.push = force ?? [0, 0, 0];
    const isHeld = this.push.some((part) => part !== 0);
    const now = performance.now();
    if (isHeld && now - this.lastPushTime < PUSH_INTERVAL) return;
    if (!isHeld && before.every((part) => part === 0)) return;
    this.lastPushTime = now;
    this.sendControl({ external_force: this.push }).catch(this.onError);
  }

  /**
   * Watches a session; an empty id ends watching.
   * @param {string} id
   */
  async watchSession(id) {
    this.reset();
    this.watch?.close();
    this.watch = null;
    state.set({ session: id });
    if (!id) return;
    const watch = await Watch.open(id);
    this.watch = watch;
    this.robot = watch.robot;
    state.set({ phase: 'watching' });
    watch.follow(() => this.onChange(), (reason, error) => {
      if (this.watch !== watch) return;
      state.set({ phase: reason === 'end' ? 'finished' : 'lost' });
      if (error) this.onError(error);
    });
  }

  /** Stops watching the session and shows the scenario again. */
  async leaveSession() {
    this.watch?.close();
    this.watch = null;
    state.set({ phase: 'none', session: '' });
    await this.showStart();
  }

  /** @returns {Promise<StepRequest>} the latest control cycle as a request of `POST /v1/step` */
  async cycle() {
    if (this.run?.frame && this.run.frame.done > 0) return get(`${this.run.path}/cycle`);
    if (this.watch?.step) return { controller: this.watch.session.controller, state: this.watch.step.state, memory: null };
    if (!this.scenario || !this.setup) throw new Error('there is no control cycle yet');
    const start = this.scenario.start_joint_position;
    return {
      controller: setups.applyTo(this.scenario, this.setup).controller,
      state: {
        sequence: 0, time_s: 0, joint_position: start, joint_velocity: start.map(() => 0),
        wrench: { force: [0, 0, 0], torque: [0, 0, 0] },
      },
      memory: null,
    };
  }

  /** @returns {History} */
  get history() {
    return this.watch?.history ?? this.run?.history ?? this.emptyHistory;
  }

  /** @returns {LiveSample | undefined} */
  get sample() {
    return this.history.last;
  }

  /** @returns {ArmView | null} */
  get arm() {
    if (this.watch) return this.watch.step?.arm ?? null;
    return this.run?.frame?.arm ?? this.preview;
  }

  /** @returns {World} data of the scene */
  world() {
    const { sample, arm } = this;
    const scenario = this.watch ? null : (this.running ?? this.scenario);
    const start = vec(this.history.start ?? this.preview?.tool.position ?? [0, 0, 0]);
    const tool = vec(arm?.tool.position ?? [0, 0, 0]);
    const distance = sample?.wall_distance_m ?? null;
    const contacts = (scenario?.contacts ?? []).map((contact) => currentContact(contact, start, tool, distance));
    const limited = [...(sample?.at_lower ?? []), ...(sample?.at_upper ?? [])];
    const ghost = this.ghost?.frame ? { arm: this.ghost.frame.arm, history: this.ghost.history } : null;
    return {
      arm,
      atLimit: (arm?.joints ?? []).map((_, joint) => limited.includes(joint)),
      history: this.history,
      contacts,
      start,
      force: vec(sample?.force ?? [0, 0, 0]),
      target: sample?.target_force ?? [null, null, null],
      push: vec(this.run?.frame?.external_force ?? [0, 0, 0]),
      ghost,
    };
  }

  /** @returns {View} data of the plots */
  view() {
    const controller = this.watch?.session.controller ?? (this.running ?? this.scenario)?.controller;
    const frame = this.run?.frame;
    return {
      history: this.history,
      ghost: this.ghost?.history ?? null,
      duration: this.watch ? 0 : ((this.running ?? this.scenario)?.duration_s ?? 0),
      arm: this.arm,
      robot: this.robot,
      position: this.sample?.joint_position ?? (this.watch ? [] : (this.scenario?.start_joint_position ?? [])),
      velocity: this.sample?.joint_velocity ?? [],
      tasks: controller?.tasks.map(({ name }) => name) ?? [],
      threshold: controller?.damping?.threshold ?? null,
      period: controller?.period_s ?? 0.001,
      paths: this.watch?.paths ?? frame?.paths ?? null,
      solveTime: this.watch?.solveTime ?? frame?.solve_time ?? null,
      closeUp: this.closeUp,
    };
  }
}

/**
 * Returns the direction of the z axis of a frame.
 * @param {{w: number, x: number, y: number, z: number}} quaternion
 */
function zOf({ w, x, y, z }) {
  return [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)];
}

/**
 * Returns a contact at its current position.
 * @param {NonNullable<Scenario['contacts']>[number]} contact
 * @param {Vec3} start of the tool
 * @param {Vec3} tool
 * @param {number | null} distance from the tool to the wall, m
 * @returns {import('./scene.js').Contact}
 */
function currentContact(contact, start, tool, distance) {
  const offset = contact.offset_m ?? 0;
  const isWall = contact.kind !== 'spring';
  const axis = axisOf('xyz'.indexOf(contact.axis ?? 'x'));
  const inwards = contact.normal ? unit(scale(vec(contact.normal), -1)) : scale(axis, isWall && offset < 0 ? -1 : 1);
  const at = add(start, contact.normal ? scale(inwards, offset) : scale(axis, offset));
  if (!contact.motion || distance === null) return { isWall, inwards, at };
  // The contact moves. Compute its position from the tool and the distance.
  const shift = dot(sub(tool, at), inwards) + distance;
  return { isWall, inwards, at: add(at, scale(inwards, shift)) };
}
