import assert from "node:assert/strict";
import { suite, test } from "node:test";
import { setTimeout } from "node:timers/promises";
import { Client, drive, LateAnswerError, NoAnswerError, ProblemError, Stepping, Watchdog } from "../src/index.js";
import type { ChunkAction, Robot, Scenario, State, StepAnswer } from "../src/index.js";
import { AT_REST, CONTROLLER, example, startFaultyProxy, testClient, POSTURE, serve, SLOW } from "./service.js";

/** Runs a closed loop whose force is 1000 N per rad of the first joint; returns the commands. */
async function run(controller: Stepping): Promise<number[][]> {
  const commands: number[][] = [];
  let q = POSTURE;
  for (let period = 0; period < 20; period++) {
    const force = [1000 * (q[0]! - POSTURE[0]!), 0, 0];
    const { joint_velocity } = await controller.step({ joint_position: q, wrench: { force, torque: [0, 0, 0] } });
    commands.push(joint_velocity);
    q = q.map((position, joint) => position + CONTROLLER.period_s * joint_velocity[joint]!);
  }
  return commands;
}

/** Returns the x coordinate of the tool, m: applies the Denavit-Hartenberg transforms from the tool to the base. */
function toolX(joints: Robot["joints"], q: number[]): number {
  return joints.reduceRight(
    ([x, y, z], { denavit_hartenberg: link }, joint) => {
      const { d_m, a_m, alpha_rad, theta_rad } = link!;
      const theta = theta_rad + q[joint]!;
      const [u, v] = [x + a_m, Math.cos(alpha_rad) * y - Math.sin(alpha_rad) * z];
      return [
        Math.cos(theta) * u - Math.sin(theta) * v,
        Math.sin(theta) * u + Math.cos(theta) * v,
        Math.sin(alpha_rad) * y + Math.cos(alpha_rad) * z + d_m,
      ] as [number, number, number];
    },
    [0, 0, 0] as [number, number, number],
  )[0];
}

