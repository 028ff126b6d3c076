/** A running service, and a TCP proxy that simulates a faulty network. */
import { spawn } from "node:child_process";
import { mkdtempSync, readFileSync, writeFileSync } from "node:fs";
import { connect, createServer, type AddressInfo, type Socket } from "node:net";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { createInterface } from "node:readline";
import type { TestContext } from "node:test";
import { WebSocket } from "ws";
import { Client, type ClientOptions, type Controller } from "../src/index.js";

const ROOT = join(import.meta.dirname, "../../../..");
export const POSTURE = [2.9, -0.4, 3.0, 2.1, 3.0, -0.6, 0.2];
export const AT_REST = { joint_position: POSTURE, wrench: { force: [0, 0, 0], torque: [0, 0, 0] } };

export function example(name: string): any {
  return JSON.parse(readFileSync(join(ROOT, "api/examples", `${name}.json`), "utf8"));
}

export const CONTROLLER: Controller = example("controller");
export const SLOW: Controller = { ...CONTROLLER, period_s: 0.01 };

export interface Service {
  url: string;
  kill(): void;
}

/** Starts a service that runs until the end of the test. */
export async function serve(test: TestContext, ...flags: string[]): Promise<Service> {
  const program = process.env["REVPRIO"] ?? join(ROOT, "target/debug/revprio");
  const child = spawn(program, ["serve", "--listen", "127.0.0.1:0", ...flags], { stdio: ["ignore", "pipe", "ignore"] });
  const kill = () => void child.kill("SIGKILL");
  test.after(kill);
  for await (const line of createInterface(child.stdout)) return { url: line.split(" ").at(-1)!, kill };
  throw new Error("the service does not start");
}

/** Writes a token to a file; returns its path. */
export function tokenFile(token: string): string {
  const path = join(mkdtempSync(join(tmpdir(), "revprio-")), "token");
  writeFileSync(path, token, { mode: 0o600 });
  return path;
}

/** Creates a client with long time limits, for slow test machines, and with the WebSocket of `ws`. */
export function testClient(url: string, options: ClientOptions = {}): Client {
  const webSocket: ClientOptions["webSocket"] = (to, protocol, headers) => new WebSocket(to, protocol, { headers });
  return new Client(url, { timeoutMs: 60_000, stepTimeoutMs: 60_000, webSocket, ...options });
}

export interface FaultyProxy {
  url: string;
  /** Holds back all answers. */
  stall(): void;
  resume(): void;
  /** Drops the connection instead of forwarding the next answer. */
  dropNextAnswer(): void;
}

/** Starts a TCP proxy to a service, which runs until the end of the test. */
export async function startFaultyProxy(test: TestContext, url: string): Promise<FaultyProxy> {
  const port = Number(new URL(url).port);
  const serviceSockets = new Set<Socket>();
  let isStalled = false;
  let dropsAnswer = false;
  const server = createServer((client) => {
    const service = connect(port, "127.0.0.1");
    serviceSockets.add(service);
    client.on("data", (data) => service.write(data));
    service.on("data", (data) => {
      if (dropsAnswer) client.destroy();
      else client.write(data);
      dropsAnswer = false;
    });
    if (isStalled) service.pause();
    for (const [from, to] of [[client, service], [service, client]] as const) {
      from.on("error", () => to.destroy());
      from.on("close", () => (serviceSockets.delete(service), to.destroy()));
    }
  });
  await new Promise<void>((resolve) => server.listen(0, "127.0.0.1", resolve));
  test.after(() => (serviceSockets.forEach((socket) => socket.destroy()), server.close()));
  return {
    url: `http://127.0.0.1:${(server.address() as AddressInfo).port}`,
    stall: () => ((isStalled = true), serviceSockets.forEach((socket) => socket.pause())),
    resume: () => ((isStalled = false), serviceSockets.forEach((socket) => socket.resume())),
    dropNextAnswer: () => void (dropsAnswer = true),
  };
}
