import type { Robot, StepAnswer } from "./bodies.js";

/**
 * Computes the joint velocities to command at any time, also when no answers come.
 *
 * An answer is valid for `valid_for_ms` from the moment at which its *state* was measured. After that, each joint slows
 * down to rest at its maximum acceleration and stays at rest until a newer answer comes. All times are arguments, in
 * milliseconds of any monotonic clock, such as `performance.now()`.
 */
export class Watchdog {
  #velocity: readonly number[];
  #measuredAtMs = -Infinity;
  #expiresAtMs = -Infinity;

  /** `accelerationLimit`: maximum acceleration of each joint, n, rad/s² or m/s². */
  constructor(private readonly accelerationLimit: readonly number[]) {
    if (accelerationLimit.length === 0 || !accelerationLimit.every((limit) => limit > 0)) {
      throw new RangeError(`accelerationLimit: give one positive number per joint, not [${accelerationLimit}]`);
    }
    this.#velocity = accelerationLimit.map(() => 0);
  }

  /** Creates a watchdog with the acceleration limits of a robot, as `Client.robot` returns it. */
  static of(robot: Robot): Watchdog {
    return new Watchdog(
      robot.joints.map((joint) => {
        if (joint.acceleration_limit == null) {
          throw new RangeError(`${robot.name}: ${joint.name} has no acceleration limit; use new Watchdog([…]) with your own`);
        }
        return joint.acceleration_limit;
      }),
    );
  }

  /**
   * Accepts the answer that came at `nowMs` to the state measured at `measuredAtMs`. Returns `false` and ignores the
   * answer if it has expired, or if an answer to a later state was accepted before.
   */
  obey(answer: StepAnswer, measuredAtMs: number, nowMs: number): boolean {
    const velocity = answer.joint_velocity;
    if (velocity.length !== this.accelerationLimit.length) {
      throw new RangeError(`${velocity.length} joint velocities for ${this.accelerationLimit.length} joints`);
    }
    const expiresAtMs = measuredAtMs + answer.valid_for_ms;
    if (nowMs > expiresAtMs || measuredAtMs < this.#measuredAtMs) return false;
    this.#velocity = velocity;
    this.#measuredAtMs = measuredAtMs;
    this.#expiresAtMs = expiresAtMs;
    return true;
  }

  /** Returns the joint velocities to command at `nowMs`: n, rad/s or m/s. */
  command(nowMs: number): number[] {
    const silenceS = Math.max(nowMs - this.#expiresAtMs, 0) / 1e3;
    return this.#velocity.map((velocity, joint) => {
      const decrease = silenceS === 0 ? 0 : (this.accelerationLimit[joint] ?? 0) * silenceS;
      return Math.sign(velocity) * Math.max(Math.abs(velocity) - decrease, 0);
    });
  }

  /** Starts the ramp to rest at `nowMs`, if it has not started yet. */
  expire(nowMs: number): void {
    this.#expiresAtMs = Math.min(this.#expiresAtMs, nowMs);
  }

  /** Returns whether the ramp is over and all joints are at rest at `nowMs`. */
  isAtRest(nowMs: number): boolean {
    return nowMs >= this.#expiresAtMs && this.command(nowMs).every((velocity) => velocity === 0);
  }
}
