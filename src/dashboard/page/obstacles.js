// Obstacles of a controller that the user adds, moves and removes.

import { vec } from './arm.js';
import { add, scale, sub, unit } from './geometry.js';
import { fromVector, rotate } from './rotation.js';
import { middleOf, ofObstacle } from './solids.js';

/**
 * @typedef {import('./run_control.js').RunControl} RunControl
 * @typedef {import('./types.js').RoomObstacle} RoomObstacle
 * @typedef {import('./types.js').Scenario} Scenario
 * @typedef {import('./types.js').Vec3} Vec3
 * @typedef {'sphere' | 'post' | 'box'} Kind
 */

/** Distance from the tool to the middle of a new obstacle, m. */
const AWAY = 0.3;

/** Distance that a controller keeps which states none, m. */
const MIN_DISTANCE = 0.02;

/** Angle about the tool between new obstacles, rad. */
const SPREAD = 0.8;

/** Height and radius of a new post, m, edges of a new box and radius of a new sphere. */
const POST = { height: 0.7, radius: 0.04 };
const BOX = [0.1, 0.3, 0.2];
const SPHERE = 0.08;

/** Adds the obstacles of a setup to a scenario; null: as in the scenario. @type {(scenario: Scenario, obstacles: RoomObstacle[] | null) => void} */
export function setObstacles(scenario, obstacles) {
  const { controller } = scenario;
  if (!obstacles || (obstacles.length === 0 && !controller.collisions)) return;
  controller.collisions = { min_distance_m: MIN_DISTANCE, ...controller.collisions, obstacles: structuredClone(obstacles) };
}

/** Returns the obstacles of the setup, with the one that is being dragged. @type {(runControl: RunControl) => RoomObstacle[]} */
export function obstaclesOf({ setup, scenario, draggedObstacle: dragged }) {
  const list = setup?.obstacles ?? scenario?.controller.collisions?.obstacles ?? [];
  return dragged ? list.map((obstacle) => (obstacle.name === dragged.name ? dragged : obstacle)) : list;
}

/** Returns an obstacle beyond the tool, as seen from the base. @type {(obstacles: RoomObstacle[], kind: Kind, tool: Vec3) => RoomObstacle} */
export function newObstacle(obstacles, kind, tool) {
  let number = 1;
  while (obstacles.some(({ name }) => name === `${kind} ${number}`)) number += 1;
  const name = `${kind} ${number}`;
  const ahead = Math.hypot(tool[0], tool[1]) > 0.01 ? unit([tool[0], tool[1], 0]) : vec([1, 0, 0]);
  // Not at the place of the obstacle before it.
  const side = Math.ceil(obstacles.length / 2) * (obstacles.length % 2 === 0 ? SPREAD : -SPREAD);
  const outwards = rotate(fromVector([0, 0, side]), ahead);
  const [x, y, z] = rounded(add(tool, scale(outwards, AWAY)));
  if (kind === 'sphere') return { name, sphere: { center: [x, y, z], radius: SPHERE } };
  if (kind === 'post') return { name, capsule: { start: [x, y, 0], end: [x, y, POST.height], radius: POST.radius } };
  const half = Math.atan2(outwards[1], outwards[0]) / 2;
  return { name, box: { size: [...BOX], pose: { position: [x, y, z], orientation: { w: Math.cos(half), x: 0, y: 0, z: Math.sin(half) } } } };
}

/** Returns the obstacle with its middle moved. @type {(obstacle: RoomObstacle, shift: Vec3) => RoomObstacle} */
export function shifted(obstacle, shift) {
  const { sphere, capsule, box } = obstacle;
  const moved = (/** @type {number[]} */ point) => [...add(vec(point), shift)];
  if (sphere) return { ...obstacle, sphere: { ...sphere, center: moved(sphere.center ?? [0, 0, 0]) } };
  if (capsule) return { ...obstacle, capsule: { ...capsule, start: moved(capsule.start), end: moved(capsule.end) } };
  return box ? { ...obstacle, box: { ...box, pose: { ...box.pose, position: moved(box.pose.position) } } } : obstacle;
}

/** Returns the middle of an obstacle; null for a half-space. @type {(obstacle: RoomObstacle) => Vec3 | null} */
export function middle(obstacle) {
  const solid = ofObstacle(obstacle);
  return solid && middleOf(solid);
}

/** Returns the obstacle with its middle at a place, to 1 mm. @type {(obstacle: RoomObstacle, place: Vec3) => RoomObstacle} */
export function placed(obstacle, place) {
  const now = middle(obstacle);
  return now ? shifted(obstacle, sub(rounded(place), now)) : obstacle;
}

/** @type {(place: Vec3) => Vec3} */
const rounded = (place) => vec(place.map((value) => Math.round(value * 1000) / 1000));
