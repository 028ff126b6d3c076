// Turning the camera with the pointer: it goes on turning after a quick movement, and slows down.

/** @typedef {import('./geometry.js').Camera} Camera */

/** Angle per movement of the pointer, rad/px. */
const TURN = 0.008;

/** Time in which the speed falls to 37 %, and smallest speed, s and rad/s. */
const SLOWDOWN = 0.22;
const SLOWEST = 0.02;

/** A pointer that rests this long before its release does not throw the camera, ms. */
const REST = 60;

export class Orbit {
  /** @param {Camera} camera */
  constructor(camera) {
    this.camera = camera;
    /** Speeds of azimuth and elevation, rad/s. */
    this.speed = { azimuth: 0, elevation: 0 };
    this.movedAt = 0;
    this.isHeld = false;
  }

  /** The pointer takes hold of the scene. */
  grab() {
    this.isHeld = true;
    this.speed = { azimuth: 0, elevation: 0 };
  }

  /** @type {(dx: number, dy: number, now: number) => void} movement of the pointer, px, at a time, ms */
  move(dx, dy, now) {
    const elapsed = Math.max(4, now - this.movedAt) / 1000;
    this.movedAt = now;
    const [azimuth, elevation] = [-dx * TURN, dy * TURN];
    this.camera.azimuth += azimuth;
    this.camera.elevation += elevation;
    const mixed = (/** @type {number} */ old, /** @type {number} */ angle) => 0.5 * old + 0.5 * (angle / elapsed);
    this.speed = { azimuth: mixed(this.speed.azimuth, azimuth), elevation: mixed(this.speed.elevation, elevation) };
  }

  /** @param {number} now ms */
  release(now) {
    const isCalm = matchMedia('(prefers-reduced-motion: reduce)').matches;
    if (now - this.movedAt > REST || !this.isHeld || isCalm) this.speed = { azimuth: 0, elevation: 0 };
    this.isHeld = false;
  }

  /** Turns the camera on. @param {number} seconds since the last drawing */
  glide(seconds) {
    if (!this.isMoving) return;
    this.camera.azimuth += this.speed.azimuth * seconds;
    this.camera.elevation += this.speed.elevation * seconds;
    const rest = Math.exp(-seconds / SLOWDOWN);
    this.speed = { azimuth: this.speed.azimuth * rest, elevation: this.speed.elevation * rest };
  }

  /** Returns whether the camera turns by itself. */
  get isMoving() {
    return !this.isHeld && Math.hypot(this.speed.azimuth, this.speed.elevation) > SLOWEST;
  }
}
