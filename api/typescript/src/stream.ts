import type { State, StepAnswer } from "./bodies.js";
import type { CallOptions, Client } from "./client.js";
import type { Session } from "./controller.js";
import { ForeignAnswerError, isProblem, LateAnswerError, NoAnswerError, ProblemError } from "./errors.js";
import { Stepping } from "./stepping.js";

/** What a stream needs of a WebSocket: that of browsers and Node 22, or of the package `ws`. */
export interface WebSocketLike {
  send(data: string): void;
  close(): void;
  addEventListener(type: "open" | "close", listener: () => void): void;
  addEventListener(type: "error", listener: (event: object) => void): void;
  addEventListener(type: "message", listener: (event: { data: unknown }) => void): void;
}

/** Opens a WebSocket; `headers` hold the token, which the WebSocket of browsers cannot send. */
export type WebSocketFactory = (url: string, protocol: string, headers: Record<string, string>) => WebSocketLike;

interface Waiting {
  resolve(answer: StepAnswer): void;
  reject(error: unknown): void;
}

/** A session over a WebSocket: each state gets one reply, in order. */
export class Stream extends Stepping {
  #waiting: Waiting[] = [];
  #failure: NoAnswerError | undefined;

  private constructor(
    private readonly client: Client,
    private readonly session: Session,
    private readonly socket: WebSocketLike,
  ) {
    super(session.periodS);
    const end = (cause: unknown) => {
      this.#failure ??= new NoAnswerError(client.url, cause);
      for (const waiting of this.#waiting.splice(0)) waiting.reject(this.#failure);
    };
    socket.addEventListener("close", () => end("the connection was closed"));
    socket.addEventListener("error", (event) => end("message" in event ? event.message : "the connection failed"));
    socket.addEventListener("message", ({ data }) => this.#hear(data));
  }

  /** Connects. */
  static async open(client: Client, session: Session, path: string, { signal }: CallOptions): Promise<Stream> {
    signal?.throwIfAborted();
    const stream = new Stream(client, session, client.webSocket(path));
    await new Promise<void>((resolve, reject) => {
      stream.#waiting.push({ resolve: () => resolve(), reject });
      stream.socket.addEventListener("open", () => (stream.#waiting.shift(), resolve()));
      signal?.addEventListener("abort", () => (stream.close(), reject(signal.reason)), { once: true });
    });
    return stream;
  }

  /** One session, one count. */
  override number(measurement: Parameters<Stepping["number"]>[0]): State {
    return this.session.number(measurement);
  }

  override stepState(state: State, { signal, timeoutMs = this.client.stepTimeoutMs }: CallOptions = {}): Promise<StepAnswer> {
    return new Promise((resolve, reject) => {
      signal?.throwIfAborted();
      if (this.#failure) throw this.#failure;
      const stop = () => reject(signal?.reason);
      const late = () => reject(new LateAnswerError(this.client.url, `nothing within ${timeoutMs} ms`));
      const timer = setTimeout(late, timeoutMs);
      signal?.addEventListener("abort", stop, { once: true });
      const over = () => (clearTimeout(timer), signal?.removeEventListener("abort", stop));
      this.#waiting.push({ resolve: (answer) => (over(), resolve(answer)), reject: (error) => (over(), reject(error)) });
      this.socket.send(JSON.stringify(state));
    });
  }

  /** Ends the connection, not the session. */
  close(): void {
    this.socket.close();
  }

  #hear(data: unknown): void {
    const waiting = this.#waiting.shift();
    const reply = parse(data);
    if (isProblem(reply)) waiting?.reject(new ProblemError(reply));
    else if (reply === undefined) waiting?.reject(new ForeignAnswerError(this.client.url, 200));
    else waiting?.resolve(reply as StepAnswer);
  }
}

function parse(data: unknown): unknown {
  try {
    return JSON.parse(String(data));
  } catch {
    return undefined;
  }
}
