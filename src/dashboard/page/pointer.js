// Mouse, touch and keyboard in the scene: orbit, zoom, push the tool, move the target and obstacles.

import { axisOf, vec } from './arm.js';
import { add, norm, scale } from './geometry.js';
import { element } from './notices.js';
import { dropObstacle, moveObstacle, obstacleAt } from './obstacle_drag.js';
import { state } from './state.js';
import { dropTarget, handle, moveTarget } from './target.js';
import { shownArm } from './view.js';

/**
 * @typedef {import('./run_control.js').RunControl} RunControl
 * @typedef {import('./scene.js').Scene} Scene
 * @typedef {import('./types.js').Vec3} Vec3
 */

/** Distance to the tool within which the pointer grabs it, px. */
const GRAB_RADIUS = 34;

/** Distance to the target within which the pointer grabs it, px, and its movement per key, m. */
const GOAL_RADIUS = 14;
const GOAL_STEP = 0.01;

/** Force per displacement of the pointer, N/m, and maximum force, N. */
const FORCE_PER_METER = 200;
const MAX_FORCE = 80;

/**
 * @param {Scene} scene
 * @param {RunControl} runControl
 */
export function bind(scene, runControl) {
  bindPointer(scene, runControl);
  bindKeys(scene, runControl);
  bindPushButtons(runControl);
}

/** @type {(scene: Scene, runControl: RunControl) => void} */
function bindPointer(scene, runControl) {
  const { canvas, camera } = scene;
  /** @type {Map<number, {x: number, y: number}>} */
  const fingers = new Map();
  /** @type {{x: number, y: number, scale: number} | null} where the pointer grabbed the tool */
  let grab = null;
  /** @type {{x: number, y: number, scale: number} | null} where the pointer last moved the target */
  let held = null;
  /** @type {{x: number, y: number, scale: number, obstacle: import('./types.js').RoomObstacle} | null} where the pointer grabbed an obstacle */
  let lifted = null;
  const under = (/** @type {PointerEvent} */ event) => obstacleAt(runControl, camera, event.offsetX, event.offsetY);
  const toolSpot = () => {
    const arm = shownArm(runControl);
    return arm && runControl.cursor === null ? camera.project(vec(arm.tool.position)) : null;
  };
  const goalSpot = () => {
    const goal = runControl.cursor === null ? handle(runControl) : null;
    return goal ? camera.project(vec(goal.pose.position)) : null;
  };
  const isOnGoal = (/** @type {PointerEvent} */ event) => {
    const spot = goalSpot();
    return spot !== null && Math.hypot(spot.x - event.offsetX, spot.y - event.offsetY) < GOAL_RADIUS;
  };
  const isNear = (/** @type {PointerEvent} */ event) => {
    const spot = toolSpot();
    const isActive = state.value.phase === 'running' || state.value.phase === 'paused';
    return isActive && spot !== null && Math.hypot(spot.x - event.offsetX, spot.y - event.offsetY) < GRAB_RADIUS;
  };
  canvas.onpointerdown = (event) => {
    if (event.button !== 0) return;
    canvas.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, { x: event.offsetX, y: event.offsetY });
    const [spot, goal] = [toolSpot(), goalSpot()];
    if (goal && fingers.size === 1 && isOnGoal(event)) held = { x: event.offsetX, y: event.offsetY, scale: goal.scale };
    else if (spot && fingers.size === 1 && isNear(event)) grab = { x: event.offsetX, y: event.offsetY, scale: spot.scale };
    else if (fingers.size === 1) lifted = liftedBy(event, under(event));
    scene.orbit.grab();
    canvas.classList.add('held');
  };
  canvas.onpointermove = (event) => {
    const before = fingers.get(event.pointerId);
    if (!before) {
      canvas.classList.toggle('movable', isOnGoal(event));
      const isTaken = isOnGoal(event) || isNear(event);
      canvas.classList.toggle('grabbable', !isOnGoal(event) && isNear(event));
      canvas.classList.toggle('liftable', !isTaken && under(event) !== null);
      return;
    }
    const now = { x: event.offsetX, y: event.offsetY };
    if (held) {
      const goal = handle(runControl);
      const shift = camera.unproject(now.x - held.x, now.y - held.y, held.scale);
      held = { ...held, x: now.x, y: now.y };
      if (goal) moveTarget(runControl, goal, shift);
    } else if (grab) {
      const displacement = camera.unproject(now.x - grab.x, now.y - grab.y, grab.scale);
      runControl.pushWith(limited(scale(displacement, FORCE_PER_METER)));
    } else if (lifted) {
      moveObstacle(runControl, lifted.obstacle, camera.unproject(now.x - lifted.x, now.y - lifted.y, lifted.scale));
    } else if (fingers.size === 2) {
      pinch(scene, fingers, event.pointerId, now);
      scene.framing.isManual = true;
    } else {
      scene.orbit.move(now.x - before.x, now.y - before.y, event.timeStamp);
    }
    fingers.set(event.pointerId, now);
    runControl.onChange();
  };
  const release = (/** @type {PointerEvent} */ event) => {
    fingers.delete(event.pointerId);
    scene.orbit.release(event.timeStamp);
    if (grab) runControl.pushWith(null);
    grab = null;
    if (held) dropTarget(runControl);
    held = null;
    if (lifted) dropObstacle(runControl);
    lifted = null;
    canvas.classList.remove('held');
  };
  canvas.onpointerup = release;
  canvas.onpointercancel = release;
  canvas.addEventListener('wheel', (event) => {
    event.preventDefault();
    camera.distance *= Math.exp(event.deltaY * 0.0012);
    scene.framing.isManual = true;
    runControl.onChange();
  }, { passive: false });
  // The service ends a push after one second, so a pointer that does not move must repeat its force.
  setInterval(() => grab && runControl.pushWith(runControl.push), 200);
}

