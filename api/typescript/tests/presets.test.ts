import assert from "node:assert/strict";
import { suite, test } from "node:test";
import { push } from "../src/index.js";
import { POSTURE, serve, testClient } from "./service.js";

suite("presets", () => {
  test("a push presses along one axis and holds the others", () => {
    const [press, hold] = push("z", -15, { approachSpeed: 0.01, stiffest: 1e5, maxForce: 60 });
    assert.deepEqual(press, {
      name: "push",
      axes: ["z"],
      law: {
        kind: "contact",
        target_force: { kind: "constant", value: -15 },
        approach_speed: 0.01,
        stiffest: 1e5,
        max_force: 60,
      },
    });
    assert.deepEqual(hold?.axes, ["x", "y", "rx", "ry", "rz"]);
    assert.equal(push("x", 5, { hold: null }).length, 1);
    assert.deepEqual(push("x", 5, { hold: ["y"] })[1]?.axes, ["y"]);
    assert.throws(() => push("x", 0), RangeError);
    assert.throws(() => push("x", Number.NaN), RangeError);
  });

  test("an answer to a push tells the contact", async (t) => {
    const client = testClient((await serve(t)).url);
    const session = await client.session({ robot: "sawyer_dh", period_s: 0.001, tasks: push("z", -15) });
    const wrench = { force: [0, 0, 0], torque: [0, 0, 0] };
    const { tasks } = await session.step({ joint_position: POSTURE, wrench });
    assert.equal(tasks[0]?.contact?.[0]?.state, "approach");
    assert.ok(tasks[0]!.contact![0]!.unavoidable_peak < 1.2 * 15);
    await session.close();
  });
});
