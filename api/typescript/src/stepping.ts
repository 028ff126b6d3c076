import type { Measurement, State, StepAnswer } from "./bodies.js";
import type { CallOptions } from "./connection.js";

/** A running controller: once per period, a measured state goes in and joint velocities come out. */
export abstract class Stepping {
  #next = 0;

  constructor(
    /** Control period T, s. */
    readonly periodS: number,
  ) {}

  /**
   * Runs one control period. The state gets the next sequence number. If its answer is lost, the client sends the state
   * again with the same number; the service never runs the same number twice.
   */
  step(measurement: Measurement, options: CallOptions = {}): Promise<StepAnswer> {
    return this.stepState(this.number(measurement), options);
  }

  /** Runs one control period with a state that has its own sequence number. Sequence numbers must increase. */
  abstract stepState(state: State, options?: CallOptions): Promise<StepAnswer>;

  /** Adds the next sequence number to a measurement and, if it has no time, the start time of its period. */
  number(measurement: Measurement): State {
    const sequence = this.#next++;
    return { time_s: sequence * this.periodS, ...measurement, sequence };
  }

  /** Goes on after a state that has its own sequence number. */
  follow({ sequence }: State): void {
    this.#next = Math.max(this.#next, sequence + 1);
  }
}
