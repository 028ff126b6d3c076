// Drags obstacles in the scene.

import { add, norm } from './geometry.js';
import { middle, obstaclesOf, placed } from './obstacles.js';
import { isShown } from './room_switch.js';
import { ofObstacle } from './solids.js';

/**
 * @typedef {import('./geometry.js').Camera} Camera
 * @typedef {import('./run_control.js').RunControl} RunControl
 * @typedef {import('./solids.js').Solid} Solid
 * @typedef {import('./types.js').RoomObstacle} RoomObstacle
 * @typedef {import('./types.js').Vec3} Vec3
 */

/** Smallest distance to the middle line of an obstacle within which the pointer grabs it, px. */
const MIN_REACH = 12;

/** Returns the obstacle under the pointer, the nearest one first, and the scale there, px per m. @type {(runControl: RunControl, camera: Camera, x: number, y: number) => {obstacle: RoomObstacle, scale: number} | null} */
export function obstacleAt(runControl, camera, x, y) {
  const controller = runControl.applied?.controller;
  if (runControl.watch || runControl.cursor !== null || !controller || !isShown(controller)) return null;
  const found = obstaclesOf(runControl).flatMap((obstacle) => {
    const [solid, at] = [ofObstacle(obstacle), middle(obstacle)];
    if (!solid || !at || obstacle.moves || !covers(camera, solid, x, y)) return [];
    const { depth, scale: perMeter } = camera.project(at);
    return { obstacle, scale: perMeter, depth };
  });
  return found.sort((one, other) => one.depth - other.depth)[0] ?? null;
}

/** Returns whether a shape is about at a place of the screen. @type {(camera: Camera, solid: Solid, x: number, y: number) => boolean} */
function covers(camera, solid, x, y) {
  if (solid.kind === 'half_space') return false;
  const [a, b] = solid.kind === 'capsule' ? [solid.a, solid.b] : [solid.center, solid.center];
  const radius = solid.kind === 'capsule' ? solid.radius : norm(solid.size) / 3;
  const [from, to] = [camera.project(a), camera.project(b)];
  const [along, away] = [[to.x - from.x, to.y - from.y], [x - from.x, y - from.y]];
  const squared = along[0] ** 2 + along[1] ** 2;
  const part = squared > 0 ? Math.max(0, Math.min(1, (along[0] * away[0] + along[1] * away[1]) / squared)) : 0;
  const reach = Math.max(MIN_REACH, radius * (from.scale + part * (to.scale - from.scale)));
  return Math.hypot(away[0] - part * along[0], away[1] - part * along[1]) < reach;
}

/** Moves an obstacle; the run gets it when it is dropped. @type {(runControl: RunControl, obstacle: RoomObstacle, shift: Vec3) => void} */
export function moveObstacle(runControl, obstacle, shift) {
  const at = middle(obstacle);
  runControl.draggedObstacle = at ? placed(obstacle, add(at, shift)) : obstacle;
  runControl.onChange();
}

/** Ends a movement: the obstacle becomes a part of the setup. @type {(runControl: RunControl) => void} */
export function dropObstacle(runControl) {
  if (!runControl.draggedObstacle) return;
  const obstacles = obstaclesOf(runControl);
  runControl.draggedObstacle = null;
  runControl.change({ obstacles }).then(() => runControl.showSetup(), runControl.onError);
}
