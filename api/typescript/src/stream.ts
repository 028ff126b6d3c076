import type { State, StepAnswer } from "./bodies.js";
import type { CallOptions, Client } from "./client.js";
import type { Session } from "./controller.js";
import { ForeignAnswerError, isProblem, LateAnswerError, NoAnswerError, ProblemError } from "./errors.js";
import { Stepping } from "./stepping.js";

/** The part of a WebSocket that a stream uses; browsers, Node 22 and the package `ws` provide it. */
export interface WebSocketLike {
  send(data: string): void;
  close(): void;
  addEventListener(type: "open" | "close", listener: () => void): void;
  addEventListener(type: "error", listener: (event: object) => void): void;
  addEventListener(type: "message", listener: (event: { data: unknown }) => void): void;
}

/** Opens a WebSocket. `headers` contains the tokens, which the WebSocket of browsers cannot send. */
export type WebSocketFactory = (url: string, protocol: string, headers: Record<string, string>) => WebSocketLike;

/** A state that was sent and awaits its reply. */
interface PendingReply {
  resolve(answer: StepAnswer): void;
  reject(error: unknown): void;
}

/** A session over a WebSocket. The service sends one reply per state, in the same order. */
export class Stream extends Stepping {
  #pending: PendingReply[] = [];
  #failure: NoAnswerError | undefined;

  private constructor(
    private readonly client: Client,
    private readonly session: Session,
    private readonly socket: WebSocketLike,
  ) {
    super(session.periodS);
    const end = (cause: unknown) => {
      this.#failure ??= new NoAnswerError(client.url, cause);
      for (const pending of this.#pending.splice(0)) pending.reject(this.#failure);
    };
    socket.addEventListener("close", () => end("the connection was closed"));
    socket.addEventListener("error", (event) => end("message" in event ? event.message : "the connection failed"));
    socket.addEventListener("message", ({ data }) => this.#handleMessage(data));
  }

  /** Opens the connection. */
  static async open(client: Client, session: Session, path: string, { signal }: CallOptions): Promise<Stream> {
    signal?.throwIfAborted();
    const stream = new Stream(client, session, client.webSocket(path));
    await new Promise<void>((resolve, reject) => {
      stream.#pending.push({ resolve: () => resolve(), reject });
      stream.socket.addEventListener("open", () => (stream.#pending.shift(), resolve()));
      signal?.addEventListener("abort", () => (stream.close(), reject(signal.reason)), { once: true });
    });
    return stream;
  }

  /** Uses the sequence numbers of the session, so that the session and its stream never use the same number. */
  override number(measurement: Parameters<Stepping["number"]>[0]): State {
    return this.session.number(measurement);
  }

  override stepState(state: State, { signal, timeoutMs = this.client.stepTimeoutMs }: CallOptions = {}): Promise<StepAnswer> {
    return new Promise((resolve, reject) => {
      signal?.throwIfAborted();
      if (this.#failure) throw this.#failure;
      const stop = () => reject(signal?.reason);
      const late = () => reject(new LateAnswerError(this.client.url, `no reply within ${timeoutMs} ms`));
      const timer = setTimeout(late, timeoutMs);
      signal?.addEventListener("abort", stop, { once: true });
      const cleanUp = () => (clearTimeout(timer), signal?.removeEventListener("abort", stop));
      this.#pending.push({
        resolve: (answer) => (cleanUp(), resolve(answer)),
        reject: (error) => (cleanUp(), reject(error)),
      });
      this.socket.send(JSON.stringify(state));
    });
  }

  /** Closes the connection. The session stays open. */
  close(): void {
    this.socket.close();
  }

  #handleMessage(data: unknown): void {
    const pending = this.#pending.shift();
    const reply = parse(data);
    if (isProblem(reply)) pending?.reject(new ProblemError(reply));
    else if (reply === undefined) pending?.reject(new ForeignAnswerError(this.client.url, 200));
    else pending?.resolve(reply as StepAnswer);
  }
}

function parse(data: unknown): unknown {
  try {
    return JSON.parse(String(data));
  } catch {
    return undefined;
  }
}
