import { ForeignAnswerError, isProblem, LateAnswerError, NoAnswerError, ProblemError, RevprioError } from "./errors.js";
import type { WebSocketFactory, WebSocketLike } from "./socket.js";

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

/** A service and how it is called: time limits, retries, tokens. The calls by name are those of `Client`. */
export class Connection {
  readonly url: string;
  readonly stepTimeoutMs: number;
  readonly timeoutMs: number;
  readonly #retries: number;
  readonly #owner: string;
  readonly #headers: Record<string, string>;
  readonly #fetch: typeof fetch;
  readonly #webSocket: WebSocketFactory;

  /** Creates the client; nothing is sent before the first call. `url`: base address of the service. */
  constructor(url = "http://127.0.0.1:8080", options: ClientOptions = {}) {
    this.url = url.replace(/\/+$/, "");
    this.stepTimeoutMs = options.stepTimeoutMs ?? 1000;
    this.timeoutMs = options.timeoutMs ?? 10_000;
    this.#retries = options.retries ?? 2;
    this.#owner = options.owner ?? randomWord();
    this.#headers = { "revprio-owner": this.#owner };
    const token = sendable(options.token ?? "");
    if (token !== "") this.#headers["authorization"] = `Bearer ${token}`;
    this.#fetch = options.fetch ?? globalThis.fetch.bind(globalThis);
    this.#webSocket = options.webSocket ?? globalWebSocket;
  }

  /** Sends a call, retries it where that is safe, and returns its answer. */
  async call<A>(method: Method, path: string, body?: unknown, options: CallOptions = {}): Promise<A> {
    const timeoutMs = options.timeoutMs ?? this.timeoutMs;
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

/** Returns a token without the line break that ends its file. */
function sendable(text: string): string {
  const token = text.trim();
  if (/^[ -~]*$/.test(token)) return token;
  throw new TypeError("the token has characters that cannot be sent; give the content of the file of `--token-file`");
}

/** Returns a random word for an owner token or an idempotency key. `crypto.randomUUID` needs a page over HTTPS. */
export function randomWord(): string {
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
