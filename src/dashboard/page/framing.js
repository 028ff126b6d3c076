// Keeps the arm, its target and its contacts inside the picture.

import { vec } from './arm.js';
import { endsOf } from './solids.js';
import { add, dot, mix, norm, scale, sub } from './geometry.js';

/**
 * @typedef {import('./geometry.js').Camera} Camera
 * @typedef {import('./scene.js').World} World
 * @typedef {import('./types.js').Vec3} Vec3
 */

/** Part of the picture that the shown points fill, horizontally and vertically; the rest is for texts and buttons. */
const FILL = { x: 0.86, y: 0.74 };

/** Part of the picture that points may reach before the camera moves. */
const LIMIT = 0.97;

/** Angles between the direction of the arm and that of the view, rad: from the side, and rather from the front. */
const SIDE = 2.05;
const FRONT = 0.85;

/** Time in which the camera goes 63 % of its way, s. */
const TIME = 0.16;

/** Time between two drawings if it is not known, s. */
const USUAL = 0.046;

/** Reach of the arm around its joints, as a part of its length. */
const MARGIN = 0.05;

/** Distances from the base within which obstacles, and from the tool within which walls are kept in the picture, as parts of it. */
const REACH = 1.25;
const NEAR_WALL = 0.33;

/** Smallest length of an arm, m. */
const SMALLEST = 0.05;

export class Framing {
  /** @param {Camera} camera */
  constructor(camera) {
    this.camera = camera;
    this.subject = '';
    this.size = '';
    /** Whether the user chose the distance. */
    this.isManual = false;
    /** @type {{target: Vec3, distance: number} | null} */
    this.goal = null;
  }

  /** Returns to the automatic view. */
  reset() {
    this.subject = '';
    this.isManual = false;
  }

  /** Moves the camera if the subject has changed or leaves the picture. @type {(world: World, subject: string, elapsed?: number) => void} `elapsed`: since the last drawing, s */
  follow(world, subject, elapsed = USUAL) {
    const { camera } = this;
    if (!world.arm) return;
    camera.size = Math.max(SMALLEST, world.kinematics?.reach ?? camera.size);
    const points = shownPoints(world, camera.size);
    const size = `${camera.width} ${camera.height} ${Object.values(camera.free)}`;
    const isNew = subject !== this.subject;
    if (isNew) {
      this.isManual = false;
      this.lookFromSide(world);
    }
    camera.update();
    if (isNew || (!this.isManual && (size !== this.size || !this.contains(points)))) this.goal = this.fit(points);
    if (isNew && this.goal) this.move(1);
    Object.assign(this, { subject, size });
    if (this.goal) this.move(1 - Math.exp(-elapsed / TIME));
  }

  /** Looks so that neither the arm nor the wall nor the figure of the target is seen edge-on. @param {World} world */
  lookFromSide({ arm, contacts, moves }) {
    const upright = contacts.find(({ inwards }) => Math.abs(inwards[2]) < 0.7);
    const ahead = upright ? upright.inwards : vec(arm?.tool.position ?? [1, 0, 0]);
    this.camera.azimuth = Math.atan2(ahead[1], ahead[0]) - (moves ? FRONT : SIDE);
    const isTilted = contacts.some(({ inwards }) => Math.abs(inwards[2]) >= 0.7);
    const isFlat = arm?.joints.every(({ axis }) => Math.abs(axis[2]) > 0.99) ?? false;
    this.camera.elevation = isFlat ? 1.05 : isTilted ? 0.68 : 0.32;
  }

  /** @param {number} part of the way to the goal */
  move(part) {
    const { camera, goal } = this;
    if (!goal) return;
    camera.target = mix(camera.target, goal.target, part);
    camera.distance += part * (goal.distance - camera.distance);
    const isThere = norm(sub(camera.target, goal.target)) < 1e-3 && Math.abs(camera.distance - goal.distance) < 2e-3;
    if (isThere || part === 1) this.goal = null;
  }

  /** Returns whether the goal is not reached yet. */
  get isMoving() {
    return this.goal !== null;
  }

  /** @type {(points: Vec3[]) => boolean} */
  contains(points) {
    const { camera } = this;
    return points.every((point) => {
      const { x, y } = camera.project(point);
      const [dx, dy] = [Math.abs(x - camera.middle.x) / camera.free.width, Math.abs(y - camera.middle.y) / camera.free.height];
      return dx < LIMIT / 2 && dy < LIMIT / 2;
    });
  }

  /** Returns the nearest view that contains all points. @type {(points: Vec3[]) => {target: Vec3, distance: number}} */
  fit(points) {
    const { camera } = this;
    const low = vec([0, 1, 2].map((i) => Math.min(...points.map((point) => point[i]))));
    const high = vec([0, 1, 2].map((i) => Math.max(...points.map((point) => point[i]))));
    const target = mix(low, high, 0.5);
    let [near, far] = [0.25 * camera.size, 10 * camera.size];
    for (let i = 0; i < 24; i += 1) {
      const distance = (near + far) / 2;
      const eye = add(target, scale(camera.back, distance));
      const fits = points.every((point) => {
        const fromEye = sub(point, eye);
        const depth = -dot(fromEye, camera.back);
        const [x, y] = [dot(fromEye, camera.right), dot(fromEye, camera.up)].map((part) => (2 * camera.focal * Math.abs(part)) / depth);
        return depth > 0.05 && x < FILL.x * camera.free.width && y < FILL.y * camera.free.height;
      });
      if (fits) far = distance;
      else near = distance;
    }
    return { target, distance: far };
  }
}

/** @type {(world: World, size: number) => Vec3[]} `size`: length of the arm, m */
function shownPoints({ arm, goal, contacts, ghosts, room }, size) {
  const arms = [arm, ...ghosts.map((ghost) => ghost.arm)].flatMap((shown) => (shown ? [...shown.joints.map(({ origin }) => origin), shown.tool.position, ...(shown.chains ?? []).map(({ tip }) => tip)] : []));
  const points = arms.map(vec);
  if (goal) points.push(vec(goal.pose.position));
  const tool = vec(arm?.tool.position ?? [0, 0, 0]);
  for (const { at, inwards } of contacts) {
    const distance = dot(sub(at, tool), inwards);
    if (Math.abs(distance) < NEAR_WALL * size) points.push(add(tool, scale(inwards, distance)));
  }
  points.push(...(room?.obstacles ?? []).flatMap(endsOf).filter((point) => norm(point) < REACH * size));
  /** @type {Vec3[]} */
  const all = [[0, 0, 0]];
  for (const point of points) {
    for (let axis = 0; axis < 3; axis += 1) {
      const shift = scale(vec([Number(axis === 0), Number(axis === 1), Number(axis === 2)]), MARGIN * size);
      all.push(add(point, shift), sub(point, shift));
    }
  }
  return all;
}
