// How arms are compared in the scene: ghosts over the arm, a divider between two arms, or two scenes side by side.

import { Camera } from './geometry.js';
import { hexOf } from './ghost_curves.js';
import { element } from './notices.js';

/**
 * @typedef {import('./ghosts.js').Ghost} Ghost
 * @typedef {import('./scene.js').World} World
 * @typedef {import('./theme.js').Palette} Palette
 * @typedef {Camera['free']} Area
 * @typedef {'ghosts' | 'divider' | 'two'} Mode
 *
 * @typedef {object} Pane a part of the picture with one arm
 * @property {Camera} camera
 * @property {World} world
 * @property {number} from its left side, px
 * @property {number} to its right side, px
 */

/** @type {Mode[]} */
const MODES = ['ghosts', 'divider', 'two'];

/** Smallest part of the free scene on each side of the divider, and its step by a key. */
const LEAST = 0.04;
const STEP = 0.02;

/** Distance of the names from the buttons below them, px. */
const ABOVE = 8;

/** The mode that the user chose, the part of the free scene on the left of the divider, and the ghost on the right. @type {{mode: Mode, part: number, other: string}} */
const chosen = { mode: 'ghosts', part: 0.5, other: '' };

/** @param {() => void} onChange */
export function bind(onChange) {
  for (const button of buttons()) {
    button.onclick = () => {
      chosen.mode = /** @type {Mode} */ (button.dataset.compare);
      onChange();
    };
  }
  other().onchange = () => {
    chosen.other = other().value;
    onChange();
  };
  bindDivider(onChange);
}

/** @param {() => void} onChange */
function bindDivider(onChange) {
  const divider = element('divider');
  const move = (/** @type {number} */ part) => {
    chosen.part = Math.max(LEAST, Math.min(1 - LEAST, part));
    onChange();
  };
  divider.onpointerdown = (event) => divider.setPointerCapture(event.pointerId);
  divider.onpointermove = (event) => {
    if (!divider.hasPointerCapture(event.pointerId)) return;
    const { left, width } = element('free').getBoundingClientRect();
    move((event.clientX - left) / width);
  };
  divider.onkeydown = (event) => {
    /** @type {Record<string, number>} */
    const places = {
      ArrowLeft: chosen.part - STEP, ArrowDown: chosen.part - STEP, ArrowRight: chosen.part + STEP, ArrowUp: chosen.part + STEP,
      PageDown: chosen.part - 5 * STEP, PageUp: chosen.part + 5 * STEP, Home: 0, End: 1,
    };
    if (!(event.key in places)) return;
    event.preventDefault();
    move(places[event.key]);
  };
}

/** @type {() => NodeListOf<HTMLButtonElement>} */
const buttons = () => document.querySelectorAll('[data-compare]');

/** @type {() => HTMLSelectElement} */
const other = () => element('compare-other');

/** Returns the mode for what is shown. @type {(world: World) => Mode} */
export const modeOf = ({ arm, ghosts }) => (arm && ghosts.length > 0 ? chosen.mode : 'ghosts');

/** @type {(ghosts: Ghost[]) => Ghost} */
const chosenOf = (ghosts) => ghosts.find(({ id }) => id === chosen.other) ?? ghosts[0];

/** Returns the free part of the first pane, px. @type {(free: Area, mode: Mode) => Area} */
export const firstArea = (free, mode) => (mode === 'two' ? { ...free, width: free.width / 2 } : free);

/** Returns the parts of the picture. @type {(camera: Camera, world: World, free: Area) => Pane[]} `camera`: of the first part; `free`: of the whole picture, px */
export function panes(camera, world, free) {
  const mode = modeOf(world);
  if (mode === 'ghosts') return [{ camera, world, from: 0, to: camera.width }];
  const ghost = chosenOf(world.ghosts);
  const middle = free.left + (mode === 'two' ? 0.5 : chosen.part) * free.width;
  const second = mode === 'two' ? beside(camera, { ...free, left: middle, width: free.width / 2 }) : camera;
  return [
    { camera, world: { ...world, ghosts: [] }, from: 0, to: middle },
    { camera: second, world: worldOf(world, ghost), from: middle, to: camera.width },
  ];
}

/** Returns the same view in another part of the picture. @type {(camera: Camera, free: Area) => Camera} */
function beside(camera, free) {
  const other = Object.assign(new Camera(), camera, { free });
  other.update();
  return other;
}

