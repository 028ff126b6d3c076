import type {
  Controller,
  CreatedController,
  KinematicsAnswer,
  KinematicsRequest,
  PayloadAnswer,
  PayloadRequest,
  Problem,
  ResolveAnswer,
  ResolveRequest,
  Robot,
  RobotRegistration,
  Scenario,
  ScenarioEntry,
  SessionEntry,
  SimulationRequest,
  Simulation,
  StabilityAnswer,
  StabilityRequest,
  StepAnswer,
  StepRequest,
} from "./bodies.js";
import { Connection, randomWord, type CallOptions } from "./connection.js";
import { Session, Stateless } from "./controller.js";
import { SimulationRun } from "./simulation.js";

/** A client of one service. Every method rejects with a `RevprioError` if no answer comes or the service refuses. */
export class Client extends Connection {
  /** Computes joint velocities (n, rad/s or m/s) for tasks, and the result of each task. */
  resolve(request: ResolveRequest, options?: CallOptions): Promise<ResolveAnswer> {
    return this.call("POST", "/v1/resolve", request, options);
  }

  /** Resolves many requests at once. Returns, in the same order, an answer or a problem for each. */
  async resolveBatch(items: ResolveRequest[], options?: CallOptions): Promise<(ResolveAnswer | Problem)[]> {
    const answer = await this.call<{ items: (ResolveAnswer | Problem)[] }>("POST", "/v1/resolve/batch", { items }, options);
    return answer.items;
  }

  /** Returns tool pose (m), `jacobian` (6 × n, base axes, linear rows first), singular values and link frames. */
  kinematics(request: KinematicsRequest, options?: CallOptions): Promise<KinematicsAnswer> {
    return this.call("POST", "/v1/kinematics", request, options);
  }

  /** Returns stability margins of one axis in contact: maximum lag (s) and delay (periods), minimum damping. */
  stability(request: StabilityRequest, options?: CallOptions): Promise<StabilityAnswer> {
    return this.call("POST", "/v1/stability", request, options);
  }

  /**
   * Identifies bias and payload of a wrist sensor from readings at rest in six postures or more. `bias` and `payload` of
   * the answer fit into `wrench_sensor` of a controller.
   */
  payload(request: PayloadRequest, options?: CallOptions): Promise<PayloadAnswer> {
    return this.call("POST", "/v1/payload", request, options);
  }

  /** Runs one control period of a stateless controller; `stateless` keeps the memory between periods for you. */
  step(request: StepRequest, options?: CallOptions): Promise<StepAnswer> {
    return this.call("POST", "/v1/step", request, this.stepOptions(options));
  }

  /** Opens a controller whose memory the service keeps. Call `close` on it at the end. */
  async session(controller: Controller, options?: CallOptions): Promise<Session> {
    const keyed = { ...options, headers: { "idempotency-key": randomWord(), ...options?.headers } };
    return new Session(this, controller, await this.call<CreatedController>("POST", "/v1/controllers", controller, keyed));
  }

  /** Lists the open sessions of all clients. */
  async sessions(options?: CallOptions): Promise<SessionEntry[]> {
    return (await this.call<{ controllers: SessionEntry[] }>("GET", "/v1/controllers", undefined, options)).controllers;
  }

  /** Returns a controller that sends its memory with each request. */
  stateless(controller: Controller): Stateless {
    return new Stateless(this, controller);
  }

  /** Lists the robots that requests can name, with limits and units of their joints. */
  async robots(options?: CallOptions): Promise<Robot[]> {
    return (await this.call<{ robots: Robot[] }>("GET", "/v1/robots", undefined, options)).robots;
  }

  /** Returns the robot of this name, with limits and units of its joints. */
  robot(name: string, options?: CallOptions): Promise<Robot> {
    return this.call("GET", `/v1/robots/${encodeURIComponent(name)}`, undefined, options);
  }

  /** Registers a robot from the text of a URDF file. */
  registerRobot(registration: RobotRegistration, options?: CallOptions): Promise<Robot> {
    return this.call("POST", "/v1/robots", registration, options);
  }

  /** Deletes a registered robot. */
  deleteRobot(name: string, options?: CallOptions): Promise<void> {
    return this.call("DELETE", `/v1/robots/${encodeURIComponent(name)}`, undefined, options);
  }

  /** Lists the scenarios that ship with the service. */
  async scenarios(options?: CallOptions): Promise<ScenarioEntry[]> {
    return (await this.call<{ scenarios: ScenarioEntry[] }>("GET", "/v1/scenarios", undefined, options)).scenarios;
  }

  /** Returns the scenario of this name. */
  scenario(name: string, options?: CallOptions): Promise<Scenario> {
    return this.call("GET", `/v1/scenarios/${encodeURIComponent(name)}`, undefined, options);
  }

  /** Starts a simulation of a scenario. `result()` waits for its end; `trace()` returns every control period. */
  async simulate(request: SimulationRequest, options?: CallOptions): Promise<SimulationRun> {
    return new SimulationRun(this, (await this.call<Simulation>("POST", "/v1/simulations", request, options)).id);
  }
}
