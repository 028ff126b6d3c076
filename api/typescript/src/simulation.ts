import type { Simulation, SimulationControl, StepRequest } from "./bodies.js";
import type { CallOptions, Client } from "./client.js";
import { RevprioError } from "./errors.js";

/** Between two looks at a running experiment, ms. */
const POLL_MS = 100;

/** An experiment, queued, running or ended; `Client.simulate` starts it. */
export class SimulationRun {
  constructor(
    private readonly client: Client,
    readonly id: string,
  ) {}

  /** State and progress (0 … 1); metrics once it is finished. */
  status(options?: CallOptions): Promise<Simulation> {
    return this.client.call("GET", this.#path(), undefined, options);
  }

  /** Waits for its end; rejects if it failed or was cancelled. */
  async result(options: CallOptions = {}): Promise<Simulation> {
    for (;;) {
      const status = await this.status(options);
      if (status.state === "finished") return status;
      if (status.state === "failed" || status.state === "cancelled") {
        throw new RevprioError(`simulation ${this.id} ${status.state}: ${status.error ?? "see who deleted it"}`);
      }
      await new Promise((resolve) => setTimeout(resolve, POLL_MS));
    }
  }

  /** Paces and changes an interactive run: `run.control({ paused: false, speed: 0.5 })`. */
  control(order: SimulationControl, options?: CallOptions): Promise<Simulation> {
    return this.client.call("POST", `${this.#path()}/control`, order, options);
  }

  /** The latest control period of an interactive run, as a request for `Client.step`. */
  cycle(options?: CallOptions): Promise<StepRequest> {
    return this.client.call("GET", `${this.#path()}/cycle`, undefined, options);
  }

  /** Every control period of a finished run, as the service writes it in JSON. */
  trace(options?: CallOptions): Promise<unknown> {
    return this.client.call("GET", `${this.#path()}/trace`, undefined, options);
  }

  /** Ends it, or forgets it once it has ended. */
  cancel(options?: CallOptions): Promise<void> {
    return this.client.call("DELETE", this.#path(), undefined, options);
  }

  #path(): string {
    return `/v1/simulations/${encodeURIComponent(this.id)}`;
  }
}
