import assert from "node:assert/strict";
import { existsSync } from "node:fs";
import { readFile } from "node:fs/promises";
import { createServer } from "node:http";
import type { AddressInfo } from "node:net";
import { join } from "node:path";
import { test, type TestContext } from "node:test";
import { chromium } from "playwright-core";
import { CONTROLLER, POSTURE, serve } from "./service.js";

/** Starts a web server with the built client and an empty page; returns its origin. */
async function site(t: TestContext): Promise<string> {
  const server = createServer(async (request, response) => {
    if (request.url === "/") return response.setHeader("content-type", "text/html").end("<!doctype html><title>arm</title>");
    const file = join(import.meta.dirname, "../src", new URL(request.url!, "http://site").pathname);
    if (!file.endsWith(".js") || !existsSync(file)) return response.writeHead(404).end();
    return response.setHeader("content-type", "text/javascript").end(await readFile(file));
  });
  await new Promise<void>((resolve) => server.listen(0, "127.0.0.1", resolve));
  t.after(() => void server.close());
  return `http://127.0.0.1:${(server.address() as AddressInfo).port}`;
}

test("a page of another origin can resolve, step and stream with the fetch and WebSocket of the browser", async (t) => {
  const origin = await site(t);
  const { url } = await serve(t, "--allow-origin", origin);
  const executablePath = ["/usr/bin/chromium-headless-shell", "/usr/bin/chromium", "/usr/bin/chromium-browser"].find(existsSync);
  const browser = await chromium.launch({ ...(executablePath && { executablePath }), args: ["--no-sandbox", "--disable-gpu"] });
  t.after(() => browser.close());
  const page = await browser.newPage();
  await page.goto(origin);
  const work = { url, controller: CONTROLLER, joint_position: POSTURE };
  const answers = await page.evaluate(async ({ url, controller, joint_position }) => {
    const { Client } = await import("/index.js" as string);
    const client = new Client(url, { timeoutMs: 60_000, stepTimeoutMs: 60_000 });
    const { robot } = controller;
    const resolved = await client.resolve({ robot, joint_position, tasks: [{ axes: ["x"], velocity: [0.05] }] });
    const session = await client.session(controller);
    const state = { joint_position, wrench: { force: [0, 0, 0], torque: [0, 0, 0] } };
    const stepped = await session.step(state);
    const stream = await session.stream();
    const streamed = await stream.step(state);
    stream.close();
    await session.close();
    return [resolved, stepped, streamed].map((answer) => answer.joint_velocity as number[]);
  }, work);
  answers.forEach((velocity) => assert.ok(velocity.length === 7 && velocity.some((speed) => speed !== 0)));
});
