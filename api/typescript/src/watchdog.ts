import type { Robot, StepAnswer } from "./bodies.js";

/**
 * Gives the joint velocities to command at any time, whether answers come or not.
 *
 * The last answer counts for `valid_for_ms` from the moment at which its *state* was measured. After that each joint
 * slows down to rest with its largest acceleration, and stays there until a newer answer comes. Time is an argument, in
 * milliseconds of any clock that does not go back, such as `performance.now()`.
 */
export class Watchdog {
  #velocity: readonly number[];
  #measuredAtMs = -Infinity;
  #expiresAtMs = -Infinity;

  /** `accelerationLimit`: n, rad/s² or m/s². */
  constructor(private readonly accelerationLimit: readonly number[]) {
    if (accelerationLimit.length === 0 || !accelerationLimit.every((limit) => limit > 0)) {
      throw new RangeError(`accelerationLimit: give one positive number per joint, not [${accelerationLimit}]`);
    }
    this.#velocity = accelerationLimit.map(() => 0);
  }

  /** With the acceleration limits of a robot, as `Client.robot` gives it. */
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
   * Takes an answer that comes now (ms) to a state that was measured before (ms). `false` if it does not count: it has
   * expired, or a state that was measured later was answered before.
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

  /** Joint velocities to command at a time (ms): n, rad/s or m/s. */
  command(nowMs: number): number[] {
    const silenceS = Math.max(nowMs - this.#expiresAtMs, 0) / 1e3;
    return this.#velocity.map((velocity, joint) => {
      const lost = silenceS === 0 ? 0 : (this.accelerationLimit[joint] ?? 0) * silenceS;
      return Math.sign(velocity) * Math.max(Math.abs(velocity) - lost, 0);
    });
  }

  /** Lets the ramp begin at a time (ms), if it has not yet. */
  expire(nowMs: number): void {
    this.#expiresAtMs = Math.min(this.#expiresAtMs, nowMs);
  }

  /** Whether the ramp is over at a time, ms. */
  isAtRest(nowMs: number): boolean {
    return nowMs >= this.#expiresAtMs && this.command(nowMs).every((velocity) => velocity === 0);
  }
}
