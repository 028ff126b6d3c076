import type {
  Controller,
  CreatedController,
  KinematicsAnswer,
  KinematicsRequest,
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
import { Session, Stateless } from "./controller.js";
import { ForeignAnswerError, isProblem, LateAnswerError, NoAnswerError, ProblemError, RevprioError } from "./errors.js";
import { SimulationRun } from "./simulation.js";
import type { WebSocketFactory, WebSocketLike } from "./stream.js";

/** Options of one call. */
export interface CallOptions {
  /** Aborts the call, which then rejects with the reason of the signal. */
  signal?: AbortSignal;
  /** Time limit of the call including its retries, ms. */
  timeoutMs?: number;
  /** Additional headers of the call. */
  headers?: Record<string, string>;
}

/** Options of a client. */
export interface ClientOptions {
  /** Content of the service's `--token-file`. */
  token?: string;
  /** Time limit of a call including its retries, ms; default 10 000. */
  timeoutMs?: number;
  /** Time limit of a control period including retries, ms; default 1000. */
  stepTimeoutMs?: number;
  /** Maximum number of retries of a call; default 2. Only calls that are safe to repeat are retried. */
  retries?: number;
  /**
   * Owner token of the sessions that this client opens; default: a random one. Other clients cannot step these sessions.
   * Clients with the same token can.
   */
  owner?: string;
  /** Replaces the global `fetch`. */
  fetch?: typeof fetch;
  /** Replaces the global `WebSocket`. Node has one since version 22; it cannot send a token. */
  webSocket?: WebSocketFactory;
}

type Method = "GET" | "POST" | "PUT" | "DELETE";

/** Pause before the first retry if the answer has no `Retry-After`, ms; doubled for each further retry. */
const FIRST_PAUSE_MS = 20;

/**
 * Paths whose POST creates something, so that it must not be repeated after a lost connection. The request that opens a
 * session may be repeated, because it has an idempotency key.
 */
const CREATING_PATHS = new Set(["/v1/robots", "/v1/simulations"]);

/** A client of one service. Every method rejects with a `RevprioError` if no answer comes or the service refuses. */
export class Client {
  readonly url: string;
  readonly stepTimeoutMs: number;
  readonly #timeoutMs: number;
  readonly #retries: number;
  readonly #owner: string;
  readonly #headers: Record<string, string>;
  readonly #fetch: typeof fetch;
  readonly #webSocket: WebSocketFactory;

  /** Creates the client; nothing is sent before the first call. `url`: base address of the service. */
  constructor(url = "http://127.0.0.1:8080", options: ClientOptions = {}) {
    this.url = url.replace(/\/+$/, "");
    this.stepTimeoutMs = options.stepTimeoutMs ?? 1000;
    this.#timeoutMs = options.timeoutMs ?? 10_000;
    this.#retries = options.retries ?? 2;
    this.#owner = options.owner ?? randomWord();
    this.#headers = { "revprio-owner": this.#owner };
    if (options.token !== undefined) this.#headers["authorization"] = `Bearer ${options.token}`;
    this.#fetch = options.fetch ?? globalThis.fetch.bind(globalThis);
    this.#webSocket = options.webSocket ?? globalWebSocket;
  }

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

  /** Runs one control period of a stateless controller; `stateless` keeps the memory between periods for you. */
  step(request: StepRequest, options?: CallOptions): Promise<StepAnswer> {
    return this.call("POST", "/v1/step", request, this.stepOptions(options));
  }

  /** Opens a controller whose memory the service keeps. Call `close` on it at the end. */
  async session(controller: Controller, options?: CallOptions): Promise<Session> {
    const keyed = { ...options, headers: { "idempotency-key": randomWord() } };
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

  /** Sends a call, retries it where that is safe, and returns its answer. */
  async call<A>(method: Method, path: string, body?: unknown, options: CallOptions = {}): Promise<A> {
    const timeoutMs = options.timeoutMs ?? this.#timeoutMs;
    const endMs = performance.now() + timeoutMs;
    let pauseMs = FIRST_PAUSE_MS;
    for (let left = this.#retries; ; left--, pauseMs *= 2) {
      try {
        return await this.#send<A>(method, path, body, options, Math.max(endMs - performance.now(), 1));
      } catch (failure) {
        const waitMs = failure instanceof ProblemError && failure.retryAfterS !== undefined ? failure.retryAfterS * 1e3 : pauseMs;
        if (left === 0 || !mayRepeat(failure, method, path) || performance.now() + waitMs >= endMs) throw failure;
        await pause(waitMs, options.signal);
      }
    }
  }

  /** Adds the time limit of a control period to options that have none. */
  stepOptions(options: CallOptions = {}): CallOptions {
    return { timeoutMs: this.stepTimeoutMs, ...options };
  }

  /** Opens a WebSocket to a path of the service. The owner token is in the URL, because browsers cannot send headers. */
  webSocket(path: string): WebSocketLike {
    const url = `${this.url.replace(/^http/, "ws")}${path}?revprio_owner=${encodeURIComponent(this.#owner)}`;
    const { "revprio-owner": _, ...headers } = this.#headers;
    return this.#webSocket(url, "revprio.json", headers);
  }

  async #send<A>(method: Method, path: string, body: unknown, options: CallOptions, timeoutMs: number): Promise<A> {
    const { signal } = options;
    signal?.throwIfAborted();
    const url = this.url + path;
    const timer = new AbortController();
    const timeout = setTimeout(() => timer.abort(), timeoutMs);
    const stop = () => timer.abort();
    signal?.addEventListener("abort", stop, { once: true });
    try {
      const types = { accept: "application/json", "content-type": "application/json" };
      const headers = { ...this.#headers, ...types, ...options.headers };
      const content = body === undefined ? null : JSON.stringify(body, rejectNonFinite);
      const response = await this.#fetch(url, { method, headers, body: content, signal: timer.signal });
      return read<A>(url, response, await response.text());
    } catch (error) {
      signal?.throwIfAborted();
      if (error instanceof RevprioError || error instanceof RangeError) throw error;
      if (timer.signal.aborted) throw new LateAnswerError(url, `no reply within ${timeoutMs.toFixed(0)} ms`);
      throw new NoAnswerError(url, error);
    } finally {
      clearTimeout(timeout);
      signal?.removeEventListener("abort", stop);
    }
  }
}

function read<A>(url: string, response: Response, text: string): A {
  let body: unknown;
  try {
    body = text === "" ? undefined : JSON.parse(text);
  } catch {
    throw new ForeignAnswerError(url, response.status);
  }
  if (response.ok) return body as A;
  if (!isProblem(body)) throw new ForeignAnswerError(url, response.status);
  const after = response.headers.get("retry-after");
  throw new ProblemError(body, after !== null && /^\d+$/.test(after) ? Number(after) : undefined);
}

/** Returns whether a call may be sent again: it was not processed, or may be processed twice, and did not time out. */
function mayRepeat(failure: unknown, method: Method, path: string): boolean {
  if (failure instanceof ProblemError) return failure.status === 503 || failure.status === 429;
  // A control command can advance a run by a number of periods, so it must not be repeated.
  const repeatable = method !== "POST" || !(CREATING_PATHS.has(path) || path.endsWith("/control"));
  return repeatable && failure instanceof NoAnswerError && !(failure instanceof LateAnswerError);
}

/** Returns a random word for an owner token or an idempotency key. `crypto.randomUUID` needs a page over HTTPS. */
function randomWord(): string {
  const bytes = globalThis.crypto.getRandomValues(new Uint8Array(16));
  return Array.from(bytes, (byte) => byte.toString(16).padStart(2, "0")).join("");
}

/** Replacer for `JSON.stringify` that throws for a number that is not finite, instead of writing `null`. */
function rejectNonFinite(field: string, value: unknown): unknown {
  if (typeof value === "number" && !Number.isFinite(value)) throw new RangeError(`${field}: every number must be finite`);
  return value;
}

function pause(durationMs: number, signal?: AbortSignal): Promise<void> {
  return new Promise((resolve, reject) => {
    const stop = () => (clearTimeout(timer), reject(signal?.reason));
    const timer = setTimeout(() => (signal?.removeEventListener("abort", stop), resolve()), durationMs);
    signal?.addEventListener("abort", stop, { once: true });
  });
}

function globalWebSocket(url: string, protocol: string, headers: Record<string, string>): WebSocketLike {
  if (globalThis.WebSocket === undefined || Object.keys(headers).length > 0) {
    throw new TypeError("set the option `webSocket`: this platform has no WebSocket, or none that can send the token");
  }
  return new WebSocket(url, protocol);
}
