// Distances between the shapes of an arm and its room, for postures whose answers do not reach the page.

import { post } from './transport.js';

/**
 * @typedef {import('./types.js').CollisionReport} CollisionReport
 * @typedef {import('./types.js').Controller} Controller
 *
 * @typedef {{report: CollisionReport, position: number[]}} Measured distances in the posture `position`
 */

/** Minimum interval between two requests, ms. */
const INTERVAL = 150;

export class Clearance {
  /** @param {() => void} onChange called when new distances have arrived */
  constructor(onChange) {
    this.onChange = onChange;
    /** @type {Measured | null} */
    this.measured = null;
    /** What was asked for last, and the room it was asked for. */
    this.asked = '';
    this.room = '';
    this.isBusy = false;
    this.askedAt = -Infinity;
  }

  /** Returns the latest distances of a controller, and asks for those of a posture. @type {(controller: Controller, position: number[]) => Measured | null} */
  of(controller, position) {
    const request = requestOf(controller, position);
    const room = JSON.stringify(request.controller.collisions) + controller.robot;
    if (room !== this.room) Object.assign(this, { room, measured: null });
    const text = JSON.stringify(request);
    if (text !== this.asked) this.ask(request, text);
    return this.measured;
  }

  /** @type {(request: ReturnType<typeof requestOf>, text: string) => void} */
  ask(request, text) {
    const now = performance.now();
    if (this.isBusy) return;
    if (now - this.askedAt < INTERVAL) {
      setTimeout(this.onChange, INTERVAL - (now - this.askedAt));
      return;
    }
    const { room } = this;
    Object.assign(this, { asked: text, askedAt: now, isBusy: true });
    // A controller that the service refuses has no distances. The page shows its refusal when a run is started.
    const answer = post('/v1/step', request).then(({ collisions }) => collisions ?? null, () => null);
    answer.then((report) => {
      if (room === this.room) this.measured = report ? { report, position: request.state.joint_position } : null;
      this.isBusy = false;
      this.onChange();
    });
  }
}

/** Returns a request whose answer has the distances: an arm that rests. @type {(controller: Controller, position: number[]) => any} */
function requestOf({ robot, period_s, collisions }, position) {
  const target_position = { kind: 'constant', value: position };
  const obstacles = (collisions?.obstacles ?? []).filter(({ moves }) => !moves);
  return {
    controller: {
      robot, period_s, collisions: { ...collisions, obstacles }, tasks: [{ name: 'rest', law: { kind: 'posture', gain: 1, target_position } }],
    },
    state: { sequence: 0, time_s: 0, joint_position: position },
  };
}
