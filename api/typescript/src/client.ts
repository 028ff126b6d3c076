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

/** How one call may end early. */
export interface CallOptions {
  /** Ends the call; what is thrown is the signal's reason. */
  signal?: AbortSignal;
  /** Longest time for the call with its repetitions, ms. */
  timeoutMs?: number;
}

/** How a client is set up. */
export interface ClientOptions {
  /** What the service was given as `--token-file`. */
  token?: string;
  /** Longest time for a call with its repetitions, ms; 10 000 if left out. */
  timeoutMs?: number;
  /** The same for a control period; 1000 if left out. */
  stepTimeoutMs?: number;
  /** Repetitions of a call at most, only where they cannot do harm; 2 if left out. */
  retries?: number;
  /** Stands in for the global `fetch`. */
  fetch?: typeof fetch;
  /** Stands in for the global `WebSocket`, which Node has since version 22 and which sends no token. */
  webSocket?: WebSocketFactory;
}

type Method = "GET" | "POST" | "DELETE";

/** Before the first repetition where the service names no time, ms; doubled each time. */
const FIRST_PAUSE_MS = 20;

/** Without these calls the service is as before, or they may be made twice without harm. */
const NOT_REPEATABLE = new Set(["/v1/controllers", "/v1/robots", "/v1/simulations"]);

/** A client of one service. Every method rejects with a `RevprioError` where there is no answer or the service refuses. */
export class Client {
  readonly url: string;
  readonly stepTimeoutMs: number;
  readonly #timeoutMs: number;
  readonly #retries: number;
  readonly #token: Record<string, string>;
  readonly #fetch: typeof fetch;
  readonly #webSocket: WebSocketFactory;

  /** `url`: base address of the service; nothing is sent before the first call. */
  constructor(url = "http://127.0.0.1:8080", options: ClientOptions = {}) {
    this.url = url.replace(/\/+$/, "");
    this.stepTimeoutMs = options.stepTimeoutMs ?? 1000;
    this.#timeoutMs = options.timeoutMs ?? 10_000;
    this.#retries = options.retries ?? 2;
    this.#token = options.token === undefined ? {} : { authorization: `Bearer ${options.token}` };
    this.#fetch = options.fetch ?? globalThis.fetch.bind(globalThis);
    this.#webSocket = options.webSocket ?? ownWebSocket;
  }

  /** Joint velocities (n, rad/s or m/s) for tasks at a posture, and what became of each task. */
  resolve(request: ResolveRequest, options?: CallOptions): Promise<ResolveAnswer> {
    return this.call("POST", "/v1/resolve", request, options);
  }

  /** Many questions at once: for each an answer or, where it is refused, a problem, in the same order. */
  async resolveBatch(items: ResolveRequest[], options?: CallOptions): Promise<(ResolveAnswer | Problem)[]> {
    const answer = await this.call<{ items: (ResolveAnswer | Problem)[] }>("POST", "/v1/resolve/batch", { items }, options);
    return answer.items;
  }

  /** Tool pose (m), `jacobian` (6 × n, base axes, linear rows first), singular values and link frames. */
  kinematics(request: KinematicsRequest, options?: CallOptions): Promise<KinematicsAnswer> {
    return this.call("POST", "/v1/kinematics", request, options);
  }

  /** How much lag (s) and delay (periods) one axis in contact bears, and how little damping it needs. */
  stability(request: StabilityRequest, options?: CallOptions): Promise<StabilityAnswer> {
    return this.call("POST", "/v1/stability", request, options);
  }

  /** One stateless control period; `stateless` keeps the memory for you. */
  step(request: StepRequest, options?: CallOptions): Promise<StepAnswer> {
    return this.call("POST", "/v1/step", request, this.stepOptions(options));
  }

  /** Opens a controller whose memory the service keeps; `close` it. */
  async session(controller: Controller, options?: CallOptions): Promise<Session> {
    return new Session(this, controller, await this.call<CreatedController>("POST", "/v1/controllers", controller, options));
  }

  /** The sessions of all clients that are open now. */
  async sessions(options?: CallOptions): Promise<SessionEntry[]> {
    return (await this.call<{ controllers: SessionEntry[] }>("GET", "/v1/controllers", undefined, options)).controllers;
  }

  /** A controller whose memory travels with each request. */
  stateless(controller: Controller): Stateless {
    return new Stateless(this, controller);
  }

  /** The arms that requests can name, with limits and units of their joints. */
  async robots(options?: CallOptions): Promise<Robot[]> {
    return (await this.call<{ robots: Robot[] }>("GET", "/v1/robots", undefined, options)).robots;
  }

