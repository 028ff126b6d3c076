import assert from "node:assert/strict";
import { suite, test } from "node:test";
import { setTimeout } from "node:timers/promises";
import { drive, Stepping, Watchdog, type StepAnswer } from "../src/index.js";
import { Pace } from "../src/pace.js";
import { AT_REST, example } from "./service.js";

/** Returns the statistics and warnings of a loop whose answers take these times. */
function simulate(periodMs: number, answersMs: number[]) {
  const pace = new Pace(periodMs, 0);
  const begun: (string | undefined)[] = [];
  let period = 0;
  for (const answerMs of answersMs) {
    begun.push(pace.begin(period, period * periodMs));
    pace.answer(period * periodMs, period * periodMs + answerMs, answerMs <= periodMs);
    const following = period + Math.ceil(answerMs / periodMs);
    for (period++; period < following; period++) begun.push(pace.begin(period, period * periodMs));
  }
  return { report: pace.report, warnings: begun.filter((warning) => warning !== undefined) };
}

suite("pace", () => {
  test("answers of two periods give one warning per second, with figures and remedy", () => {
    const { report, warnings } = simulate(1, Array(1600).fill(1.9));
    const expected =
      "The loop reached 500 of 1000 periods in the last 1.0 s; answers took 1.9 ms. Use a longer period, or a stream.";
    assert.deepEqual(warnings, [expected, expected, expected]);
    const { steps, answered, skipped, longestPeriodS } = report;
    assert.deepEqual({ steps, answered, skipped, longestPeriodS }, { steps: 1600, answered: 0, skipped: 0, longestPeriodS: 0.002 });
    assert.ok(Math.abs(report.achievedPeriodS - 0.002) < 1e-12);
  });

  test("single late answers give no warning", () => {
    for (const periodMs of [1, 10, 50, 1000]) {
      const answers = [...Array(49).fill(0.2 * periodMs), 2.5 * periodMs];
      const { report, warnings } = simulate(periodMs, Array(100).fill(answers).flat());
      assert.deepEqual(warnings, []);
      assert.equal(report.answered, 4900);
      assert.ok(Math.abs(report.longestPeriodS - 0.003 * periodMs) < 1e-9);
    }
  });

  test("skipped periods are counted and have another remedy", () => {
    const pace = new Pace(10, 0);
    for (let period = 0; period < 100; period += 2) {
      assert.equal(pace.begin(period, 10 * period), undefined);
      pace.answer(10 * period, 10 * period + 1, true);
    }
    assert.match(pace.begin(100, 1000) ?? "", /reached 50 of 100 periods .* took 1\.0 ms\. The loop itself is late/);
    assert.equal(pace.report.skipped, 50);
  });

  test("a loop with a slow controller warns on the console", async (t) => {
    class Slow extends Stepping {
      override async stepState(): Promise<StepAnswer> {
        await setTimeout(25);
        return { ...example("answers/step"), joint_velocity: Array(7).fill(0), valid_for_ms: 100 };
      }
    }
    const abort = new AbortController();
    const warn = t.mock.method(console, "warn", () => abort.abort());
    const arm = { read: () => AT_REST, write: () => undefined };
    const report = await drive(new Slow(0.01), arm, new Watchdog(Array(7).fill(8)), abort.signal);
    assert.equal(warn.mock.callCount(), 1);
    const [, reached, periods] = /reached (\d+) of (\d+) periods/.exec(String(warn.mock.calls[0]!.arguments[0]))!;
    // A busy machine makes the loop slower, never faster.
    assert.ok(Number(reached) <= Number(periods) / 2 && Number(periods) >= 99);
    assert.ok(report.answered === 0 && report.achievedPeriodS >= 0.024);
    assert.ok(report.longestPeriodS >= report.achievedPeriodS);
  });
});