/** Returns the scene with the arm of a ghost. @type {(world: World, ghost: Ghost) => World} */
function worldOf(world, { name, colour, arm, history, until, position, target }) {
  const { goal, room } = world;
  return {
    ...world, name, colour, arm, history, until, position, atLimit: [], ghosts: [], signs: null, swung: null,
    force: [0, 0, 0], push: [0, 0, 0], target: [null, null, null],
    goal: goal && target ? { ...goal, pose: { ...goal.pose, position: target } } : goal,
    room: room && { ...room, shapes: [], pairs: [] },
  };
}

/** Draws the line between two parts, and the names of their arms. @type {(context: CanvasRenderingContext2D, parts: Pane[], free: Area, ghosts: Ghost[], colours: Palette) => void} */
export function drawNames(context, parts, free, ghosts, colours) {
  if (parts.length < 2) return;
  const x = parts[1].from;
  const bottom = free.top + free.height;
  const line = free.top + element('compare').offsetTop - ABOVE;
  context.strokeStyle = colours.text;
  context.lineWidth = 1.5;
  context.beginPath();
  context.moveTo(x, free.top);
  context.lineTo(x, bottom);
  context.stroke();
  context.font = '600 13px system-ui, sans-serif';
  context.textBaseline = 'bottom';
  context.lineJoin = 'round';
  context.lineWidth = 4;
  context.strokeStyle = colours.scene;
  parts.forEach(({ world: { name } }, i) => {
    context.fillStyle = i === 0 ? colours.accent : hexOf(colours, chosenOf(ghosts).colour);
    context.textAlign = i === 0 ? 'right' : 'left';
    const at = x + (i === 0 ? -10 : 10);
    const room = Math.max(30, i === 0 ? x - free.left - 14 : free.left + free.width - x - 14);
    context.strokeText(name, at, line, room);
    context.fillText(name, at, line, room);
  });
}

/** Draws the targets that recordings have of their own. @type {(context: CanvasRenderingContext2D, camera: Camera, ghosts: Ghost[], colours: Palette) => void} */
export function drawTargets(context, camera, ghosts, colours) {
  for (const { target, colour } of ghosts) {
    if (!target) continue;
    const { x, y } = camera.project(target);
    context.strokeStyle = hexOf(colours, colour);
    context.lineWidth = 1.5;
    for (const radius of [4, 14]) {
      context.beginPath();
      context.arc(x, y, radius, 0, 2 * Math.PI);
      context.stroke();
    }
  }
}

/** Shows the controls where there are arms to compare. @type {(world: World) => void} */
export function show(world) {
  const mode = modeOf(world);
  setHidden('compare', world.ghosts.length === 0);
  setHidden('divider', mode !== 'divider');
  setHidden('compare-other', mode === 'ghosts' || world.ghosts.length < 2);
  for (const button of buttons()) {
    const pressed = String(button.dataset.compare === mode);
    if (button.ariaPressed !== pressed) button.ariaPressed = pressed;
  }
  if (mode === 'ghosts') return;
  showOthers(world.ghosts);
  const divider = element('divider');
  const percent = Math.round(100 * chosen.part);
  if (divider.ariaValueNow === String(percent)) return;
  divider.style.left = `${100 * chosen.part}%`;
  divider.ariaValueNow = String(percent);
}

/** @param {Ghost[]} ghosts */
function showOthers(ghosts) {
  const list = other();
  const text = ghosts.map(({ id, name }) => `${id} ${name}`).join('\n');
  if (list.dataset.shown !== text) list.replaceChildren(...ghosts.map(({ id, name }) => new Option(name, id)));
  list.dataset.shown = text;
  const { id, name } = chosenOf(ghosts);
  if (list.value !== id) list.value = id;
  const label = `Divider between the arm of the run and ${name}`;
  if (element('divider').ariaLabel !== label) element('divider').ariaLabel = label;
}

/** @type {(id: string, isHidden: boolean) => void} */
function setHidden(id, isHidden) {
  const shown = element(id);
  if (shown.hidden !== isHidden) shown.hidden = isHidden;
}

/** Returns the chosen mode, divider and ghost for a link; empty without a choice. */
export function toText() {
  const { mode, part, other: id } = chosen;
  return mode === 'ghosts' ? '' : [mode, part.toFixed(2), ...(id.startsWith('method:') ? [id] : [])].join(',');
}

/** Reads what `toText` wrote; ignores invalid parts. @param {string | null} text */
export function fromText(text) {
  const [mode, part, id = ''] = (text ?? '').slice(0, 200).split(',');
  const known = MODES.find((one) => one === mode);
  if (!known) return;
  chosen.mode = known;
  chosen.other = id;
  if (Number(part) >= LEAST && Number(part) <= 1 - LEAST) chosen.part = Number(part);
}
