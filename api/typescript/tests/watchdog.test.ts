import assert from "node:assert/strict";
import { test } from "node:test";
import { Watchdog, type Robot } from "../src/index.js";
import { example } from "./service.js";

const ANSWER = {
  ...example("answers/step"),
  joint_velocity: [0.4, -0.1],
  valid_for_ms: 100,
  stop_time_s: null,
  braking_deceleration: [],
};

function assertClose(actual: number[], expected: number[]): void {
  actual.forEach((entry, joint) => assert.ok(Math.abs(entry - expected[joint]!) < 1e-9, `${actual}`));
}

test("nothing moves before the first answer", () => {
  const watchdog = new Watchdog([2, 2]);
  assertClose(watchdog.command(0), [0, 0]);
  assert.ok(watchdog.isAtRest(0));
});

test("the first answer counts at once although rest was commanded before", () => {
  const watchdog = new Watchdog([2, 4]);
  assertClose(watchdog.command(900), [0, 0]);
  assert.ok(watchdog.obey(ANSWER, 1000, 1010));
  assertClose(watchdog.command(1010), [0.4, -0.1]);
});

test("an answer after an expired first one is reached evenly", () => {
  const watchdog = new Watchdog([2, 4]);
  watchdog.command(900);
  assert.ok(!watchdog.obey(ANSWER, 800, 950));
  assert.ok(watchdog.obey(ANSWER, 1000, 1000));
  assertClose(watchdog.command(1000), [0.2, -0.1]);
});

test("an answer is held while valid, then each joint brakes at its own limit", () => {
  const watchdog = new Watchdog([2, 4]);
  assert.ok(watchdog.obey(ANSWER, 1000, 1010));
  assertClose(watchdog.command(1100), [0.4, -0.1]);
  assertClose(watchdog.command(1110), [0.38, -0.06]);
  assertClose(watchdog.command(1200), [0.2, 0]);
  assertClose(watchdog.command(1301), [0, 0]);
  assert.ok(!watchdog.isAtRest(1290) && watchdog.isAtRest(1301));
});

test("rounding does not prolong the return", () => {
  const watchdog = new Watchdog([2, 4]);
  watchdog.obey(ANSWER, 1000, 1000);
  watchdog.command(1200);
  assert.ok(watchdog.obey({ ...ANSWER, joint_velocity: [0.22 + 1e-12, 0] }, 1210, 1210));
  watchdog.command(1210);
  assert.ok(watchdog.obey({ ...ANSWER, joint_velocity: [1, 1] }, 1220, 1220));
  assertClose(watchdog.command(1220), [1, 1]);
});

test("all joints come to rest together if the answer says when", () => {
  const watchdog = new Watchdog([2, 4]);
  assert.ok(watchdog.obey({ ...ANSWER, stop_time_s: 0.2 }, 1000, 1000));
  assertClose(watchdog.command(1100), [0.4, -0.1]);
  assertClose(watchdog.command(1150), [0.3, -0.075]);
  assert.ok(!watchdog.isAtRest(1290) && watchdog.isAtRest(1301));
  // Afterwards each joint accelerates at its own limit, and the next answer may brake otherwise.
  watchdog.command(1300);
  assert.ok(watchdog.obey(ANSWER, 1300, 1300));
  assertClose(watchdog.command(1310), [0.02, -0.04]);
  assertClose(watchdog.command(1500), [0.2, 0]);
});

test("an expired or older answer is ignored", () => {
  const watchdog = new Watchdog([2, 4]);
  assert.ok(!watchdog.obey(ANSWER, 1000, 1101));
  assert.ok(watchdog.obey(ANSWER, 1000, 1001));
  assert.ok(!watchdog.obey(ANSWER, 999, 1001));
  watchdog.expire(1050);
  assertClose(watchdog.command(1100), [0.3, 0]);
});

test("limits must be one positive number per joint", () => {
  for (const wrong of [[], [0], [-1], [NaN]]) assert.throws(() => new Watchdog(wrong), /positive number per joint/);
  assert.throws(() => new Watchdog([1, 1, 1]).obey(ANSWER, 0, 0), /2 joint velocities for 3 joints/);
});

test("the deceleration of the answer has precedence, and a joint without any stops at once", () => {
  const joints = [2, undefined].map((acceleration_limit) => ({ name: "j", kind: "revolute", unit: "rad", acceleration_limit }));
  const robot = { name: "r", description: "", source: "urdf", joints } as Robot;
  const watchdog = Watchdog.of(robot);
  watchdog.obey(ANSWER, 1000, 1000);
  assertClose(watchdog.command(1110), [0.38, 0]);
  const told = Watchdog.of(robot);
  told.obey({ ...ANSWER, braking_deceleration: [8, 4] }, 1000, 1000);
  assertClose(told.command(1110), [0.32, -0.06]);
});

test("after a ramp the joints accelerate to the new answer", () => {
  const watchdog = new Watchdog([2, 4]);
  watchdog.obey(ANSWER, 1000, 1000);
  assertClose(watchdog.command(1200), [0.2, 0]);
  assert.ok(watchdog.obey({ ...ANSWER, joint_velocity: [0.3, -1] }, 1200, 1205));
  assertClose(watchdog.command(1210), [0.22, -0.04]);
  assertClose(watchdog.command(1290), [0.3, -0.36]);
  watchdog.expire(1290);
  assert.ok(!watchdog.isAtRest(1300) && watchdog.isAtRest(2000));
  assert.ok(watchdog.obey({ ...ANSWER, joint_velocity: [0.3, -1] }, 1600, 1600));
  assertClose(watchdog.command(1650), [0.3, -1]);
  // From now on every answer counts at once, as long as answers come.
  assert.ok(watchdog.obey(ANSWER, 1660, 1660));
  assertClose(watchdog.command(1660), [0.4, -0.1]);
});
