// State and actions of the page: starts and controls runs, and watches sessions. `editing.js` changes the setup.

import { vec } from './arm.js';
import { History } from './history.js';
import { Kinematics } from './kinematics.js';
import { Measures, toolPose } from './measures.js';
import { playground } from './playground.js';
import { pressFrom } from './presets.js';
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
 * @typedef {import('./types.js').Pose} Pose
 * @typedef {import('./types.js').Vec3} Vec3
 * @typedef {import('./setup.js').Setup} Setup
 */

/** Robot of the playground that opens first. */
const FIRST_ROBOT = 'panda';

/** Minimum interval between two commands with a push, ms; the service ends a push after one second. */
const PUSH_INTERVAL = 100;

/** Controls the run, its ghosts (runs with other methods, for comparison) and the watched session. */
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
    /** @type {Robot[]} */
    this.robots = [];
    /** @type {Scenario | null} the selected scenario, without the changes of the setup */
    this.scenario = null;
    /** @type {Setup | null} */
    this.setup = null;
    /** Earlier setups, for undo. @type {Setup[]} */
    this.undoable = [];
    /** @type {Robot | null} */
    this.robot = null;
    /** Shapes of the links by robot name. @type {Map<string, import('./visuals.js').Visuals>} */
    this.visuals = new Map();
    /** Registrations of the robots that were dropped onto the page or came with a link, by name. @type {Map<string, import('./types.js').RobotRegistration>} */
    this.dropped = new Map();
    /** @type {Kinematics | null} of the shown robot */
    this.kinematics = null;
    /** @type {ArmView | null} the arm at the start of the scenario */
    this.preview = null;
    /** @type {Run | null} */
    this.run = null;
    /** Runs with other methods, for comparison. @type {Run[]} */
    this.ghosts = [];
    /** Recordings that are shown as ghosts. @type {import('./recording.js').Recording[]} */
    this.recordings = [];
    /** @type {Scenario | null} scenario of the current run, with the changes of the setup */
    this.running = null;
    /** @type {Watch | null} */
    this.watch = null;
    /** Time that the page shows instead of the latest one, s. @type {number | null} */
    this.cursor = null;
    /** The target that the user drags. @type {{task: string, pose: Pose} | null} */
    this.dragged = null;
    /** The obstacle that the user drags. @type {import('./types.js').RoomObstacle | null} */
    this.draggedObstacle = null;
    /** The result of `applied`, and of what. @type {{scenario: Scenario, setup: Setup, preview: ArmView | null, result: Scenario} | null} */
    this.lastApplied = null;
    /** Number of starts and resets so far. */
    this.starts = 0;
    /** Whether the latest start leaves its run paused. */
    this.startsPaused = false;
    /** Whether the service has the runs paused only until all of them are made. */
    this.begins = false;
    /** Ends when the latest start has made its runs. @type {Promise<void>} */
    this.started = Promise.resolve();
    /** Ends when the service has deleted the runs of before. @type {Promise<unknown>} */
    this.deletion = Promise.resolve();
    this.lastMoveTime = -Infinity;
    /** @type {Vec3} */
    this.push = [0, 0, 0];
    this.lastPushTime = 0;
    /** Whether the user pushed the tool in this run. */
    this.wasPushed = false;
    this.closeUp = false;
    this.emptyHistory = new History();
    /** Shows the setup in the form; set by the module `controls`. */
    this.showSetup = () => {};
  }

  /** Returns whether a run goes on or is paused. */
  get isActive() {
    return this.run !== null && ['running', 'paused', 'starting'].includes(state.value.phase);
  }

  /** Returns whether the run is paused, or will be when it has started. */
  get isPaused() {
    const { phase } = state.value;
    return phase === 'starting' ? this.startsPaused : phase === 'paused';
  }

  /** The scenario with the changes of the setup. @returns {Scenario | null} */
  get applied() {
    const { scenario, setup, preview, lastApplied: last } = this;
    if (!scenario || !setup) return null;
    if (last && last.scenario === scenario && last.setup === setup && last.preview === preview) return last.result;
    const result = setups.applyTo(scenario, setup, this.startPosition);
    this.lastApplied = { scenario, setup, preview, result };
    return result;
  }

  /** Position of the tool at the start of the scenario, m. @returns {Vec3} */
  get startPosition() {
    return vec(this.preview?.tool.position ?? [0, 0, 0]);
  }

  /** Loads scenarios and robots. Uses the setup in the address of the page, if there is one. */
  async load() {
    /** @type {ScenarioList} */
    const { scenarios } = await get('/v1/scenarios');
    await this.loadRobots();
    await this.registerAgain();
    this.scenarios = scenarios.map(({ scenario }) => scenario);
    const isFirst = !this.setup && location.hash.length < 2;
    const shared = await this.robotOfLink();
    const robot = shared || this.setup?.robot || (isFirst ? FIRST_ROBOT : new URLSearchParams(location.hash.slice(1)).get('robot'));
    if (robot && this.robots.some(({ name }) => name === robot)) await this.makePlayground(robot, this.setup?.press ?? pressFrom(new URLSearchParams(location.hash.slice(1)).get('press')));
    const fallback = this.scenarios.find(({ name }) => name === (isFirst ? setups.PLAYGROUND : 'stiff_wall')) ?? this.scenarios[0];
    this.setup ??= setups.fromFragment(location.hash, this.scenarios) ?? { ...setups.defaults(fallback), motion: isFirst ? 'eight' : '' };
    const { scenario, robot: lost } = this.setup;
    this.scenario = this.scenarios.find(({ name }) => name === scenario) ?? fallback;
    if (this.scenario.name !== scenario) {
      this.setup = setups.defaults(this.scenario);
      this.onError(new Error(`the service has no ${lost ? `robot ${lost}` : `scenario ${scenario}`} any more; the page shows ${fallback.name}`));
    }
    // A watched session keeps its own robot.
    if (!this.watch) await this.showStart();
  }

  /** A service that was started again does not know the robots that were dropped onto the page. */
  async registerAgain() {
    const unknown = [...this.dropped].filter(([name]) => !this.robots.some((robot) => robot.name === name));
    for (const [, registration] of unknown) await post('/v1/robots', registration);
    if (unknown.length > 0) await this.loadRobots();
  }

  async loadRobots() {
    /** @type {import('./types.js').RobotList} */
    const { robots } = await get('/v1/robots');
    this.robots = robots;
  }

  /** Makes the playground scenario for a robot. @type {(name: string, press?: import('./presets.js').Press | null) => Promise<void>} */
  async makePlayground(name, press = null) {
    const robot = this.robots.find((known) => known.name === name);
    if (!robot) throw new Error(`there is no robot ${name}`);
    const scenario = await playground(robot, press);
    this.scenarios = [...this.scenarios.filter((known) => known.name !== setups.PLAYGROUND), scenario];
  }

  /** Shows the arm at the start of the scenario. */
  async showStart() {
    if (!this.scenario) return;
    const { robot } = this.scenario.controller;
    if (this.robot?.name !== robot) this.robot = await get(`/v1/robots/${robot}`);
    /** @type {KinematicsAnswer} */
    const answer = await post('/v1/kinematics', { robot, joint_position: this.scenario.start_joint_position });
    this.kinematics = new Kinematics(/** @type {Robot} */ (this.robot), answer, this.scenario.start_joint_position);
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
    this.setup = setups.forScenario(scenario, this.setup, this.scenario);
    this.scenario = scenario;
    this.reset();
    await this.showStart();
  }

  /** Registers the robot that the link of the page has, and returns its name; set by the module `link`. @type {() => Promise<string>} */
  robotOfLink = async () => '';

  /** Set by the module `editing`. @type {(change: setups.Change) => Promise<void>} */
  change = async () => {};

  /**
   * Sends a control command to the run.
   * @param {SimulationControl} command
   * @param {boolean} all whether the ghosts get the command too
   */
  async sendControl(command, all = true) {
    const { controller } = command;
    const own = (/** @type {Run} */ ghost) => (controller ? { ...command, controller: { ...controller, method: ghost.simulation.method } } : command);
    const others = all ? this.ghosts.map((ghost) => ghost.control(own(ghost))) : [];
    await Promise.all([this.run?.control(command), ...others]);
    this.updatePhase();
  }

  /** Starts the playground that moves by itself, unless the user prefers no motion. */
  async startMotion() {
    const isCalm = matchMedia('(prefers-reduced-motion: reduce)').matches;
    if (this.setup?.motion && !isCalm && !this.run && !this.watch) await this.start(false);
  }

  /** Starts, pauses or resumes the run. */
  async togglePause() {
    const { phase } = state.value;
    this.cursor = null;
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
    this.cursor = null;
    if (phase !== 'running' && phase !== 'paused') await this.start(true);
    await this.sendControl({ step: periods });
  }

  /**
   * Deletes the current run, then starts a new run and its ghosts.
   * @param {boolean} paused whether the new run waits for a command
   */
  async start(paused) {
    const { applied, setup, preview } = this;
    if (!setup || !applied) return;
    this.reset();
    const start = preview?.tool ?? null;
    const history = () => {
      const made = new History();
      made.begin(applied, new Measures(applied.controller, start, this.kinematics), []);
      return made;
    };
    const ghosts = setup.ghosts.map((method) => ({ method, scenario: applied, history: history() }));
    this.started = this.startRuns(applied, history(), ghosts, paused);
    await this.started;
  }

  /**
   * Starts a run and its ghosts.
   * @param {Scenario} scenario
   * @param {History} history receives the samples of the run
   * @param {{method: import('./types.js').Method, scenario: Scenario, history: History}[]} ghosts
   * @param {boolean} paused
   */
  async startRuns(scenario, history, ghosts, paused) {
    const { setup } = this;
    if (!setup) return;
    state.set({ phase: 'starting' });
    this.running = scenario;
    const isLatest = this.supersede();
    this.startsPaused = paused;
    this.begins = !paused && ghosts.length > 0;
    const runs = 1 + ghosts.length;
    try {
      // The service limits the number of runs, so the old ones must be gone first.
      await this.deletion;
      for (const part of [{ method: setup.method, scenario, history }, ...ghosts]) {
        if (!isLatest()) return;
        const run = await this.startRun(setups.request(part.scenario, setup, part.method, paused || this.begins, runs), part.history);
        if (!isLatest()) return this.delete([run]);
        if (part.history === history) this.run = run;
        else this.ghosts.push(run);
      }
      if (this.begins) await this.sendControl({ paused: false });
      if (isLatest()) this.begins = false;
    } catch (error) {
      if (!isLatest()) return;
      this.reset();
      throw error;
    }
  }

  /** @type {(request: import('./types.js').SimulationRequest, history: History) => Promise<Run>} */
  startRun(request, history) {
    return Run.start(request, () => this.updatePhase(), (run, reason, error) => this.handleEnd(run, reason, error), history);
  }

  /** Ends all starts that still wait for the service. Returns a function that tells whether no later one has ended this one. */
  supersede() {
    this.starts += 1;
    const own = this.starts;
    return () => this.starts === own;
  }

  /** Deletes runs in the service. @param {Run[]} runs */
  delete(runs) {
    this.deletion = Promise.all([this.deletion, ...runs.map((run) => run.delete())]);
  }

  /** Sets the phase of the page from the state of the run. */
  updatePhase() {
    if (this.run) {
      const { state: now, interactive, error } = this.run.simulation;
      const own = !interactive?.paused ? 'running' : this.begins ? 'starting' : 'paused';
      const phase = now === 'queued' ? 'starting' : now === 'running' ? own : now;
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
    this.supersede();
    this.delete([...(this.run ? [this.run] : []), ...this.ghosts]);
    this.run = null;
    this.ghosts = [];
    this.wasPushed = false;
    this.begins = false;
    this.running = null;
    this.cursor = null;
    this.dragged = null;
    this.draggedObstacle = null;
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
    this.wasPushed ||= isHeld;
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
    // Another choice was made meanwhile.
    if (state.value.session !== id || this.watch) {
      watch.close();
      return;
    }
    this.watch = watch;
    this.robot = watch.robot;
    this.kinematics = watch.kinematics;
    state.set({ phase: 'watching' });
    watch.follow(() => this.onChange(), (reason, error) => {
      if (this.watch !== watch) return;
      if (reason === 'replaced') {
        this.watchSession(id).catch(this.onError);
        return;
      }
      state.set({ phase: reason === 'end' ? 'finished' : 'lost' });
      if (error) this.onError(error);
    });
  }

  /** Stops watching the session and shows the scenario again. */
  async leaveSession() {
    this.watch?.close();
    this.watch = null;
    this.cursor = null;
    state.set({ source: 'simulation', phase: 'none', session: '' });
    await this.showStart();
  }

  /** @returns {Promise<StepRequest>} the latest control cycle as a request of `POST /v1/step` */
  async cycle() {
    if (this.run?.frame && this.run.frame.done > 0) return get(`${this.run.path}/cycle`);
    if (this.watch?.step) return { controller: this.watch.session.controller, state: this.watch.step.state, memory: null };
    const { applied } = this;
    if (!applied) throw new Error('there is no control cycle yet');
    const start = applied.start_joint_position;
    return {
      controller: applied.controller,
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

  /** The scenario of the shown part of the past; null for the present. @returns {Scenario | null} */
  get pastScenario() {
    if (this.cursor === null || this.watch) return null;
    return this.history.segmentAt(this.cursor)?.scenario ?? null;
  }

  /** Pose of the tool in the latest sample, or at the start. @returns {Pose | null} */
  get tool() {
    return this.sample ? toolPose(this.sample) : (this.preview?.tool ?? null);
  }
}

/**
 * Returns the direction of the z axis of a frame.
 * @param {{w: number, x: number, y: number, z: number}} quaternion
 */
function zOf({ w, x, y, z }) {
  return [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)];
}