/** @type {(event: PointerEvent, found: ReturnType<typeof obstacleAt>) => {x: number, y: number, scale: number, obstacle: import('./types.js').RoomObstacle} | null} */
function liftedBy({ offsetX: x, offsetY: y }, found) {
  return found && { x, y, scale: found.scale, obstacle: found.obstacle };
}

/** @type {(force: Vec3) => Vec3} */
function limited(force) {
  const size = norm(force);
  return size > MAX_FORCE ? scale(force, MAX_FORCE / size) : force;
}

/** @type {(scene: Scene, fingers: Map<number, {x: number, y: number}>, moved: number, now: {x: number, y: number}) => void} */
function pinch({ camera }, fingers, moved, now) {
  const other = [...fingers].find(([finger]) => finger !== moved)?.[1];
  const before = fingers.get(moved);
  if (!other || !before) return;
  const [was, is] = [before, now].map((spot) => Math.max(10, Math.hypot(spot.x - other.x, spot.y - other.y)));
  camera.distance *= was / is;
}

/** @type {(scene: Scene, runControl: RunControl) => void} */
function bindKeys(scene, runControl) {
  const { camera } = scene;
  const zoom = (/** @type {number} */ factor) => {
    camera.distance *= factor;
    scene.framing.isManual = true;
  };
  /** @type {Record<string, () => void>} */
  const acts = {
    ArrowLeft: () => { camera.azimuth -= 0.1; },
    ArrowRight: () => { camera.azimuth += 0.1; },
    ArrowUp: () => { camera.elevation += 0.08; },
    ArrowDown: () => { camera.elevation -= 0.08; },
    '+': () => zoom(0.9),
    '=': () => zoom(0.9),
    '-': () => zoom(1.1),
    0: () => scene.framing.reset(),
  };
  /** Movement of the target on the screen, right, up and towards the viewer. @type {Record<string, [number, number, number]>} */
  const moves = {
    ArrowLeft: [-1, 0, 0], ArrowRight: [1, 0, 0], ArrowUp: [0, 1, 0], ArrowDown: [0, -1, 0], PageUp: [0, 0, -1], PageDown: [0, 0, 1],
  };
  scene.canvas.addEventListener('keydown', (event) => {
    const move = event.shiftKey ? moves[event.key] : undefined;
    if (move) {
      event.preventDefault();
      moveWithKey(scene, runControl, move);
      return;
    }
    const act = acts[event.key];
    if (!act) return;
    event.preventDefault();
    act();
    runControl.onChange();
  });
}

/** Moves the target by one step along the base axes that are nearest to the screen's. @type {(scene: Scene, runControl: RunControl, move: [number, number, number]) => void} */
function moveWithKey({ camera }, runControl, [right, up, back]) {
  const goal = handle(runControl);
  if (!goal || runControl.cursor !== null) return;
  const wanted = add(add(scale(camera.right, right), scale(camera.up, up)), scale(camera.back, back));
  const axis = wanted.reduce((best, part, i) => (Math.abs(part) > Math.abs(wanted[best]) ? i : best), 0);
  moveTarget(runControl, goal, scale(axisOf(axis), GOAL_STEP * Math.sign(wanted[axis])));
  dropTarget(runControl);
}

/** Buttons that push the tool while they are pressed. @type {(runControl: RunControl) => void} */
function bindPushButtons(runControl) {
  /** @type {{button: HTMLButtonElement, force: Vec3} | null} */
  let held = null;
  /** @type {HTMLSelectElement} */
  const strength = element('push-force');
  for (const button of /** @type {NodeListOf<HTMLButtonElement>} */ (document.querySelectorAll('[data-push]'))) {
    const direction = vec((button.dataset.push ?? '0 0 0').split(' ').map(Number));
    const press = () => {
      held = { button, force: scale(direction, Number(strength.value)) };
      button.classList.add('held');
      runControl.pushWith(held.force);
    };
    const release = () => {
      button.classList.remove('held');
      // A button loses the focus when the next one is pressed.
      if (held?.button !== button) return;
      held = null;
      runControl.pushWith(null);
    };
    button.onpointerdown = (event) => {
      button.setPointerCapture(event.pointerId);
      press();
    };
    button.onpointerup = release;
    button.onpointercancel = release;
    button.onblur = release;
    button.onkeydown = (event) => {
      if (event.key !== ' ' && event.key !== 'Enter') return;
      event.preventDefault();
      event.stopPropagation();
      if (!event.repeat) press();
    };
    button.onkeyup = release;
    button.oncontextmenu = (event) => event.preventDefault();
  }
  setInterval(() => held && runControl.pushWith(held.force), 200);
}
