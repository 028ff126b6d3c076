// Round forms with bevels, of which the arms are made: drums, tubes along a path, balls and boxes, as triangles with normals.

import { add, cross, dot, norm, perpendiculars, scale, sub, unit } from './geometry.js';

/**
 * @typedef {import('./types.js').Vec3} Vec3
 * @typedef {{places: number[], normals: number[]}} Form corners of triangles, and their normals
 * @typedef {[number, number]} Point radius and height of a profile, m
 */

/** Corners of a circle, and of the quarter of a bevel. */
const CORNERS = 40;
const BEVEL_STEPS = 3;

/** Cosine of the angle between two parts of a profile above which their edge is smooth. */
const SMOOTH = 0.8;

/** @type {() => Form} */
export const emptyForm = () => ({ places: [], normals: [] });

/** @type {(form: Form, corners: [Vec3, Vec3][]) => void} each corner: place and normal */
function triangle(form, corners) {
  for (const [place, normal] of corners) {
    form.places.push(...place);
    form.normals.push(...normal);
  }
}

/**
 * Adds the body that a profile makes when it turns about the line from `from` in the direction `axis`.
 * @param {Form} form
 * @param {Vec3} from
 * @param {Vec3} axis unit vector
 * @param {Point[]} points of the profile from the bottom to the top
 */
export function lathe(form, from, axis, points) {
  const profile = points.filter(([r, z], i) => i === 0 || Math.hypot(r - points[i - 1][0], z - points[i - 1][1]) > 1e-9);
  const [u, v] = perpendiculars(axis);
  const flat = profile.slice(1).map(([r, z], i) => {
    const [dr, dz] = [r - profile[i][0], z - profile[i][1]];
    const length = Math.hypot(dr, dz) || 1;
    return /** @type {Point} */ ([dz / length, -dr / length]);
  });
  /** Normal of part `i` at its end next to part `other`. @type {(i: number, other: number) => Point} */
  const normalAt = (i, other) => {
    const [own, next] = [flat[i], flat[other]];
    if (!next || own[0] * next[0] + own[1] * next[1] < SMOOTH) return own;
    const length = Math.hypot(own[0] + next[0], own[1] + next[1]);
    return [(own[0] + next[0]) / length, (own[1] + next[1]) / length];
  };
  const directions = Array.from({ length: CORNERS + 1 }, (_, k) => {
    const angle = (2 * Math.PI * k) / CORNERS;
    return add(scale(u, Math.cos(angle)), scale(v, Math.sin(angle)));
  });
  /** @type {(point: Point, k: number) => Vec3} */
  const place = ([r, z], k) => add(from, add(scale(directions[k], r), scale(axis, z)));
  /** @type {(normal: Point, k: number) => Vec3} */
  const facing = ([r, z], k) => add(scale(directions[k], r), scale(axis, z));
  flat.forEach((_, i) => {
    const [low, high] = [profile[i], profile[i + 1]];
    const [below, above] = [normalAt(i, i - 1), normalAt(i, i + 1)];
    for (let k = 0; k < CORNERS; k += 1) {
      const corner = (/** @type {Point} */ point, /** @type {Point} */ normal, /** @type {number} */ at) =>
        /** @type {[Vec3, Vec3]} */ ([place(point, at), facing(normal, at)]);
      if (low[0] > 1e-6) triangle(form, [corner(low, below, k), corner(low, below, k + 1), corner(high, above, k + 1)]);
      if (high[0] > 1e-6) triangle(form, [corner(low, below, k), corner(high, above, k + 1), corner(high, above, k)]);
    }
  });
}

/** Adds a drum with rounded edges between two points; `top`: radius at its end. @type {(form: Form, a: Vec3, b: Vec3, radius: number, bevel?: number, top?: number) => void} */
export function drum(form, a, b, radius, bevel = 0.15 * radius, top = radius) {
  const length = norm(sub(b, a));
  if (length < 1e-6) return;
  const edge = Math.min(bevel, 0.5 * length, radius, top);
  /** @type {Point[]} */
  const profile = [[0, 0]];
  for (let i = 0; i <= BEVEL_STEPS; i += 1) {
    const angle = (Math.PI / 2) * (i / BEVEL_STEPS);
    profile.push([radius - edge + edge * Math.sin(angle), edge - edge * Math.cos(angle)]);
  }
  for (let i = 0; i <= BEVEL_STEPS; i += 1) {
    const angle = (Math.PI / 2) * (i / BEVEL_STEPS);
    profile.push([top - edge + edge * Math.cos(angle), length - edge + edge * Math.sin(angle)]);
  }
  profile.push([0, length]);
  lathe(form, a, unit(sub(b, a)), profile);
}