suite("controllers", () => {
  test("a session has the warnings about its controller, also about one that replaces it", async (t) => {
    const client = testClient((await serve(t)).url);
    const session = await client.session(CONTROLLER);
    assert.deepEqual(session.warnings, session.created.warnings ?? []);
    await session.replace({ ...CONTROLLER, limits: "velocity" });
    assert.match(session.warnings.join(), /the limits `velocity` leave out the acceleration limits/);
    await session.close();
  });

  test("session, stateless and stream give identical answers", async (t) => {
    const client = testClient((await serve(t)).url);
    const session = await client.session(CONTROLLER);
    const expected = await run(session);
    assert.equal((await session.status()).last_sequence, 19);
    await session.close();
    await assert.rejects(session.status(), { type: "/problems/unknown-controller" });
    assert.deepEqual(await run(client.stateless(CONTROLLER)), expected);
    const stream = await (await client.session(CONTROLLER)).stream();
    assert.deepEqual(await run(stream), expected);
    stream.close();
    await assert.rejects(stream.step(AT_REST), NoAnswerError);
    assert.ok(Math.max(...expected.flat().map(Math.abs)) > 0);
  });

  test("a chunk of actions leads the arm, and a wrong one is refused with a pointer", async (t) => {
    const pose = { kind: "pose", gain: 5 } as const;
    const tasks = [{ name: "hand", axes: ["x", "y", "z"] as ("x" | "y" | "z")[], law: pose }];
    const session = await testClient((await serve(t)).url).session({ ...CONTROLLER, tasks });
    const chunk: ChunkAction[] = [0, 1, 2].map((k) => ({ time_s: k / 30, position: [0.5, 0.1 * k, 0.3] }));
    const answer = await session.step({ ...AT_REST, targets: { hand: { chunk, align: "time" } } });
    assert.deepEqual(answer.tasks[0]!.chunk, { actions_left: 2, ends_in_s: 2 / 30, dropped: 1, shift_s: 0 });
    const twice = { hand: { chunk: [chunk[0]!, chunk[0]!] } };
    await assert.rejects(session.step({ ...AT_REST, targets: twice }), { pointer: "/targets/hand/chunk/1/time_s" });
  });

  test("a session replaces its controller", async (t) => {
    const session = await testClient((await serve(t)).url).session(CONTROLLER);
    const before = (await session.step(AT_REST)).joint_velocity;
    await session.replace({ ...CONTROLLER, limits: "velocity", tasks: [...CONTROLLER.tasks].reverse() });
    const answer = await session.step(AT_REST);
    assert.equal(answer.tasks[0]!.name, CONTROLLER.tasks.at(-1)!.name);
    answer.joint_velocity.forEach((velocity, joint) => assert.ok(Math.abs(velocity - before[joint]!) < 0.02));
    await assert.rejects(session.replace({ ...CONTROLLER, period_s: 0.5 }), { pointer: "/period_s" });
  });

  test("a measurement can have targets", async (t) => {
    const session = await testClient((await serve(t)).url).session(CONTROLLER);
    const first = await session.step({ ...AT_REST, targets: { push: { force: [10] } } });
    assert.equal(first.tasks[0]!.target_state, "following");
    assert.deepEqual(first.tasks[0]!.target_force, [10]);
    const second = await session.step(AT_REST);
    assert.equal(second.tasks[0]!.target_state, "extrapolating");
    const wrong = session.step({ ...AT_REST, targets: { push: { velocity: [1] } } });
    await assert.rejects(wrong, { pointer: "/targets/push/velocity" });
  });

  test("a closed loop equals the built-in simulation", async (t) => {
    const client = testClient((await serve(t)).url);
    const scenario: Scenario = { ...(await client.scenario("stiff_wall")), duration_s: 0.45 };
    const [wall] = scenario.contacts!;
    const { robot, period_s } = scenario.controller;
    const { joints } = await client.robot(robot);
    const start = toolX(joints, scenario.start_joint_position);
    const stream = await (await client.session(scenario.controller)).stream();
    let q = scenario.start_joint_position;
    let qdot = q.map(() => 0);
    const forces: number[] = [];
    for (let period = 0; period < 450; period++) {
      const force = Math.max(wall!.stiffness * (toolX(joints, q) - start - wall!.offset_m!), 0);
      const wrench = { force: [force, 0, 0], torque: [0, 0, 0] };
      forces.push(force);
      qdot = (await stream.step({ joint_position: q, joint_velocity: qdot, wrench })).joint_velocity;
      q = q.map((position, joint) => position + period_s * qdot[joint]!);
    }
    stream.close();
    const simulation = await client.simulate({ scenario });
    await simulation.result();
    const { samples } = (await simulation.trace()) as { samples: { force: number[]; joint_velocity: number[] }[] };
    assert.ok(Math.max(...forces) > 100);
    forces.forEach((force, period) => assert.ok(Math.abs(force - samples[period]!.force[0]!) < 1e-6));
    qdot.forEach((velocity, joint) => assert.ok(Math.abs(velocity - samples[449]!.joint_velocity[joint]!) < 1e-9));
  });

  test("a state is sent again with its number if the answer is lost", async (t) => {
    const proxy = await startFaultyProxy(t, (await serve(t)).url);
    const session = await testClient(proxy.url).session(CONTROLLER);
    await session.step(AT_REST);
    proxy.dropNextAnswer();
    assert.equal((await session.step(AT_REST)).sequence, 1);
    const { steps, retries } = await session.status();
    assert.deepEqual([steps, retries], [2, 1]);
  });

  test("a step goes on after the largest number of the states", async (t) => {
    const client = testClient((await serve(t)).url);
    const stream = await (await client.session(CONTROLLER)).stream();
    for (const controller of [await client.session(CONTROLLER), stream, client.stateless(CONTROLLER)]) {
      await controller.stepState({ ...AT_REST, time_s: 0, sequence: 100 });
      assert.equal((await controller.step(AT_REST)).sequence, 101);
    }
    stream.close();
  });

  test("a session whose end was answered in vain is closed", async (t) => {
    const proxy = await startFaultyProxy(t, (await serve(t)).url);
    const session = await testClient(proxy.url).session(CONTROLLER);
    proxy.dropNextAnswer();
    await session.close();
    await assert.rejects(session.status(), { status: 404 });
    await assert.rejects(session.close({ signal: AbortSignal.abort(new Error("aborted by the test")) }), /aborted by the test/);
  });

  test("a refused state and a late answer do not end a stream", async (t) => {
    const proxy = await startFaultyProxy(t, (await serve(t)).url);
    const stream = await (await testClient(proxy.url).session(CONTROLLER)).stream();
    await assert.rejects(stream.step({ joint_position: [1] }), { status: 422, pointer: "/joint_position" });
    proxy.stall();
    await assert.rejects(stream.step(AT_REST, { timeoutMs: 50 }), LateAnswerError);
    proxy.resume();
    assert.equal((await stream.step(AT_REST)).sequence, 2);
    const abort = AbortSignal.abort(new Error("aborted by the test"));
    await assert.rejects(stream.step(AT_REST, { signal: abort }), /aborted by the test/);
    stream.close();
  });

  test("the time limit and the signal of a stream are those of its opening", async (t) => {
    const proxy = await startFaultyProxy(t, (await serve(t)).url);
    const session = await testClient(proxy.url).session(CONTROLLER);
    const opening = new AbortController();
    const stream = await session.stream({ signal: opening.signal, timeoutMs: 2000 });
    opening.abort();
    assert.equal((await stream.step(AT_REST)).sequence, 0);
    stream.close();
    proxy.stall();
    await assert.rejects(session.stream({ timeoutMs: 50 }), LateAnswerError);
    const slow = new AbortController();
    globalThis.setTimeout(() => slow.abort(new Error("aborted by the test")), 50);
    await assert.rejects(session.stream({ signal: slow.signal }), /aborted by the test/);
    proxy.resume();
  });

  test("a stream needs a WebSocket and a session", async (t) => {
    const { url } = await serve(t);
    const session = await testClient(url).session(CONTROLLER);
    await session.close();
    await assert.rejects(session.stream(), NoAnswerError);
    if (globalThis.WebSocket === undefined) {
      await assert.rejects((await new Client(url).session(CONTROLLER)).stream(), /webSocket/);
    }
  });
});

