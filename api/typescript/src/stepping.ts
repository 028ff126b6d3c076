import type { Measurement, State, StepAnswer } from "./bodies.js";
import type { CallOptions } from "./client.js";

/** Something that takes a measured state and answers with joint velocities, once per period. */
export abstract class Stepping {
  #next = 0;

  constructor(
    /** T, s. */
    readonly periodS: number,
  ) {}

  /**
   * One control period. The state gets the next sequence number; where its answer is lost on the way it is sent again
   * under the same one, which is never stepped twice.
   */
  step(measurement: Measurement, options: CallOptions = {}): Promise<StepAnswer> {
    return this.stepState(this.number(measurement), options);
  }

  /** One control period with a state that has its own sequence number, which must grow. */
  abstract stepState(state: State, options?: CallOptions): Promise<StepAnswer>;

  /** Gives a measurement the next sequence number and, where it has none, the time at which its period begins. */
  number(measurement: Measurement): State {
    const sequence = this.#next++;
    return { time_s: sequence * this.periodS, ...measurement, sequence };
  }
}
