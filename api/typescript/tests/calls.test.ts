import assert from "node:assert/strict";
import { createServer } from "node:http";
import type { AddressInfo } from "node:net";
import { suite, test } from "node:test";
import { Client, ForeignAnswerError, LateAnswerError, NoAnswerError, ProblemError, type ResolveRequest } from "../src/index.js";
import { CONTROLLER, example, startFaultyProxy, testClient, POSTURE, serve, tokenFile } from "./service.js";

const PUSH: ResolveRequest = { robot: "sawyer_dh", joint_position: POSTURE, tasks: [{ axes: ["x"], velocity: [0.05] }] };

suite("calls", () => {
  test("the resolved velocity gives the tool the velocity of the task", async (t) => {
    const client = testClient((await serve(t)).url);
    const [answer, { jacobian }] = await Promise.all([
      client.resolve(PUSH),
      client.kinematics({ robot: "sawyer_dh", joint_position: POSTURE }),
    ]);
    const moved = jacobian[0]!.reduce((sum, entry, joint) => sum + entry * answer.joint_velocity[joint]!, 0);
    assert.ok(Math.abs(moved - 0.05) < 1e-12);
  });

  test("a problem names the error, the field and the remedy", async (t) => {
    const client = testClient((await serve(t)).url);
    await assert.rejects(client.resolve({ ...PUSH, joint_position: [0] }), (error: unknown) => {
      assert.ok(error instanceof ProblemError);
      assert.deepEqual([error.status, error.type, error.pointer], [422, "/problems/invalid", "/joint_position"]);
      assert.match(error.message, /1 numbers? for 7 joints.*Change the field/);
      return !error.isSilence;
    });
    const [first, second] = await client.resolveBatch([PUSH, { ...PUSH, robot: "unknown" }]);
    assert.ok("joint_velocity" in first!);
    assert.ok("pointer" in second! && second.pointer === "/items/1/robot");
    await assert.rejects(client.robot("no/such"), { status: 404 });
  });

  test("a payload is identified, and a session is tared", async (t) => {
    const client = testClient((await serve(t)).url);
    const found = await client.payload(example("payload"));
    assert.ok(found.axes_verified && Math.abs(found.payload.mass_kg - 0.5) < 0.05);
    const session = await client.session(CONTROLLER);
    const reading = { joint_position: POSTURE, wrench: { force: [3, 0, -1], torque: [0, 0.1, 0] } };
    assert.ok((await session.tare({ readings: Array(20).fill(reading) })).force_noise_n < 1e-9);
    const answer = await session.step(reading);
    assert.ok(answer.wrench!.force.every((force) => Math.abs(force) < 1e-9));
    await session.close();
  });

  test("a number that is not finite is refused and not sent as null", async () => {
    await assert.rejects(new Client("http://127.0.0.1:9").resolve({ ...PUSH, period_s: NaN }), /period_s: every number/);
  });

  test("robots, scenarios, stability margins and simulations", async (t) => {
    const client = testClient((await serve(t)).url);
    const names = (await client.robots()).map((robot) => robot.name);
    assert.ok(names.includes((await client.robot("sawyer")).name));
    assert.equal((await client.scenario("stiff_wall")).name, "stiff_wall");
    assert.ok((await client.scenarios()).length > 3);
    const environment = { stiffness: 1e5 };
    const margin = await client.stability({ inertia: 15, damping: 150, environment, period_s: 0.001, lag_s: 0.005 });
    assert.equal(margin.stable, false);
    const run = await client.simulate(example("simulation_own"));
    assert.equal((await run.result()).state, "finished");
    await run.cancel();
    await assert.rejects(run.status(), { status: 404 });
    const live = await client.simulate({ scenario: "stiff_wall", interactive: { paused: true } });
    while ((await live.status()).state === "queued");
    await live.control({ step: 3 });
    while ((await live.status()).progress < 3 / 5000);
    assert.equal((await client.step(await live.cycle())).solver.status, "optimal");
    await live.control({ end: true });
    assert.equal((await live.result()).state, "finished");
    assert.ok(Array.isArray(await client.sessions()));
    const { urdf, tip } = example("robot");
    assert.equal((await client.registerRobot({ name: "mine", urdf, tip })).name, "mine");
    await client.deleteRobot("mine");
    await assert.rejects(client.robot("mine"), { status: 404 });
  });

  test("the error of an unreachable service contains its address", async () => {
    const client = new Client("http://127.0.0.1:9");
    await assert.rejects(client.robots(), (error: unknown) => error instanceof NoAnswerError && /127.0.0.1:9/.test(error.message));
  });

  test("a service with a token refuses clients without it", async (t) => {
    const token = "s".repeat(32);
    const { url } = await serve(t, "--token-file", tokenFile(token));
    await assert.rejects(testClient(url).robots(), { status: 401, type: "/problems/unauthorized" });
    await assert.rejects(testClient(url, { token: "t".repeat(32) }).robots(), { status: 401 });
    const client = testClient(url, { token });
    assert.ok((await client.robots()).length > 0);
    const stream = await (await client.session(CONTROLLER)).stream();
    stream.close();
    const bare = new Client(url, { token });
    await assert.rejects((await bare.session(CONTROLLER)).stream(), /webSocket/);
  });

  test("a full service reports when to retry", async (t) => {
    const client = testClient((await serve(t, "--max-sessions", "1")).url, { retries: 0 });
    const session = await client.session(CONTROLLER);
    await assert.rejects(client.session(CONTROLLER), { status: 503, retryAfterS: 1, isSilence: true });
    await session.close();
  });

  test("a request refused because of overload is sent again, unless the pause is too long", async (t) => {
    let refusals = 2;
    let retryAfter = "0";
    const server = createServer((_, response) => {
      const isBusy = refusals-- > 0;
      response.writeHead(isBusy ? 503 : 200, isBusy ? { "retry-after": retryAfter } : {});
      response.end(isBusy ? '{"type": "/problems/overloaded", "title": "t", "status": 503, "detail": "d"}' : '{"robots": []}');
    });
    await new Promise<void>((resolve) => server.listen(0, "127.0.0.1", resolve));
    t.after(() => (server.closeAllConnections(), server.close()));
    const client = new Client(`http://127.0.0.1:${(server.address() as AddressInfo).port}`, { retries: 2 });
    assert.deepEqual(await client.robots(), []);
    refusals = 3;
    await assert.rejects(client.robots(), { status: 503 });
    refusals = 1;
    retryAfter = "3600";
    await assert.rejects(client.robots(), { status: 503, retryAfterS: 3600 });
    assert.equal(refusals, 0);
  });

  test("the answer of another server is rejected", async (t) => {
    const server = createServer((_, response) => response.end("<html>"));
    await new Promise<void>((resolve) => server.listen(0, "127.0.0.1", resolve));
    t.after(() => (server.closeAllConnections(), server.close()));
    const client = new Client(`http://127.0.0.1:${(server.address() as AddressInfo).port}`);
    await assert.rejects(client.robots(), ForeignAnswerError);
  });

  test("a signal aborts a call with its reason, and a timeout with LateAnswerError", async (t) => {
    const proxy = await startFaultyProxy(t, (await serve(t)).url);
    proxy.stall();
    const client = new Client(proxy.url);
    const abort = new AbortController();
    const call = client.robots({ signal: abort.signal });
    abort.abort(new Error("aborted by the test"));
    await assert.rejects(call, /aborted by the test/);
    await assert.rejects(client.robots({ signal: abort.signal }), /aborted by the test/);
    await assert.rejects(client.robots({ timeoutMs: 50 }), LateAnswerError);
  });
});
