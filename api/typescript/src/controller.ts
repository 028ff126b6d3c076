import type { Controller, CreatedController, Memory, SessionStatus, State, StepAnswer, TareAnswer, TareRequest } from "./bodies.js";
import type { CallOptions, Connection } from "./connection.js";
import { ProblemError } from "./errors.js";
import { Stepping } from "./stepping.js";
import { Stream } from "./stream.js";

/** A controller whose memory the service keeps; `Client.session` opens it. */
export class Session extends Stepping {
  readonly id: string;

  constructor(
    private readonly connection: Connection,
    controller: Controller,
    /** The answer of the service: session name, joint order, and warnings about unstable contacts. */
    public created: CreatedController,
  ) {
    super(controller.period_s);
    this.id = created.id;
  }

  /** What the controller may do wrong: unstable loops, numbers in wrong units, gains that are too high. Print them. */
  get warnings(): string[] {
    return this.created.warnings ?? [];
  }

  override stepState(state: State, options: CallOptions = {}): Promise<StepAnswer> {
    this.follow(state);
    return this.connection.call<StepAnswer>("POST", `${this.path()}/step`, state, this.connection.stepOptions(options));
  }

  /** Returns the configuration, the last sequence number and counters. */
  status(options: CallOptions = {}): Promise<SessionStatus> {
    return this.connection.call<SessionStatus>("GET", this.path(), undefined, options);
  }

  /**
   * Replaces the controller while the arm moves: adds, removes, reorders and changes tasks without a jump. Robot, period
   * and drive must stay.
   */
  async replace(controller: Controller, options: CallOptions = {}): Promise<void> {
    this.created = await this.connection.call<CreatedController>("PUT", this.path(), controller, options);
  }

  /**
   * Tares a wrench sensor with 20 readings or more of an arm that rests and touches nothing. The stated payload counts.
   * The next state gets the bias; put it into `wrench_sensor` of a controller that replaces this one.
   */
  tare(request: TareRequest, options: CallOptions = {}): Promise<TareAnswer> {
    return this.connection.call<TareAnswer>("POST", `${this.path()}/tare`, request, options);
  }

  /** Opens a WebSocket to the same controller, for loops too fast for single requests. Closing it keeps the session. */
  stream(options: CallOptions = {}): Promise<Stream> {
    return Stream.open(this.connection, this, `${this.path()}/stream`, options);
  }

  /** Ends the session; does nothing if it has already ended, also by a call whose answer was lost. */
  async close(options: CallOptions = {}): Promise<void> {
    try {
      await this.connection.call<void>("DELETE", this.path(), undefined, options);
    } catch (failure) {
      if (!(failure instanceof ProblemError && failure.status === 404)) throw failure;
    }
  }

  private path(): string {
    return `/v1/controllers/${encodeURIComponent(this.id)}`;
  }
}

/** A controller that sends its memory with each request, so that any replica of the service can answer it. */
export class Stateless extends Stepping {
  /** The controller memory of the last answer, for the next request. It may be stored and set again. */
  memory: Memory | null = null;

  constructor(
    private readonly connection: Connection,
    private readonly controller: Controller,
  ) {
    super(controller.period_s);
  }

  override async stepState(state: State, options: CallOptions = {}): Promise<StepAnswer> {
    this.follow(state);
    const request = { controller: this.controller, state, memory: this.memory };
    const answer = await this.connection.call<StepAnswer>("POST", "/v1/step", request, this.connection.stepOptions(options));
    this.memory = answer.memory ?? null;
    return answer;
  }
}
