import type { Measurement } from "./bodies.js";
import { RevprioError } from "./errors.js";
import type { Stepping } from "./stepping.js";
import type { Watchdog } from "./watchdog.js";

/** What a loop needs of an arm. */
export interface Arm {
  /** The state now. */
  read(): Measurement;
  /** Joint velocities to follow from now on: n, rad/s or m/s. */
  write(jointVelocity: number[]): void;
}

/** How a loop went. */
export interface Drive {
  periods: number;
  /** Periods with an answer to their own state before their end. */
  answered: number;
}

/**
 * Runs a controller in real time: once per period read, call, write. `write` is heard in every period, with what the
 * watchdog allows, however late an answer is. While the service is silent the arm ramps to rest; if it answers before
 * that, the loop goes on. It ends with the arm at rest: when the signal says so, which is the ordinary way; when silence
 * has led to rest, with the last error; when the service refuses a state, with that error; and when `read` throws. Answers
 * that come after that do not count.
 *
 * Timers of JavaScript are good for some 250 Hz; a page in the background gets one a second.
 */
export async function drive(stepping: Stepping, arm: Arm, watchdog: Watchdog, signal: AbortSignal): Promise<Drive> {
  const report: Drive = { periods: 0, answered: 0 };
  const periodMs = stepping.periodS * 1e3;
  const startMs = performance.now();
  let silence: RevprioError | undefined;
  let refusal: unknown;
  let call: Promise<void> | undefined;
  let isOver = false;
  const ask = async (measurement: Measurement, measuredAtMs: number, period: number) => {
    try {
      const answer = await stepping.step({ time_s: (measuredAtMs - startMs) / 1e3, ...measurement });
      if (isOver || signal.aborted) return;
      silence = undefined;
      if (watchdog.obey(answer, measuredAtMs, performance.now()) && period === report.periods) report.answered++;
    } catch (error) {
      if (error instanceof RevprioError && error.isSilence) silence = error;
      else refusal = error;
    } finally {
      call = undefined;
    }
  };
  try {
    while (!signal.aborted) {
      const endMs = startMs + (Math.floor((performance.now() - startMs) / periodMs) + 1) * periodMs;
      const measurement = arm.read();
      call ??= ask(measurement, performance.now(), report.periods);
      await Promise.race([call, until(endMs)]);
      if (refusal !== undefined) throw refusal;
      if (silence !== undefined && watchdog.isAtRest(performance.now())) throw silence;
      arm.write(watchdog.command(performance.now()));
      report.periods++;
      await until(endMs);
    }
    return report;
  } finally {
    isOver = true;
    watchdog.expire(performance.now());
    while (!watchdog.isAtRest(performance.now())) {
      arm.write(watchdog.command(performance.now()));
      await until(performance.now() + periodMs);
    }
    arm.write(watchdog.command(performance.now()));
  }
}

function until(timeMs: number): Promise<void> {
  return new Promise((resolve) => setTimeout(resolve, Math.max(timeMs - performance.now(), 0)));
}
