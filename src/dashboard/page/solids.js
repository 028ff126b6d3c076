// Shapes that keep clear of each other: capsules, spheres, boxes and half-spaces, as the page draws them.

import { vec } from './arm.js';
import { add, mix, scale, sub } from './geometry.js';
import { IDENTITY, rotate } from './rotation.js';

/**
 * @typedef {import('./types.js').Vec3} Vec3
 * @typedef {import('./types.js').Quaternion} Quaternion
 * @typedef {import('./types.js').LinkShape} LinkShape
 * @typedef {import('./types.js').RoomObstacle} RoomObstacle
 * @typedef {import('./urdf.js').Placement} Placement
 *
 * @typedef {{kind: 'capsule', a: Vec3, b: Vec3, radius: number}} Capsule a sphere has both ends at its centre
 * @typedef {{kind: 'box', center: Vec3, size: Vec3, orientation: Quaternion}} Box
 * @typedef {{kind: 'half_space', normal: Vec3, offset: number}} HalfSpace `normal`: unit vector towards the free side
 * @typedef {(Capsule | Box | HalfSpace) & {name: string}} Solid a shape in the base frame, m; `name`: of its link or obstacle
 */

/** Returns a shape of a link in the base frame. @type {(shape: LinkShape, frame: Placement) => Solid | null} */
export function ofLink({ link, capsule, sphere }, { position, orientation }) {
  const place = (/** @type {number[]} */ point) => add(position, rotate(orientation, vec(point)));
  if (capsule) return { kind: 'capsule', name: link, a: place(capsule.start), b: place(capsule.end), radius: capsule.radius };
  if (!sphere) return null;
  const center = place(sphere.center ?? [0, 0, 0]);
  return { kind: 'capsule', name: link, a: center, b: center, radius: sphere.radius };
}

/** Returns an obstacle at the place that the controller states. @type {(obstacle: RoomObstacle) => Solid | null} */
export function ofObstacle({ name, sphere, capsule, box, half_space: plane }) {
  if (sphere) {
    const center = vec(sphere.center ?? [0, 0, 0]);
    return { kind: 'capsule', name, a: center, b: center, radius: sphere.radius };
  }
  if (capsule) return { kind: 'capsule', name, a: vec(capsule.start), b: vec(capsule.end), radius: capsule.radius };
  if (box) {
    const { position, orientation } = box.pose ?? { position: [0, 0, 0], orientation: IDENTITY };
    return { kind: 'box', name, center: vec(position), size: vec(box.size), orientation: orientation ?? IDENTITY };
  }
  if (!plane) return null;
  const length = Math.hypot(...plane.normal);
  return length > 0 ? { kind: 'half_space', name, normal: scale(vec(plane.normal), 1 / length), offset: plane.offset_m } : null;
}

/** Returns the middle of a shape; null for a half-space. @type {(solid: Solid) => Vec3 | null} */
export function middleOf(solid) {
  if (solid.kind === 'capsule') return mix(solid.a, solid.b, 0.5);
  return solid.kind === 'box' ? solid.center : null;
}

/** Returns a shape whose middle is at a place. @type {(solid: Solid, middle: Vec3) => Solid} */
export function movedTo(solid, middle) {
  if (solid.kind === 'box') return { ...solid, center: middle };
  if (solid.kind !== 'capsule') return solid;
  const half = scale(sub(solid.b, solid.a), 0.5);
  return { ...solid, a: sub(middle, half), b: add(middle, half) };
}

/** Returns the points that show where a shape is. @type {(solid: Solid) => Vec3[]} */
export function endsOf(solid) {
  if (solid.kind === 'capsule') return [solid.a, solid.b];
  return solid.kind === 'box' ? [solid.center] : [];
}
