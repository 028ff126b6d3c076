import type { Controller, CreatedController, Memory, SessionStatus, State, StepAnswer } from "./bodies.js";
import type { Client, CallOptions } from "./client.js";
import { Stepping } from "./stepping.js";
import { Stream } from "./stream.js";

/** A controller whose memory the service keeps; `Client.session` opens it. */
export class Session extends Stepping {
  readonly id: string;

  constructor(
    private readonly client: Client,
    controller: Controller,
    /** Joint order, and warnings about contacts that would bounce. */
    readonly created: CreatedController,
  ) {
    super(controller.period_s);
    this.id = created.id;
  }

  override stepState(state: State, options: CallOptions = {}): Promise<StepAnswer> {
    return this.client.call<StepAnswer>("POST", `${this.path()}/step`, state, this.client.stepOptions(options));
  }

  /** Configuration, last sequence number and counters. */
  status(options: CallOptions = {}): Promise<SessionStatus> {
    return this.client.call<SessionStatus>("GET", this.path(), undefined, options);
  }

  /** The same controller over a WebSocket, for loops faster than requests allow. Closing it keeps the session. */
  stream(options: CallOptions = {}): Promise<Stream> {
    return Stream.open(this.client, this, `${this.path()}/stream`, options);
  }

  /** Ends the session. */
  close(options: CallOptions = {}): Promise<void> {
    return this.client.call<void>("DELETE", this.path(), undefined, options);
  }

  private path(): string {
    return `/v1/controllers/${encodeURIComponent(this.id)}`;
  }
}

/** A controller whose memory travels with each request, so that any replica of the service answers any of them. */
export class Stateless extends Stepping {
  /** What the last answer asked to be told; may be stored and put back. */
  memory: Memory | null = null;

  constructor(
    private readonly client: Client,
    private readonly controller: Controller,
  ) {
    super(controller.period_s);
  }

  override async stepState(state: State, options: CallOptions = {}): Promise<StepAnswer> {
    const answer = await this.client.step({ controller: this.controller, state, memory: this.memory }, options);
    this.memory = answer.memory ?? null;
    return answer;
  }
}