  /** One of them. */
  robot(name: string, options?: CallOptions): Promise<Robot> {
    return this.call("GET", `/v1/robots/${encodeURIComponent(name)}`, undefined, options);
  }

  /** Makes an arm known from the text of a URDF file. */
  registerRobot(registration: RobotRegistration, options?: CallOptions): Promise<Robot> {
    return this.call("POST", "/v1/robots", registration, options);
  }

  /** Forgets a registered arm. */
  deleteRobot(name: string, options?: CallOptions): Promise<void> {
    return this.call("DELETE", `/v1/robots/${encodeURIComponent(name)}`, undefined, options);
  }

  /** The experiments that ship with the service. */
  async scenarios(options?: CallOptions): Promise<ScenarioEntry[]> {
    return (await this.call<{ scenarios: ScenarioEntry[] }>("GET", "/v1/scenarios", undefined, options)).scenarios;
  }

  /** One of them. */
  scenario(name: string, options?: CallOptions): Promise<Scenario> {
    return this.call("GET", `/v1/scenarios/${encodeURIComponent(name)}`, undefined, options);
  }

  /** Starts an experiment, by name or of your own; `result()` waits for its end, `trace()` has every period. */
  async simulate(request: SimulationRequest, options?: CallOptions): Promise<SimulationRun> {
    return new SimulationRun(this, (await this.call<Simulation>("POST", "/v1/simulations", request, options)).id);
  }

  /** Sends a call, again where that is safe, and reads its answer. */
  async call<A>(method: Method, path: string, body?: unknown, options: CallOptions = {}): Promise<A> {
    const timeoutMs = options.timeoutMs ?? this.#timeoutMs;
    const endMs = performance.now() + timeoutMs;
    let pauseMs = FIRST_PAUSE_MS;
    for (let left = this.#retries; ; left--, pauseMs *= 2) {
      try {
        return await this.#send<A>(method, path, body, options.signal, Math.max(endMs - performance.now(), 1));
      } catch (failure) {
        const waitMs = failure instanceof ProblemError && failure.retryAfterS !== undefined ? failure.retryAfterS * 1e3 : pauseMs;
        if (left === 0 || !mayRepeat(failure, method, path) || performance.now() + waitMs >= endMs) throw failure;
        await pause(waitMs, options.signal);
      }
    }
  }

  /** Options with the time limit of a control period. */
  stepOptions(options: CallOptions = {}): CallOptions {
    return { timeoutMs: this.stepTimeoutMs, ...options };
  }

  /** A WebSocket to a path of the service. */
  webSocket(path: string): WebSocketLike {
    return this.#webSocket(this.url.replace(/^http/, "ws") + path, "revprio.json", this.#token);
  }

  async #send<A>(method: Method, path: string, body: unknown, signal: AbortSignal | undefined, timeoutMs: number): Promise<A> {
    signal?.throwIfAborted();
    const url = this.url + path;
    const timer = new AbortController();
    const timeout = setTimeout(() => timer.abort(), timeoutMs);
    const stop = () => timer.abort();
    signal?.addEventListener("abort", stop, { once: true });
    try {
      const headers = { ...this.#token, accept: "application/json", "content-type": "application/json" };
      const content = body === undefined ? null : JSON.stringify(body, finite);
      const response = await this.#fetch(url, { method, headers, body: content, signal: timer.signal });
      return read<A>(url, response, await response.text());
    } catch (error) {
      signal?.throwIfAborted();
      if (error instanceof RevprioError || error instanceof RangeError) throw error;
      if (timer.signal.aborted) throw new LateAnswerError(url, `nothing within ${timeoutMs.toFixed(0)} ms`);
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

/** Whether the service has certainly not taken the call, or may take it twice. An answer that is late is not asked for again. */
function mayRepeat(failure: unknown, method: Method, path: string): boolean {
  if (failure instanceof ProblemError) return failure.status === 503 || failure.status === 429;
  // An order to a run may be to go on by some periods.
  const repeatable = method !== "POST" || !(NOT_REPEATABLE.has(path) || path.endsWith("/control"));
  return repeatable && failure instanceof NoAnswerError && !(failure instanceof LateAnswerError);
}

/** `JSON.stringify` would write `null` for what is not finite. */
function finite(field: string, value: unknown): unknown {
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

function ownWebSocket(url: string, protocol: string, headers: Record<string, string>): WebSocketLike {
  if (globalThis.WebSocket === undefined || Object.keys(headers).length > 0) {
    throw new TypeError("give the client a `webSocket`: this platform has none, or none that can show the token");
  }
  return new WebSocket(url, protocol);
}
