import assert from "node:assert/strict";
import { suite, test } from "node:test";
import type { Axis } from "../src/bodies.js";
import { push, wipe } from "../src/index.js";
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
    assert.throws(() => push("z", -15, { hold: ["z"] }), RangeError);
  });

  test("a wipe presses, moves from the start and back, and holds the others", async (t) => {
    const tasks = wipe("z", -15, "y", { strokeM: -0.2, speed: 0.05 });
    const [press, sweep, hold] = tasks;
    assert.equal(press?.law?.kind, "contact");
    const way = sweep?.law?.kind === "pose" ? sweep.law.target_displacement : undefined;
    const expected = { kind: "sine", offset: -0.1, amplitude: -0.1, angular_frequency_rad_s: 0.5, phase_rad: -Math.PI / 2 };
    assert.deepEqual(way, expected);
    assert.deepEqual(hold?.axes, ["x", "rx", "ry", "rz"]);
    for (const along of ["z", "rx"] as const) assert.throws(() => wipe("z", -15, along), RangeError);
    assert.throws(() => wipe("z", -15, "y", { strokeM: 0 }), RangeError);
    for (const hold of [["y"], ["z"], ["x", "x"]] as Axis[][]) {
      assert.throws(() => wipe("z", -15, "y", { hold }), RangeError);
    }
    assert.throws(() => wipe("z", -15, "y", { speed: 0 }), RangeError);
    assert.throws(() => wipe("z", -15, "y", { startTimeS: Number.NaN }), RangeError);
    const later = wipe("z", -15, "y", { startTimeS: 3 })[1]?.law;
    const phase = later?.kind === "pose" && later.target_displacement?.kind === "sine" ? later.target_displacement.phase_rad : undefined;
    assert.equal(phase, -Math.PI / 2 - 3);
    assert.throws(() => wipe("z", -15, "y", { maxTiltRad: 0 }), RangeError);
    const [push] = wipe("z", -15, "y", { maxTiltRad: 0.6 });
    assert.deepEqual(push?.law?.kind === "contact" ? push.law.surface : undefined, { max_tilt_rad: 0.6 });
    const client = testClient((await serve(t)).url);
    const session = await client.session({ robot: "sawyer_dh", period_s: 0.001, tasks });
    const wrench = { force: [0, 0, 0], torque: [0, 0, 0] };
    const answer = await session.step({ joint_position: POSTURE, wrench });
    assert.deepEqual(
      answer.tasks.map((task) => task.name),
      ["push", "wipe", "hold"],
    );
    await session.close();
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
