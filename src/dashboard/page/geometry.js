// Vectors in the base frame, and the camera of the scene.

/** @typedef {import('./types.js').Vec3} Vec3 */

/** @type {(a: Vec3, b: Vec3) => Vec3} */
export const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
/** @type {(a: Vec3, b: Vec3) => Vec3} */
export const sub = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
/** @type {(a: Vec3, s: number) => Vec3} */
export const scale = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
/** @type {(a: Vec3, b: Vec3) => number} */
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
/** @type {(a: Vec3, b: Vec3) => Vec3} */
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
/** @type {(a: Vec3) => number} */
export const norm = (a) => Math.hypot(a[0], a[1], a[2]);
/** @type {(a: Vec3, b: Vec3, s: number) => Vec3} */
export const mix = (a, b, s) => [a[0] + s * (b[0] - a[0]), a[1] + s * (b[1] - a[1]), a[2] + s * (b[2] - a[2])];

/** @type {(a: Vec3) => Vec3} a unit vector in this direction; z for a zero vector */
export function unit(a) {
  const length = norm(a);
  return length > 1e-9 ? scale(a, 1 / length) : [0, 0, 1];
}

/**
 * Returns two unit vectors that form a right-handed orthonormal basis with the unit vector `axis`.
 * @param {Vec3} axis
 * @returns {[Vec3, Vec3]}
 */
export function perpendiculars(axis) {
  const u = unit(cross(axis, Math.abs(axis[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0]));
  return [u, cross(axis, u)];
}

/**
 * A point on the screen.
 * @typedef {object} Spot
 * @property {number} x px
 * @property {number} y px
 * @property {number} depth distance in the direction of view, m
 * @property {number} scale px per m there
 */

/** Smallest and largest distance of the eye from the target, as parts of the length of the arm. */
const NEAREST = 0.25;
const FARTHEST = 10;

/** A perspective camera that orbits around a target point. */
export class Camera {
  constructor() {
    /** @type {Vec3} */
    this.target = [0.4, 0, 0.4];
    this.azimuth = -0.9;
    this.elevation = 0.35;
    this.distance = 2.6;
    /** Length of the shown arm, m; limits and margins of the view grow with it. */
    this.size = 1.2;
    this.width = 1;
    this.height = 1;
    /** @type {Vec3} from the target to the eye, unit length */
    this.back = [1, 0, 0];
    /** @type {Vec3} */
    this.eye = [0, 0, 0];
    /** @type {Vec3} */
    this.right = [0, 1, 0];
    /** @type {Vec3} */
    this.up = [0, 0, 1];
    this.focal = 1;
    /** The part of the picture that no panel covers, px; its middle shows the target. */
    this.free = { left: 0, top: 0, width: 1, height: 1 };
    this.update();
  }

  /** Limits elevation and distance, and computes the view from them. */
  update() {
    const limit = Math.PI / 2 - 0.02;
    this.elevation = Math.max(-0.2, Math.min(limit, this.elevation));
    this.distance = Math.max(NEAREST * this.size, Math.min(FARTHEST * this.size, this.distance));
    const level = Math.cos(this.elevation);
    this.back = [level * Math.cos(this.azimuth), level * Math.sin(this.azimuth), Math.sin(this.elevation)];
    this.eye = add(this.target, scale(this.back, this.distance));
    this.right = unit(cross(scale(this.back, -1), [0, 0, 1]));
    this.up = cross(this.right, scale(this.back, -1));
    this.focal = 1.55 * Math.min(this.free.height, 1.15 * this.free.width);
  }

  /** Returns the place of the target in the picture, px. */
  get middle() {
    const { left, top, width, height } = this.free;
    return { x: left + width / 2, y: top + height / 2 };
  }

  /**
   * Projects a point to the screen.
   * @param {Vec3} point
   * @returns {Spot}
   */
  project(point) {
    const fromEye = sub(point, this.eye);
    const depth = Math.max(0.02, -dot(fromEye, this.back));
    const perMeter = this.focal / depth;
    return {
      x: this.middle.x + perMeter * dot(fromEye, this.right),
      y: this.middle.y - perMeter * dot(fromEye, this.up),
      depth,
      scale: perMeter,
    };
  }

  /**
   * Converts a displacement on the screen to a displacement in space, parallel to the screen.
   * @param {number} dx px
   * @param {number} dy px
   * @param {number} perMeter px per m
   * @returns {Vec3}
   */
  unproject(dx, dy, perMeter) {
    return add(scale(this.right, dx / perMeter), scale(this.up, -dy / perMeter));
  }
}
