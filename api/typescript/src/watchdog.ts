import type { Robot, StepAnswer } from "./bodies.js";

/** Times that differ by less are equal, because sums of periods are not exact. */
const ROUNDING_S = 1e-9;

/** Velocities that differ by less are equal for the same reason, rad/s or m/s. */
const ARRIVED = 1e-9;

/**
 * Computes the joint velocities to command at any time, also when no answers come.
 *
 * An answer is valid for `valid_for_ms` from the moment at which its *state* was measured. After that, the joints brake
 * together within the answer's `stop_time_s`, or each at `braking_deceleration` if the answer has none, and stay at rest
 * until a newer answer comes. If the controller's limits include positions, every joint then stops inside its range. When
 * answers come again, the joints accelerate with `braking_deceleration` until they have the velocity of the answer. All
 * times are arguments, in milliseconds of any monotonic clock, such as `performance.now()`.
 */
export class Watchdog {
  #velocity: readonly number[];
  #deceleration: readonly number[];
  #stopTimeS: number | null = null;
  #measuredAtMs = -Infinity;
  #expiresAtMs = -Infinity;
  #commanded: readonly number[];
  #commandedAtMs = -Infinity;
  /** Whether commands must return from the last command to the answers. */
  #resumes = false;
  #hasAnswer = false;

  /**
   * `accelerationLimit`: deceleration of each joint, n, rad/s² or m/s², for joints for which the answer has none. The
   * answer has precedence, because its `valid_for_ms` is correct for its own deceleration only.
   */
  constructor(private readonly accelerationLimit: readonly number[]) {
    if (accelerationLimit.length === 0 || !accelerationLimit.every((limit) => limit > 0)) {
      throw new RangeError(`accelerationLimit: give one positive number per joint, not [${accelerationLimit}]`);
    }
    this.#velocity = accelerationLimit.map(() => 0);
    this.#commanded = this.#velocity;
    this.#deceleration = accelerationLimit;
  }

  /**
   * Creates a watchdog for a robot, as `Client.robot` returns it. A joint without any deceleration, in the answer or in the
   * robot, stops at once.
   */
  static of(robot: Robot): Watchdog {
    return new Watchdog(robot.joints.map((joint) => joint.acceleration_limit ?? Infinity));
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
    const isFirst = !this.#hasAnswer;
    this.#hasAnswer = true;
    if (nowMs > expiresAtMs || measuredAtMs < this.#measuredAtMs) return false;
    // Before the first answer there is no ramp to return from: the service counts with its answer at once.
    this.#resumes ||= !isFirst && this.#commandedAtMs - this.#expiresAtMs > ROUNDING_S * 1e3;
    this.#velocity = velocity;
    this.#measuredAtMs = measuredAtMs;
    this.#expiresAtMs = expiresAtMs;
    this.#stopTimeS = answer.stop_time_s ?? null;
    this.#deceleration = this.accelerationLimit.map((own, joint) => answer.braking_deceleration?.[joint] ?? own);
    return true;
  }

  /**
   * Returns the joint velocities to command at `nowMs`: n, rad/s or m/s. The arm keeps a command until the next one. In a
   * loop, use the time of the next command instead of the present time: then the arm is never faster than the ramp.
   * `drive` does so.
   */
  command(nowMs: number): number[] {
    const velocity = this.#resumed(nowMs);
    const ramp = this.#ramp(nowMs);
    this.#resumes &&= velocity.some((entry, joint) => Math.abs(entry - (ramp[joint] ?? 0)) > ARRIVED);
    this.#commanded = velocity;
    this.#commandedAtMs = nowMs;
    return velocity;
  }

  /** Returns the velocities of the last answer; after it has expired, those of the ramp to rest. */
  #ramp(nowMs: number): number[] {
    const silenceS = (nowMs - this.#expiresAtMs) / 1e3;
    const stopTimeS = this.#stopTimeS;
    if (silenceS > ROUNDING_S && stopTimeS !== null) {
      const share = Math.max(1 - silenceS / stopTimeS, 0);
      return this.#velocity.map((velocity) => velocity * share);
    }
    return this.#velocity.map((velocity, joint) => {
      const decrease = silenceS <= ROUNDING_S ? 0 : (this.#deceleration[joint] ?? 0) * silenceS;
      return Math.sign(velocity) * Math.max(Math.abs(velocity) - decrease, 0);
    });
  }

  /** Returns the ramp; after an interruption what is within reach from the last command. */
  #resumed(nowMs: number): number[] {
    const ramp = this.#ramp(nowMs);
    if (!this.#resumes) return ramp;
    const elapsedS = Math.max(nowMs - this.#commandedAtMs, 0) / 1e3;
    return ramp.map((velocity, joint) => {
      const deceleration = this.#deceleration[joint] ?? Infinity;
      const reach = deceleration === Infinity ? Infinity : deceleration * elapsedS;
      const last = this.#commanded[joint] ?? 0;
      return Math.min(Math.max(velocity, last - reach), last + reach);
    });
  }

  /** Starts the ramp to rest at `nowMs`, if it has not started yet. */
  expire(nowMs: number): void {
    this.#expiresAtMs = Math.min(this.#expiresAtMs, nowMs);
  }

  /** Returns whether the ramp is over and all joints are at rest at `nowMs`. */
  isAtRest(nowMs: number): boolean {
    return nowMs >= this.#expiresAtMs && this.#resumed(nowMs).every((velocity) => velocity === 0);
  }
}
