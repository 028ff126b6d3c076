// Mouse, touch and keys in the scene: orbit, zoom, push.

import { vec } from './arm.js';
import { norm, scale } from './geometry.js';
import { element } from './notices.js';
import { state } from './state.js';

/**
 * @typedef {import('./desk.js').Desk} Desk
 * @typedef {import('./scene.js').Scene} Scene
 * @typedef {import('./types.js').Vec3} Vec3
 */

/** Near enough to the tool to take hold of it, px. */
const REACH = 34;

/** Force per way of the pointer, N/m, and the largest one, N. */
const PULL = 200;
const STRONGEST = 80;

/**
 * @param {Scene} scene
 * @param {Desk} desk
 */
export function bind(scene, desk) {
  orbit(scene, desk);
  keys(scene, desk);
  pad(desk);
}

/** @type {(scene: Scene, desk: Desk) => void} */
function orbit(scene, desk) {
  const { canvas, camera } = scene;
  /** @type {Map<number, {x: number, y: number}>} */
  const fingers = new Map();
  /** @type {{x: number, y: number, scale: number} | null} where the tool was taken hold of */
  let hold = null;
  const toolSpot = () => (desk.arm ? camera.project(vec(desk.arm.tool.position)) : null);
  const isNear = (/** @type {PointerEvent} */ event) => {
    const spot = toolSpot();
    const pushes = state.value.phase === 'running' || state.value.phase === 'paused';
    return pushes && spot !== null && Math.hypot(spot.x - event.offsetX, spot.y - event.offsetY) < REACH;
  };
  canvas.onpointerdown = (event) => {
    canvas.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, { x: event.offsetX, y: event.offsetY });
    const spot = toolSpot();
    if (spot && fingers.size === 1 && isNear(event)) hold = { x: event.offsetX, y: event.offsetY, scale: spot.scale };
    canvas.classList.add('held');
  };
  canvas.onpointermove = (event) => {
    const before = fingers.get(event.pointerId);
    if (!before) {
      canvas.classList.toggle('aims', isNear(event));
      return;
    }
    const now = { x: event.offsetX, y: event.offsetY };
    if (hold) {
      desk.pushWith(limited(scale(camera.unproject(now.x - hold.x, now.y - hold.y, hold.scale), PULL)));
    } else if (fingers.size === 2) {
      pinch(scene, fingers, event.pointerId, now);
    } else {
      camera.azimuth -= (now.x - before.x) * 0.008;
      camera.elevation += (now.y - before.y) * 0.008;
    }
    fingers.set(event.pointerId, now);
    desk.onChange();
  };
  const release = (/** @type {PointerEvent} */ event) => {
    fingers.delete(event.pointerId);
    if (hold) desk.pushWith(null);
    hold = null;
    canvas.classList.remove('held');
  };
  canvas.onpointerup = release;
  canvas.onpointercancel = release;
  canvas.addEventListener('wheel', (event) => {
    event.preventDefault();
    camera.distance *= Math.exp(event.deltaY * 0.0012);
    desk.onChange();
  }, { passive: false });
  // A hand that holds still pushes on.
  setInterval(() => hold && desk.pushWith(desk.push), 200);
}

/** @type {(force: Vec3) => Vec3} */
function limited(force) {
  const size = norm(force);
  return size > STRONGEST ? scale(force, STRONGEST / size) : force;
}

/** @type {(scene: Scene, fingers: Map<number, {x: number, y: number}>, moved: number, now: {x: number, y: number}) => void} */
function pinch({ camera }, fingers, moved, now) {
  const other = [...fingers].find(([finger]) => finger !== moved)?.[1];
  const before = fingers.get(moved);
  if (!other || !before) return;
  const [was, is] = [before, now].map((spot) => Math.max(10, Math.hypot(spot.x - other.x, spot.y - other.y)));
  camera.distance *= was / is;
}

/** @type {(scene: Scene, desk: Desk) => void} */
function keys(scene, desk) {
  const { camera } = scene;
  /** @type {Record<string, () => void>} */
  const acts = {
    ArrowLeft: () => { camera.azimuth -= 0.1; },
    ArrowRight: () => { camera.azimuth += 0.1; },
    ArrowUp: () => { camera.elevation += 0.08; },
    ArrowDown: () => { camera.elevation -= 0.08; },
    '+': () => { camera.distance *= 0.9; },
    '=': () => { camera.distance *= 0.9; },
    '-': () => { camera.distance *= 1.1; },
    0: () => { scene.fitted = ''; },
  };
  scene.canvas.addEventListener('keydown', (event) => {
    const act = acts[event.key];
    if (!act) return;
    event.preventDefault();
    act();
    desk.onChange();
  });
}

/** Buttons that push for as long as they are held. @type {(desk: Desk) => void} */
function pad(desk) {
  /** @type {Vec3 | null} */
  let held = null;
  /** @type {HTMLSelectElement} */
  const strength = element('push-force');
  for (const button of /** @type {NodeListOf<HTMLButtonElement>} */ (document.querySelectorAll('[data-push]'))) {
    const direction = vec((button.dataset.push ?? '0 0 0').split(' ').map(Number));
    const press = () => {
      held = scale(direction, Number(strength.value));
      button.classList.add('held');
      desk.pushWith(held);
    };
    const release = () => {
      if (!held) return;
      held = null;
      button.classList.remove('held');
      desk.pushWith(null);
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
  setInterval(() => held && desk.pushWith(held), 200);
}