/** @type {(form: Form, center: Vec3, radius: number) => void} */
export function ball(form, center, radius) {
  const steps = CORNERS / 2;
  const profile = Array.from({ length: steps + 1 }, (_, i) => {
    const angle = (Math.PI * i) / steps;
    return /** @type {Point} */ ([radius * Math.sin(angle), radius - radius * Math.cos(angle)]);
  });
  lathe(form, sub(center, [0, 0, radius]), [0, 0, 1], profile);
}

/** Adds a tube along a smooth curve through points, with a radius at each. @type {(form: Form, points: Vec3[], radii: number[]) => void} */
export function tube(form, points, radii) {
  const steps = points.length === 2 ? 1 : 6 * (points.length - 1);
  /** @type {{center: Vec3, radius: number}[]} */
  const rings = [];
  for (let i = 0; i <= steps; i += 1) {
    const at = (i / steps) * (points.length - 1);
    const k = Math.min(points.length - 2, Math.floor(at));
    rings.push({ center: curve(points, k, at - k), radius: radii[k] + smooth(at - k) * (radii[k + 1] - radii[k]) });
  }
  let [side] = perpendiculars(unit(sub(rings[1].center, rings[0].center)));
  const frames = rings.map(({ center }, i) => {
    const axis = unit(sub((rings[i + 1] ?? rings[i]).center, (rings[i - 1] ?? rings[i]).center));
    side = unit(sub(side, scale(axis, dot(side, axis))));
    return { center, side, other: cross(axis, side) };
  });
  /** @type {(i: number, k: number) => [Vec3, Vec3]} */
  const corner = (i, k) => {
    const angle = (2 * Math.PI * k) / CORNERS;
    const { center, side: u, other: v } = frames[i];
    const out = add(scale(u, Math.cos(angle)), scale(v, Math.sin(angle)));
    return [add(center, scale(out, rings[i].radius)), out];
  };
  for (let i = 0; i < steps; i += 1) {
    for (let k = 0; k < CORNERS; k += 1) {
      triangle(form, [corner(i, k), corner(i, k + 1), corner(i + 1, k + 1)]);
      triangle(form, [corner(i, k), corner(i + 1, k + 1), corner(i + 1, k)]);
    }
  }
}

/** @type {(s: number) => number} */
const smooth = (s) => s * s * (3 - 2 * s);

/** Returns a point of the curve of Catmull and Rom between two points. @type {(points: Vec3[], k: number, s: number) => Vec3} */
function curve(points, k, s) {
  const [b, c] = [points[k], points[k + 1]];
  const a = points[k - 1] ?? sub(scale(b, 2), c);
  const d = points[k + 2] ?? sub(scale(c, 2), b);
  const part = (/** @type {number} */ i) =>
    b[i] + 0.5 * s * (c[i] - a[i] + s * (2 * a[i] - 5 * b[i] + 4 * c[i] - d[i] + s * (3 * (b[i] - c[i]) + d[i] - a[i])));
  return [part(0), part(1), part(2)];
}

/** Adds a box with flat bevels. @type {(form: Form, center: Vec3, size: Vec3, bevel: number) => void} */
export function block(form, center, size, bevel) {
  const half = size.map((part) => part / 2);
  /** The corner of the box in a direction, on the face across `axis`. @type {(sign: Vec3, axis: number) => Vec3} */
  const corner = (sign, axis) => add(center, /** @type {Vec3} */ (sign.map((s, i) => s * (half[i] - (i === axis ? 0 : bevel)))));
  const polygon = (/** @type {Vec3[]} */ corners) => {
    const middle = scale(corners.reduce(add), 1 / corners.length);
    const across = unit(cross(sub(corners[1], corners[0]), sub(corners[2], corners[0])));
    const isOut = dot(across, sub(middle, center)) > 0;
    const list = isOut ? corners : [...corners].reverse();
    const normal = isOut ? across : scale(across, -1);
    for (let i = 2; i < list.length; i += 1) triangle(form, [[list[0], normal], [list[i - 1], normal], [list[i], normal]]);
  };
  const signs = [-1, 1];
  for (let axis = 0; axis < 3; axis += 1) {
    const [j, k] = [(axis + 1) % 3, (axis + 2) % 3];
    const at = (/** @type {number} */ s, /** @type {number} */ t, /** @type {number} */ u) => {
      const sign = /** @type {Vec3} */ ([0, 0, 0]);
      [sign[axis], sign[j], sign[k]] = [s, t, u];
      return sign;
    };
    for (const s of signs) polygon([[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([t, u]) => corner(at(s, t, u), axis)));
    for (const t of signs) {
      for (const u of signs) polygon([corner(at(-1, t, u), j), corner(at(1, t, u), j), corner(at(1, t, u), k), corner(at(-1, t, u), k)]);
    }
  }
  for (const x of signs) for (const y of signs) for (const z of signs) polygon([0, 1, 2].map((axis) => corner([x, y, z], axis)));
}
