import type { State, StepAnswer } from "./bodies.js";
import type { CallOptions, Connection } from "./connection.js";
import { ForeignAnswerError, isProblem, LateAnswerError, NoAnswerError, ProblemError } from "./errors.js";
import type { WebSocketLike } from "./socket.js";
import { Stepping } from "./stepping.js";

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
    private readonly connection: Connection,
    private readonly session: Stepping,
    private readonly socket: WebSocketLike,
  ) {
    super(session.periodS);
    const end = (cause: unknown) => {
      this.#failure ??= new NoAnswerError(connection.url, cause);
      for (const pending of this.#pending.splice(0)) pending.reject(this.#failure);
    };
    socket.addEventListener("close", () => end("the connection was closed"));
    socket.addEventListener("error", (event) => end("message" in event ? event.message : "the connection failed"));
    socket.addEventListener("message", ({ data }) => this.#handleMessage(data));
  }

  /** Opens the connection. */
  static async open(connection: Connection, session: Stepping, path: string, options: CallOptions): Promise<Stream> {
    const { signal, timeoutMs = connection.timeoutMs } = options;
    signal?.throwIfAborted();
    const stream = new Stream(connection, session, connection.webSocket(path));
    const isOpen = new Promise<void>((resolve, reject) => {
      stream.#pending.push({ resolve: () => resolve(), reject });
      stream.socket.addEventListener("open", () => (stream.#pending.shift(), resolve()));
    });
    const giveUp = (cause: unknown) => (stream.#pending.shift()?.reject(cause), stream.close());
    const stop = () => giveUp(signal?.reason);
    const late = () => giveUp(new LateAnswerError(connection.url, `no connection within ${timeoutMs} ms`));
    const timer = setTimeout(late, timeoutMs);
    signal?.addEventListener("abort", stop, { once: true });
    try {
      await isOpen;
    } finally {
      clearTimeout(timer);
      signal?.removeEventListener("abort", stop);
    }
    return stream;
  }

  /** Uses the sequence numbers of the session, so that the session and its stream never use the same number. */
  override number(measurement: Parameters<Stepping["number"]>[0]): State {
    return this.session.number(measurement);
  }

  override follow(state: State): void {
    this.session.follow(state);
  }

  override stepState(state: State, { signal, timeoutMs = this.connection.stepTimeoutMs }: CallOptions = {}): Promise<StepAnswer> {
    this.follow(state);
    return new Promise((resolve, reject) => {
      signal?.throwIfAborted();
      if (this.#failure) throw this.#failure;
      const stop = () => reject(signal?.reason);
      const late = () => reject(new LateAnswerError(this.connection.url, `no reply within ${timeoutMs} ms`));
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
    else if (reply === undefined) pending?.reject(new ForeignAnswerError(this.connection.url, 200));
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
