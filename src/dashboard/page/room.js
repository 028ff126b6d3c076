// The overlay of the scene: shapes of the robot, obstacles of the controller, and the distances between them.

import { vec } from './arm.js';
import { Clearance } from './clearance.js';
import { LinkPoses } from './link_poses.js';
import { isShown } from './room_switch.js';
import { obstaclesOf as setupObstacles } from './obstacles.js';
import { movedTo, ofLink, ofObstacle } from './solids.js';
import { add, sub } from './geometry.js';
import { inverse, multiply, rotate } from './rotation.js';
import { shownSample } from './view.js';

/**
 * @typedef {import('./run_control.js').RunControl} RunControl
 * @typedef {import('./types.js').CollisionReport} CollisionReport
 * @typedef {import('./types.js').Controller} Controller
 * @typedef {import('./types.js').Robot} Robot
 * @typedef {import('./types.js').Vec3} Vec3
 * @typedef {import('./solids.js').Solid} Solid
 * @typedef {import('./urdf.js').Placement} Placement
 *
 * @typedef {'clear' | 'near' | 'below'} Level how a distance compares with the one that is kept
 * @typedef {{a: string, b: string, distance: number, points: [Vec3, Vec3], level: Level}} Pair
 *
 * @typedef {object} Room
 * @property {Solid[]} shapes of the links
 * @property {Solid[]} obstacles
 * @property {Pair[]} pairs nearest first
 * @property {string[]} unknown links with shapes whose place is not known
 */

/** A distance below this multiple of the one that is kept, or within this reach of it, m, is near. */
const NEAR_FACTOR = 1.5;
const NEAR_REACH = 0.01;

/** A distance may be this much less than the one that is kept without being below it, m. */
const SLACK = 1e-5;

/** Distance that a controller keeps if it does not state one, m. */
const DEFAULT_DISTANCE = 0.01;

/** Time after which the page asks again for places that the service did not tell, ms. */
const RETRY_AFTER = 5000;

/** Places of the links by robot; null until the service has answered. @type {WeakMap<Robot, LinkPoses | null>} */
const known = new WeakMap();

/** @type {Clearance | null} */
let clearance = null;

/** Returns the controller whose obstacles are shown: that of the session, or of the setup. @type {(runControl: RunControl) => Controller | undefined} */
export function roomController(runControl) {
  const { watch, applied, pastScenario, draggedObstacle } = runControl;
  if (watch) return watch.session.controller;
  if (pastScenario) return pastScenario.controller;
  const controller = applied?.controller;
  if (!draggedObstacle || !controller?.collisions) return controller;
  return { ...controller, collisions: { ...controller.collisions, obstacles: setupObstacles(runControl) } };
}

/** Returns the overlay; null if the switch is off. @type {(runControl: RunControl) => Room | null} */
export function room(runControl) {
  const { robot } = runControl;
  const controller = roomController(runControl);
  if (!robot || !controller || !isShown(controller)) return null;
  const position = postureOf(runControl);
  const poses = posesOf(robot, runControl.onChange);
  const frames = poses?.at(position) ?? new Map();
  const list = robot.shapes?.shape_list ?? [];
  const shapes = list.flatMap((shape) => {
    const frame = frames.get(shape.link);
    return (frame && ofLink(shape, frame)) ?? [];
  });
  return {
    shapes, obstacles: obstaclesOf(runControl, controller), pairs: pairsOf(runControl, controller, poses, position), unknown: poses?.unknown ?? [],
  };
}

/** Returns the posture that the scene shows. @type {(runControl: RunControl) => number[]} */
function postureOf(runControl) {
  return shownSample(runControl)?.joint_position ?? (runControl.watch ? [] : (runControl.applied?.start_joint_position ?? []));
}

/** @type {(robot: Robot, onReady: () => void) => LinkPoses | null} */
function posesOf(robot, onReady) {
  const links = [...new Set((robot.shapes?.shape_list ?? []).map(({ link }) => link))];
  if (!known.has(robot) && links.length > 0) {
    known.set(robot, null);
    LinkPoses.learn(robot, links).then((poses) => {
      known.set(robot, poses);
      onReady();
    }, () => setTimeout(() => known.delete(robot), RETRY_AFTER));
  }
  return known.get(robot) ?? null;
}

/** Returns the obstacles, moving ones where the state says. @type {(runControl: RunControl, controller: Controller) => Solid[]} */
function obstaclesOf(runControl, controller) {
  const places = new Map((shownSample(runControl)?.room?.obstacles ?? []).map(({ name, position }) => [name, vec(position)]));
  return (controller.collisions?.obstacles ?? []).flatMap((obstacle) => {
    const solid = ofObstacle(obstacle);
    if (!solid || !obstacle.moves) return solid ?? [];
    const place = places.get(obstacle.name);
    return place ? [movedTo(solid, place)] : [];
  });
}

/** Returns the nearest pairs: those of an answer, or those that the service computes for the posture. @type {(runControl: RunControl, controller: Controller, poses: LinkPoses | null, position: number[]) => Pair[]} */
function pairsOf(runControl, controller, poses, position) {
  const { collisions } = controller;
  if (!collisions) return [];
  const kept = collisions.min_distance_m ?? DEFAULT_DISTANCE;
  const { room } = shownSample(runControl) ?? {};
  if (room || runControl.watch) return pairs(room?.report ?? null, kept);
  clearance ??= new Clearance(() => runControl.onChange());
  const measured = position.length > 0 ? clearance.of(controller, position) : null;
  const found = pairs(measured?.report ?? null, kept);
  return measured && poses ? carried(found, poses.at(measured.position), poses.at(position)) : found;
}

/** @type {(report: CollisionReport | null, kept: number) => Pair[]} */
function pairs(report, kept) {
  return (report?.pairs ?? []).map(({ a, b, distance_m: distance, points }) => ({
    a, b, distance, points: [vec(points[0]), vec(points[1])], level: levelOf(distance, kept),
  }));
}

/** @type {(distance: number, kept: number) => Level} */
export function levelOf(distance, kept) {
  if (distance < kept - SLACK) return 'below';
  return distance < Math.max(NEAR_FACTOR * kept, kept + NEAR_REACH) ? 'near' : 'clear';
}

/** Moves the points with their links, since the arm has moved since they were computed. @type {(pairs: Pair[], then: Map<string, Placement>, now: Map<string, Placement>) => Pair[]} */
function carried(pairs, then, now) {
  const move = (/** @type {string} */ link, /** @type {Vec3} */ point) => {
    const [before, after] = [then.get(link), now.get(link)];
    if (!before || !after) return point;
    const turn = multiply(after.orientation, inverse(before.orientation));
    return add(after.position, rotate(turn, sub(point, before.position)));
  };
  return pairs.map((pair) => ({ ...pair, points: [move(pair.a, pair.points[0]), move(pair.b, pair.points[1])] }));
}
