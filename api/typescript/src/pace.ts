/** Least time over which a loop is judged, ms. */
const WINDOW_MS = 1e3;
/** Least number of periods over which a loop is judged: a single late answer of a slow loop is no reason to warn. */
const WINDOW_PERIODS = 50;
/** Share of the periods that may be without an answer. */
const ALLOWED_SHARE = 0.05;

/** Statistics of a control loop. */
export interface Drive {
  /** Number of control periods in which the loop ran: each had a command. */
  periods: number;
  /** Number of periods in which the answer to the period's own state came before its end. */
  answered: number;
  /** Number of answered states, in time or late. While an answer is late, no other state is sent. */
  steps: number;
  /** Number of periods that passed while the loop was busy with an earlier one. They had no state and no command. */
  skipped: number;
  /** Mean time between two answered states, s; infinite before the second one. */
  achievedPeriodS: number;
  /** Longest time between two answered states, s; 0 before the second one. */
  longestPeriodS: number;
}

/** Updates the statistics of a loop, and warns while it cannot keep its period. All times are arguments, in ms. */
export class Pace {
  readonly report: Drive = {
    periods: 0,
    answered: 0,
    steps: 0,
    skipped: 0,
    achievedPeriodS: Infinity,
    longestPeriodS: 0,
  };
  #number = -1;
  #window: Window;
  #firstMs = 0;
  #lastMs = 0;

  constructor(
    private readonly periodMs: number,
    startMs: number,
  ) {
    this.#window = new Window(0, startMs);
  }

  /** Starts a period, counted from 0; returns a warning if the loop was too slow in the window that ends here. */
  begin(number: number, nowMs: number): string | undefined {
    const skipped = number - this.#number - 1;
    this.#number = number;
    this.report.skipped += skipped;
    const window = this.#window;
    window.skipped += skipped;
    if (nowMs - window.startMs < Math.max(WINDOW_MS, WINDOW_PERIODS * this.periodMs)) return undefined;
    this.#window = new Window(number, nowMs);
    return window.warning(number, nowMs);
  }

  /** Counts the answer that came at `nowMs` to a state; `isInTime`: within the period of the state. */
  answer(measuredAtMs: number, nowMs: number, isInTime: boolean): void {
    this.#window.answers++;
    this.#window.waitedMs += nowMs - measuredAtMs;
    const report = this.report;
    report.steps++;
    if (isInTime) report.answered++;
    if (report.steps === 1) {
      this.#firstMs = measuredAtMs;
    } else {
      report.achievedPeriodS = (measuredAtMs - this.#firstMs) / 1e3 / (report.steps - 1);
      report.longestPeriodS = Math.max(report.longestPeriodS, (measuredAtMs - this.#lastMs) / 1e3);
    }
    this.#lastMs = measuredAtMs;
  }
}

/** The periods of the last second or so. */
class Window {
  answers = 0;
  waitedMs = 0;
  skipped = 0;

  constructor(
    readonly first: number,
    readonly startMs: number,
  ) {}

  /** Returns a warning with figures and remedy if too many periods before period `end` were without an answer. */
  warning(end: number, nowMs: number): string | undefined {
    const periods = end - this.first;
    const missing = periods - this.answers;
    if (missing <= ALLOWED_SHARE * periods) return undefined;
    const seconds = ((nowMs - this.startMs) / 1e3).toFixed(1);
    const waits =
      this.answers > 0 ? `answers took ${(this.waitedMs / this.answers).toFixed(1)} ms` : "no valid answer came";
    const remedy =
      2 * this.skipped > missing
        ? "The loop itself is late: make `read` and `write` faster, free the machine, or use a longer period."
        : "Use a longer period, or a stream.";
    return `The loop reached ${this.answers} of ${periods} periods in the last ${seconds} s; ${waits}. ${remedy}`;
  }
}
