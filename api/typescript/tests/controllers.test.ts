import assert from "node:assert/strict";
import { suite, test } from "node:test";
import { setTimeout } from "node:timers/promises";
import { Client, drive, LateAnswerError, NoAnswerError, ProblemError, Stepping, Watchdog } from "../src/index.js";
import type { Robot, Scenario, State, StepAnswer } from "../src/index.js";
import { AT_REST, CONTROLLER, example, lineTo, patient, POSTURE, serve, SLOW } from "./service.js";

/** Commands of a loop with a spring of 1000 N per rad of the first joint. */
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

/** Where the tool is in x, m: Denavit-Hartenberg, link by link, from the tool to the base. */
function reach(joints: Robot["joints"], q: number[]): number {
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
  test("session, stateless and stream answer alike to the last bit", async (t) => {
    const client = patient((await serve(t)).url);
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

  test("a closed loop ends where the simulator does", async (t) => {
    const client = patient((await serve(t)).url);
    const scenario: Scenario = { ...(await client.scenario("stiff_wall")), duration_s: 0.45 };
    const [wall] = scenario.contacts!;
    const { robot, period_s } = scenario.controller;
    const { joints } = await client.robot(robot);
    const start = reach(joints, scenario.start_joint_position);
    const stream = await (await client.session(scenario.controller)).stream();
    let q = scenario.start_joint_position;
    let qdot = q.map(() => 0);
    const forces: number[] = [];
    for (let period = 0; period < 450; period++) {
      const force = Math.max(wall!.stiffness * (reach(joints, q) - start - wall!.offset_m!), 0);
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

  test("a lost answer is asked for again under the same number", async (t) => {
    const line = await lineTo(t, (await serve(t)).url);
    const session = await patient(line.url).session(CONTROLLER);
    await session.step(AT_REST);
    line.loseNextAnswer();
    assert.equal((await session.step(AT_REST)).sequence, 1);
    const { steps, retries } = await session.status();
    assert.deepEqual([steps, retries], [2, 1]);
  });

  test("a refused state and a late answer do not end a stream", async (t) => {
    const line = await lineTo(t, (await serve(t)).url);
    const stream = await (await patient(line.url).session(CONTROLLER)).stream();
    await assert.rejects(stream.step({ joint_position: [1] }), { status: 422, pointer: "/joint_position" });
    line.stall();
    await assert.rejects(stream.step(AT_REST, { timeoutMs: 50 }), LateAnswerError);
    line.resume();
    assert.equal((await stream.step(AT_REST)).sequence, 2);
    const abort = AbortSignal.abort(new Error("enough"));
    await assert.rejects(stream.step(AT_REST, { signal: abort }), /enough/);
    stream.close();
  });

  test("a stream needs a WebSocket and a session", async (t) => {
    const { url } = await serve(t);
    const session = await patient(url).session(CONTROLLER);
    await session.close();
    await assert.rejects(session.stream(), NoAnswerError);
    if (globalThis.WebSocket === undefined) {
      await assert.rejects((await new Client(url).session(CONTROLLER)).stream(), /webSocket/);
    }
  });
});

suite("a loop in real time", () => {
  class Arm {
    told: number[][] = [[0, 0, 0, 0, 0, 0, 0]];
    times = [performance.now()];
    happenedAt: number | undefined;

    constructor(private readonly onceItMoves: () => void) {}

    read() {
      if (this.happenedAt === undefined && this.told.at(-1)!.some((velocity) => velocity !== 0)) {
        this.happenedAt = this.told.length;
        this.onceItMoves();
      }
      return AT_REST;
    }

    write(jointVelocity: number[]) {
      this.told.push(jointVelocity);
      this.times.push(performance.now());
    }

    /** The first of the fastest commands. */
    fastest() {
      const speeds = this.told.map((velocities) => Math.max(...velocities.map(Math.abs)));
      return speeds.indexOf(Math.max(...speeds));
    }

    /**
     * From a command on no joint speeds up or brakes harder than its limit, and all end at rest. What was under way when
     * the line broke may be heard yet, so it is the fastest command from which all must brake, but for an order to end.
     */
    assertBraked(limits: number[], since: number | undefined = this.fastest()) {
      assert.ok(this.happenedAt !== undefined && since !== undefined);
      assert.ok(this.told.at(-1)!.every((velocity) => velocity === 0));
      for (let k = since + 1; k < this.told.length; k++) {
        limits.forEach((limit, joint) => {
          const [before, now] = [Math.abs(this.told[k - 1]![joint]!), Math.abs(this.told[k]![joint]!)];
          assert.ok(now <= before + 1e-12);
          // A command was computed after the one before it was heard, and before it was heard itself.
          assert.ok(before - now <= (limit * (this.times[k]! - this.times[k - 2]!)) / 1e3 + 1e-12);
        });
      }
    }
  }

  const LIMITS = [8, 8, 8, 8, 10, 10, 10];

  test("it ends at rest when the signal says so", async (t) => {
    const client = patient((await serve(t)).url);
    const watchdog = Watchdog.of(await client.robot("sawyer_dh"));
    const abort = new AbortController();
    const arm = new Arm(() => abort.abort());
    const report = await drive(await client.session(SLOW), arm, watchdog, abort.signal);
    assert.ok(report.answered > 0 && report.answered <= report.periods);
    arm.assertBraked(LIMITS, arm.happenedAt);
  });

  test("an answer that comes after the end does not count", async () => {
    class Late extends Stepping {
      override async stepState({ sequence }: State): Promise<StepAnswer> {
        const isFirst = sequence === 0;
        await setTimeout(isFirst ? 0 : 25);
        return { ...example("answers/step"), joint_velocity: LIMITS.map(() => (isFirst ? 0.4 : 0.5)), valid_for_ms: 100 };
      }
    }
    const abort = new AbortController();
    const arm = new Arm(() => abort.abort());
    await drive(new Late(SLOW.period_s), arm, new Watchdog(LIMITS), abort.signal);
    arm.assertBraked(LIMITS, arm.happenedAt);
  });

  test("the arm comes to rest within its limits when answers stop", async (t) => {
    const line = await lineTo(t, (await serve(t)).url);
    const client = patient(line.url, { stepTimeoutMs: 1000, retries: 0 });
    const arm = new Arm(() => line.stall());
    const session = await client.session(SLOW);
    await assert.rejects(drive(session, arm, new Watchdog(LIMITS), new AbortController().signal), LateAnswerError);
    arm.assertBraked(LIMITS);
  });

  test("the arm comes to rest when the service dies", async (t) => {
    const service = await serve(t);
    const arm = new Arm(service.kill);
    const stream = await (await patient(service.url).session(SLOW)).stream();
    await assert.rejects(drive(stream, arm, new Watchdog(LIMITS), new AbortController().signal), NoAnswerError);
    arm.assertBraked(LIMITS);
  });

  test("a refused state ends it at rest", async (t) => {
    const client = patient((await serve(t)).url);
    const arm = new Arm(() => (arm.read = () => ({ ...AT_REST, joint_position: [1] })));
    const session = await client.session(SLOW);
    await assert.rejects(drive(session, arm, new Watchdog(LIMITS), new AbortController().signal), ProblemError);
    arm.assertBraked(LIMITS);
  });
});
