// Mouse, touch and keyboard in the scene: orbit, zoom and push.

import { vec } from './arm.js';
import { norm, scale } from './geometry.js';
import { element } from './notices.js';
import { state } from './state.js';

/**
 * @typedef {import('./run_control.js').RunControl} RunControl
 * @typedef {import('./scene.js').Scene} Scene
 * @typedef {import('./types.js').Vec3} Vec3
 */

/** Distance to the tool within which the pointer grabs it, px. */
const GRAB_RADIUS = 34;

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
  const toolSpot = () => (runControl.arm ? camera.project(vec(runControl.arm.tool.position)) : null);
  const isNear = (/** @type {PointerEvent} */ event) => {
    const spot = toolSpot();
    const isActive = state.value.phase === 'running' || state.value.phase === 'paused';
    return isActive && spot !== null && Math.hypot(spot.x - event.offsetX, spot.y - event.offsetY) < GRAB_RADIUS;
  };
  canvas.onpointerdown = (event) => {
    canvas.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, { x: event.offsetX, y: event.offsetY });
    const spot = toolSpot();
    if (spot && fingers.size === 1 && isNear(event)) grab = { x: event.offsetX, y: event.offsetY, scale: spot.scale };
    canvas.classList.add('held');
  };
  canvas.onpointermove = (event) => {
    const before = fingers.get(event.pointerId);
    if (!before) {
      canvas.classList.toggle('grabbable', isNear(event));
      return;
    }
    const now = { x: event.offsetX, y: event.offsetY };
    if (grab) {
      const displacement = camera.unproject(now.x - grab.x, now.y - grab.y, grab.scale);
      runControl.pushWith(limited(scale(displacement, FORCE_PER_METER)));
    } else if (fingers.size === 2) {
      pinch(scene, fingers, event.pointerId, now);
    } else {
      camera.azimuth -= (now.x - before.x) * 0.008;
      camera.elevation += (now.y - before.y) * 0.008;
    }
    fingers.set(event.pointerId, now);
    runControl.onChange();
  };
  const release = (/** @type {PointerEvent} */ event) => {
    fingers.delete(event.pointerId);
    if (grab) runControl.pushWith(null);
    grab = null;
    canvas.classList.remove('held');
  };
  canvas.onpointerup = release;
  canvas.onpointercancel = release;
  canvas.addEventListener('wheel', (event) => {
    event.preventDefault();
    camera.distance *= Math.exp(event.deltaY * 0.0012);
    runControl.onChange();
  }, { passive: false });
  // The service ends a push after one second, so a pointer that does not move must repeat its force.
  setInterval(() => grab && runControl.pushWith(runControl.push), 200);
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
    runControl.onChange();
  });
}

/** Buttons that push the tool while they are pressed. @type {(runControl: RunControl) => void} */
function bindPushButtons(runControl) {
  /** @type {Vec3 | null} */
  let held = null;
  /** @type {HTMLSelectElement} */
  const strength = element('push-force');
  for (const button of /** @type {NodeListOf<HTMLButtonElement>} */ (document.querySelectorAll('[data-push]'))) {
    const direction = vec((button.dataset.push ?? '0 0 0').split(' ').map(Number));
    const press = () => {
      held = scale(direction, Number(strength.value));
      button.classList.add('held');
      runControl.pushWith(held);
    };
    const release = () => {
      if (!held) return;
      held = null;
      button.classList.remove('held');
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
  setInterval(() => held && runControl.pushWith(held), 200);
}
