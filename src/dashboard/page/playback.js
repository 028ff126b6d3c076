// The posture between two frames of a run. Frames come 20 times a second; the scene shows the motion between them evenly,
// a little later.

/** @typedef {import('./history.js').History} History */

/** Time by which the shown motion is behind the latest frame, s of real time. */
const DELAY = 0.09;

/** Part by which the clock follows the arrival of frames, and the difference above which it jumps, s of real time. */
const FOLLOW = 0.15;
const JUMP = 0.4;

/** Clocks by run: simulated time minus speed × real time, s. @type {WeakMap<History, {offset: number, speed: number, seen: number}>} */
const clocks = new WeakMap();

/** Returns the simulated time to show, s. @type {(history: History, speed: number, now: number) => number} `now`: real time, s */
export function timeToShow(history, speed, now) {
  const offset = history.now - speed * now;
  const clock = clocks.get(history);
  if (!clock || clock.speed !== speed || Math.abs(clock.offset - offset) > JUMP * Math.max(speed, 0.1) + 0.05) {
    clocks.set(history, { offset, speed, seen: history.now });
    return history.now;
  }
  if (clock.seen !== history.now) {
    clock.offset += FOLLOW * (offset - clock.offset);
    clock.seen = history.now;
  }
  return Math.min(history.now, clock.offset + speed * (now - DELAY));
}

/** Returns the joint positions at a time near the end of a run, rad or m; null if they are not known. @type {(history: History, time: number) => number[] | null} */
export function positionAt({ recent }, time) {
  const after = recent.findIndex((sample) => sample.time_s >= time);
  if (after < 0) return recent.at(-1)?.joint_position ?? null;
  const [a, b] = [recent[after - 1], recent[after]];
  if (!a || b.time_s <= a.time_s) return b.joint_position;
  const part = (time - a.time_s) / (b.time_s - a.time_s);
  return a.joint_position.map((value, i) => value + part * (b.joint_position[i] - value));
}
