import type { Simulation, SimulationControl, StepRequest } from "./bodies.js";
import type { CallOptions, Connection } from "./connection.js";
import { RevprioError } from "./errors.js";

/** Interval between two status requests, ms. */
const POLL_MS = 100;

/** A simulation that is queued, running or finished; `Client.simulate` starts it. */
export class SimulationRun {
  constructor(
    private readonly connection: Connection,
    readonly id: string,
  ) {}

  /** Returns state and progress (0 … 1); includes metrics once the simulation is finished. */
  status(options?: CallOptions): Promise<Simulation> {
    return this.connection.call("GET", this.#path(), undefined, options);
  }

  /** Waits for the end; rejects if the simulation failed or was cancelled. */
  async result(options: CallOptions = {}): Promise<Simulation> {
    for (;;) {
      const status = await this.status(options);
      if (status.state === "finished") return status;
      if (status.state === "failed" || status.state === "cancelled") {
        throw new RevprioError(`simulation ${this.id} ${status.state}: ${status.error ?? "a client deleted it"}`);
      }
      await new Promise((resolve) => setTimeout(resolve, POLL_MS));
    }
  }

  /** Controls an interactive run: `run.control({ paused: false, speed: 0.5 })`. */
  control(command: SimulationControl, options?: CallOptions): Promise<Simulation> {
    return this.connection.call("POST", `${this.#path()}/control`, command, options);
  }

  /** Returns the latest control period of an interactive run, as a request for `Client.step`. */
  cycle(options?: CallOptions): Promise<StepRequest> {
    return this.connection.call("GET", `${this.#path()}/cycle`, undefined, options);
  }

  /** Returns all control periods of a finished run, in the JSON format of the service. */
  trace(options?: CallOptions): Promise<unknown> {
    return this.connection.call("GET", `${this.#path()}/trace`, undefined, options);
  }

  /** Cancels a running simulation; deletes a finished one. */
  cancel(options?: CallOptions): Promise<void> {
    return this.connection.call("DELETE", this.#path(), undefined, options);
  }

  #path(): string {
    return `/v1/simulations/${encodeURIComponent(this.id)}`;
  }
}
