import type { Measurement } from "./bodies.js";
import { RevprioError } from "./errors.js";
import { Pace, type Drive } from "./pace.js";
import type { Stepping } from "./stepping.js";
import type { Watchdog } from "./watchdog.js";

/** Interface between `drive` and an arm. */
export interface Arm {
  /** Returns the current state. */
  read(): Measurement;
  /** Commands joint velocities: n, rad/s or m/s. */
  write(jointVelocity: number[]): void;
}

/** Options of `drive`. */
export interface DriveOptions {
  /**
   * Receives a warning, at most once per second, when more than 5 % of the periods were without an answer. The default
   * is `console.warn`.
   */
  onSlow?: (warning: string) => void;
}

/**
 * Runs a controller in real time. In each period it calls `read`, the service, and `write`. `write` receives a command
 * in every period, however late an answer is; the watchdog decides which command is allowed. While no answers come, the
 * arm slows down to rest. The loop continues if an answer comes before the arm is at rest.
 *
 * The arm is at rest when the loop ends. The loop ends
 * - when the signal is aborted (the normal way);
 * - when the arm has come to rest because no answers came: rejects with the last error;
 * - when the service refuses a state: rejects with that error;
 * - when `read` throws.
 *
 * Answers that come after the end are ignored. Timers in JavaScript allow about 250 Hz. A page in the background gets
 * only one timer event per second.
 */
export async function drive(
  stepping: Stepping,
  arm: Arm,
  watchdog: Watchdog,
  signal: AbortSignal,
  { onSlow = (warning) => console.warn(warning) }: DriveOptions = {},
): Promise<Drive> {
  const periodMs = stepping.periodS * 1e3;
  const startMs = performance.now();
  const pace = new Pace(periodMs, startMs);
  let noAnswer: RevprioError | undefined;
  let refusal: unknown;
  let call: Promise<void> | undefined;
  let isOver = false;
  const step = async (measurement: Measurement, measuredAtMs: number, endMs: number) => {
    try {
      const answer = await stepping.step({ time_s: (measuredAtMs - startMs) / 1e3, ...measurement });
      if (isOver || signal.aborted) return;
      noAnswer = undefined;
      const nowMs = performance.now();
      if (watchdog.obey(answer, measuredAtMs, nowMs)) pace.answer(measuredAtMs, nowMs, nowMs <= endMs);
    } catch (error) {
      if (error instanceof RevprioError && error.isSilence) noAnswer = error;
      else refusal = error;
    } finally {
      call = undefined;
    }
  };
  try {
    for (let period = 0; !signal.aborted; ) {
      const endMs = startMs + (period + 1) * periodMs;
      const warning = pace.begin(period, performance.now());
      if (warning !== undefined) onSlow(warning);
      const measurement = arm.read();
      call ??= step(measurement, performance.now(), endMs);
      await Promise.race([call, until(endMs)]);
      if (refusal !== undefined) throw refusal;
      if (noAnswer !== undefined && watchdog.isAtRest(performance.now())) throw noAnswer;
      arm.write(watchdog.command(performance.now() + periodMs));
      pace.report.periods++;
      await until(endMs);
      period = Math.max(period + 1, Math.floor((performance.now() - startMs) / periodMs));
    }
    return pace.report;
  } finally {
    isOver = true;
    watchdog.expire(performance.now());
    while (!watchdog.isAtRest(performance.now())) {
      arm.write(watchdog.command(performance.now() + periodMs));
      await until(performance.now() + periodMs);
    }
    arm.write(watchdog.command(performance.now()));
  }
}

function until(timeMs: number): Promise<void> {
  return new Promise((resolve) => setTimeout(resolve, Math.max(timeMs - performance.now(), 0)));
}