suite("drive", () => {
  class Arm {
    commands: number[][] = [[0, 0, 0, 0, 0, 0, 0]];
    times = [performance.now()];
    eventIndex: number | undefined;

    constructor(private readonly onFirstMotion: () => void) {}

    read() {
      if (this.eventIndex === undefined && this.commands.at(-1)!.some((velocity) => velocity !== 0)) {
        this.eventIndex = this.commands.length;
        this.onFirstMotion();
      }
      return AT_REST;
    }

    write(jointVelocity: number[]) {
      this.commands.push(jointVelocity);
      this.times.push(performance.now());
    }

    /** Returns the index of the fastest command. */
    fastest() {
      const speeds = this.commands.map((velocities) => Math.max(...velocities.map(Math.abs)));
      return speeds.indexOf(Math.max(...speeds));
    }

    /**
     * Asserts that after command `since` no joint speeds up or exceeds its braking limit, and that all end at rest. The
     * default is the fastest command: an answer that was on its way when the connection stalled may still arrive.
     */
    assertBraked(limits: number[], since: number | undefined = this.fastest()) {
      assert.ok(this.eventIndex !== undefined && since !== undefined);
      assert.ok(this.commands.at(-1)!.every((velocity) => velocity === 0));
      for (let k = since + 1; k < this.commands.length; k++) {
        limits.forEach((limit, joint) => {
          const [before, now] = [Math.abs(this.commands[k - 1]![joint]!), Math.abs(this.commands[k]![joint]!)];
          assert.ok(now <= before + 1e-12);
          // Command k was computed after command k - 1 was computed, and before command k was written. It is the ramp one
          // period later.
          assert.ok(before - now <= limit * ((this.times[k]! - this.times[k - 2]!) / 1e3 + SLOW.period_s) + 1e-12);
        });
      }
    }
  }

  const LIMITS = [8, 8, 8, 8, 10, 10, 10];

  test("the arm is at rest when the signal ends the loop", async (t) => {
    const client = testClient((await serve(t)).url);
    const watchdog = Watchdog.of(await client.robot("sawyer_dh"));
    const abort = new AbortController();
    const arm = new Arm(() => abort.abort());
    const report = await drive(await client.session(SLOW), arm, watchdog, abort.signal);
    assert.ok(report.steps > 0 && report.answered <= report.steps && report.steps <= report.periods);
    arm.assertBraked(LIMITS, arm.eventIndex);
  });

  test("an answer that comes after the end is ignored", async () => {
    class Late extends Stepping {
      override async stepState({ sequence }: State): Promise<StepAnswer> {
        const isFirst = sequence === 0;
        await setTimeout(isFirst ? 0 : 25);
        const joint_velocity = LIMITS.map(() => (isFirst ? 0.4 : 0.5));
        return { ...example("answers/step"), joint_velocity, valid_for_ms: 100, stop_time_s: null };
      }
    }
    const abort = new AbortController();
    const arm = new Arm(() => abort.abort());
    await drive(new Late(SLOW.period_s), arm, new Watchdog(LIMITS), abort.signal);
    arm.assertBraked(LIMITS, arm.eventIndex);
  });

  test("the arm comes to rest within its limits when answers stop", async (t) => {
    const proxy = await startFaultyProxy(t, (await serve(t)).url);
    const client = testClient(proxy.url, { stepTimeoutMs: 1000, retries: 0 });
    const arm = new Arm(() => proxy.stall());
    const session = await client.session(SLOW);
    await assert.rejects(drive(session, arm, new Watchdog(LIMITS), new AbortController().signal), LateAnswerError);
    arm.assertBraked(LIMITS);
  });

  test("the arm comes to rest when the service is killed", async (t) => {
    const service = await serve(t);
    const arm = new Arm(service.kill);
    const stream = await (await testClient(service.url).session(SLOW)).stream();
    await assert.rejects(drive(stream, arm, new Watchdog(LIMITS), new AbortController().signal), NoAnswerError);
    arm.assertBraked(LIMITS);
  });

  test("a refused state ends the loop at rest", async (t) => {
    const client = testClient((await serve(t)).url);
    const arm = new Arm(() => (arm.read = () => ({ ...AT_REST, joint_position: [1] })));
    const session = await client.session(SLOW);
    await assert.rejects(drive(session, arm, new Watchdog(LIMITS), new AbortController().signal), ProblemError);
    arm.assertBraked(LIMITS);
  });
});
