// Draws the three-dimensional scene: arm, walls, springs, forces and the path of the tool.

import { axisOf, bodies, extent, vec } from './arm.js';
import { Camera, perpendiculars, add, dot, mix, norm, scale, sub, unit } from './geometry.js';
import { drawBodies, polygon } from './shading.js';
import { palette } from './theme.js';

/**
 * @typedef {import('./types.js').ArmView} ArmView
 * @typedef {import('./types.js').Vec3} Vec3
 * @typedef {import('./history.js').History} History
 * @typedef {import('./theme.js').Palette} Palette
 *
 * @typedef {object} Contact a wall or a spring
 * @property {boolean} isWall true for a wall, false for a spring
 * @property {Vec3} inwards unit vector into the material
 * @property {Vec3} at a point on its surface, m
 *
 * @typedef {object} Ghost
 * @property {ArmView} arm
 * @property {History} history
 *
 * @typedef {object} World
 * @property {ArmView | null} arm
 * @property {boolean[]} atLimit
 * @property {History} history
 * @property {Contact[]} contacts
 * @property {Vec3} start initial position of the tool, m
 * @property {Vec3} force on the environment, N
 * @property {(number | null)[]} target force, N
 * @property {Vec3} push force on the tool, N
 * @property {Ghost | null} ghost
 */

/** Half the width of a drawn wall, m. */
const WALL_HALF_WIDTH = 0.32;

/** Returns the length of a force arrow, m: linear for small forces, logarithmic for large ones. @type {(newton: number) => number} */
const arrowLength = (newton) => 0.12 * Math.asinh(newton / 10);

export class Scene {
  /** @param {HTMLCanvasElement} canvas */
  constructor(canvas) {
    this.canvas = canvas;
    this.camera = new Camera();
    this.layer = document.createElement('canvas');
    this.fitted = '';
  }

  /**
   * Points the camera at the arm, once for each scenario or session.
   * @param {ArmView} arm
   * @param {Contact[]} contacts
   * @param {string} name of the scenario or id of the session
   */
  fit(arm, contacts, name) {
    if (this.fitted === name) return;
    this.fitted = name;
    const { center, size } = extent(arm);
    const tool = vec(arm.tool.position);
    this.camera.target = mix(center, tool, 0.15);
    this.camera.distance = 2.15 * size;
    // Look from the side, so that neither the arm nor the wall is seen edge-on.
    const upright = contacts.find(({ inwards }) => Math.abs(inwards[2]) < 0.7);
    const ahead = upright ? upright.inwards : tool;
    this.camera.azimuth = Math.atan2(ahead[1], ahead[0]) - 2.05;
    this.camera.elevation = 0.32;
    this.camera.update();
  }

  /** @param {World} world */
  draw(world) {
    const { canvas, camera } = this;
    const density = Math.min(2, devicePixelRatio || 1);
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    if (width === 0 || height === 0) return;
    if (canvas.width !== Math.round(width * density) || canvas.height !== Math.round(height * density)) {
      canvas.width = Math.round(width * density);
      canvas.height = Math.round(height * density);
    }
    Object.assign(camera, { width, height });
    camera.update();
    const context = canvas.getContext('2d');
    if (!context) return;
    context.setTransform(density, 0, 0, density, 0, 0);
    const colours = palette();
    backdrop(context, camera, colours);
    floor(context, camera, colours);
    if (!world.arm) return;
    const { arm } = world;
    const parts = bodies(arm, world.atLimit);
    shadow(context, camera, parts, colours);
    const wallsBehind = world.contacts.filter((contact) => contact.isWall && isBehind(camera, contact));
    const wallsInFront = world.contacts.filter((contact) => contact.isWall && !isBehind(camera, contact));
    wallsBehind.forEach((contact) => wall(context, camera, contact, world, colours));
    world.contacts.filter(({ isWall }) => !isWall).forEach((contact) => spring(context, camera, contact, world, colours));
    if (world.ghost) this.drawGhost(context, world.ghost, colours, density);
    trail(context, camera, world.history, colours.accent, []);
    drawBodies(context, camera, parts, ({ material }) => colours.materials[material]);
    wallsInFront.forEach((contact) => wall(context, camera, contact, world, colours));
    forces(context, camera, world, colours);
  }

  /**
   * Draws the second arm transparently. It is drawn on a separate canvas first, so that its parts do not show through.
   * @param {CanvasRenderingContext2D} context
   * @param {Ghost} ghost
   * @param {Palette} colours
   * @param {number} density
   */
  drawGhost(context, ghost, colours, density) {
    trail(context, this.camera, ghost.history, colours.ghost, [5, 4]);
    const { layer } = this;
    if (layer.width !== this.canvas.width || layer.height !== this.canvas.height) {
      layer.width = this.canvas.width;
      layer.height = this.canvas.height;
    }
    const on = layer.getContext('2d');
    if (!on) return;
    on.setTransform(1, 0, 0, 1, 0, 0);
    on.clearRect(0, 0, layer.width, layer.height);
    on.setTransform(density, 0, 0, density, 0, 0);
    const tint = rgbOf(colours.ghost);
    drawBodies(on, this.camera, bodies(ghost.arm, []), () => tint);
    context.globalAlpha = 0.42;
    context.drawImage(layer, 0, 0, this.camera.width, this.camera.height);
    context.globalAlpha = 1;
  }
}

/** @type {(hex: string) => import('./shading.js').Rgb} */
function rgbOf(hex) {
  const value = Number.parseInt(hex.slice(1), 16);
  return [value >> 16, (value >> 8) & 255, value & 255];
}

/** @type {(camera: Camera, contact: Contact) => boolean} */
function isBehind(camera, contact) {
  return dot(sub(camera.eye, contact.at), contact.inwards) < 0;
}

/** @type {(context: CanvasRenderingContext2D, camera: Camera, colours: Palette) => void} */
function backdrop(context, camera, colours) {
  const fill = context.createLinearGradient(0, 0, 0, camera.height);
  fill.addColorStop(0, colours.scene);
  fill.addColorStop(1, colours.ground);
  context.fillStyle = fill;
  context.fillRect(0, 0, camera.width, camera.height);
}

/** @type {(context: CanvasRenderingContext2D, camera: Camera, colours: Palette) => void} */
function floor(context, camera, colours) {
  const reach = 1.5;
  context.lineWidth = 1;
  for (let i = -6; i <= 6; i += 1) {
    const at = (i * reach) / 6;
    const long = Math.sqrt(reach * reach - at * at);
    context.strokeStyle = colours.dark ? `rgba(150,170,190,${i === 0 ? 0.3 : 0.13})` : `rgba(70,90,110,${i === 0 ? 0.3 : 0.13})`;
    segment(context, camera, [at, -long, 0], [at, long, 0]);
    segment(context, camera, [-long, at, 0], [long, at, 0]);
  }
  context.font = '600 11px system-ui, sans-serif';
  context.textAlign = 'center';
  context.textBaseline = 'middle';
  for (let axis = 0; axis < 3; axis += 1) {
    const tip = scale(axisOf(axis), 0.22);
    context.strokeStyle = colours.axes[axis];
    context.lineWidth = 2;
    segment(context, camera, [0, 0, 0], tip);
    const label = camera.project(scale(tip, 1.18));
    context.fillStyle = colours.axes[axis];
    context.fillText('xyz'[axis], label.x, label.y);
  }
}

/** @type {(context: CanvasRenderingContext2D, camera: Camera, a: Vec3, b: Vec3) => void} */
function segment(context, camera, a, b) {
  const [from, to] = [camera.project(a), camera.project(b)];
  if (from.depth <= 0.05 || to.depth <= 0.05) return;
  context.beginPath();
  context.moveTo(from.x, from.y);
  context.lineTo(to.x, to.y);
  context.stroke();
}

/**
 * Draws the shadow of the arm on the floor, for light from above.
 * @param {CanvasRenderingContext2D} context
 * @param {Camera} camera
 * @param {import('./arm.js').Body[]} parts
 * @param {Palette} colours
 */
function shadow(context, camera, parts, colours) {
  context.strokeStyle = colours.dark ? 'rgba(0,0,0,0.5)' : 'rgba(40,60,80,0.16)';
  context.lineCap = 'round';
  context.lineJoin = 'round';
  context.beginPath();
  let widest = 0;
  for (const part of parts) {
    if (part.kind !== 'rod') continue;
    const [a, b] = [camera.project([part.a[0], part.a[1], 0]), camera.project([part.b[0], part.b[1], 0])];
    context.moveTo(a.x, a.y);
    context.lineTo(b.x, b.y);
    widest = Math.max(widest, 1.6 * part.ra * a.scale);
  }
  context.lineWidth = widest;
  context.stroke();
}

/** @type {(context: CanvasRenderingContext2D, camera: Camera, contact: Contact, world: World, colours: Palette) => void} */
function wall(context, camera, contact, world, colours) {
  const [u, v] = perpendiculars(contact.inwards);
  const center = contact.at;
  /** @type {(s: number, t: number) => Vec3} */
  const place = (s, t) => add(center, add(scale(u, s * WALL_HALF_WIDTH), scale(v, t * WALL_HALF_WIDTH)));
  const corners = [place(-1, -1), place(1, -1), place(1, 1), place(-1, 1)].map((corner) => camera.project(corner));
  const touched = Math.abs(dot(world.force, contact.inwards)) > 0.5;
  const rgb = colours.dark ? '120,170,205' : '70,120,160';
  context.fillStyle = `rgba(${rgb},${touched ? 0.3 : 0.18})`;
  polygon(context, corners);
  context.strokeStyle = `rgba(${rgb},0.32)`;
  context.lineWidth = 1;
  for (let i = -3; i <= 3; i += 1) {
    segment(context, camera, place(i / 4, -1), place(i / 4, 1));
    segment(context, camera, place(-1, i / 4), place(1, i / 4));
  }
  context.strokeStyle = touched ? colours.accent : `rgba(${rgb},0.9)`;
  context.lineWidth = touched ? 2.5 : 1.5;
  context.beginPath();
  corners.forEach(({ x, y }, i) => (i === 0 ? context.moveTo(x, y) : context.lineTo(x, y)));
  context.closePath();
  context.stroke();
}

/** @type {(context: CanvasRenderingContext2D, camera: Camera, contact: Contact, world: World, colours: Palette) => void} */
function spring(context, camera, contact, world, colours) {
  if (!world.arm) return;
  const axis = contact.inwards;
  const tool = vec(world.arm.tool.position);
  const restLength = 0.26;
  const anchor = add(tool, scale(axis, restLength + dot(sub(contact.at, tool), axis)));
  const [side] = perpendiculars(axis);
  const turns = 9;
  context.strokeStyle = colours.muted;
  context.lineWidth = 1.5;
  context.lineJoin = 'round';
  context.beginPath();
  for (let i = 0; i <= 2 * turns + 2; i += 1) {
    const isInner = i > 0 && i < 2 * turns + 2;
    const point = add(mix(tool, anchor, i / (2 * turns + 2)), scale(side, isInner ? (i % 2 ? 0.018 : -0.018) : 0));
    const spot = camera.project(point);
    if (i === 0) context.moveTo(spot.x, spot.y);
    else context.lineTo(spot.x, spot.y);
  }
  context.stroke();
  const [u, v] = perpendiculars(axis);
  const plate = [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([s, t]) =>
    camera.project(add(anchor, add(scale(u, 0.05 * s), scale(v, 0.05 * t)))));
  context.fillStyle = colours.dark ? 'rgba(120,170,205,0.35)' : 'rgba(70,120,160,0.3)';
  polygon(context, plate);
}

/** @type {(context: CanvasRenderingContext2D, camera: Camera, history: History, colour: string, dash: number[]) => void} */
function trail(context, camera, history, colour, dash) {
  const { length, columns } = history;
  if (length < 2) return;
  const step = Math.max(1, Math.floor(length / 400));
  context.strokeStyle = colour;
  context.lineWidth = 2;
  context.lineJoin = 'round';
  context.setLineDash(dash);
  context.beginPath();
  for (let i = 0; i < length; i += step) {
    const spot = camera.project([columns.x[i], columns.y[i], columns.z[i]]);
    if (i === 0) context.moveTo(spot.x, spot.y);
    else context.lineTo(spot.x, spot.y);
  }
  context.stroke();
  context.setLineDash([]);
}

/** @type {(context: CanvasRenderingContext2D, camera: Camera, world: World, colours: Palette) => void} */
function forces(context, camera, world, colours) {
  if (!world.arm) return;
  const tool = vec(world.arm.tool.position);
  const target = /** @type {Vec3} */ (world.target.map((value) => value ?? 0));
  if (norm(target) > 0.1) arrow(context, camera, tool, target, colours.text, true, '');
  if (norm(world.force) > 0.2) {
    arrow(context, camera, tool, world.force, colours.accent, false, `${norm(world.force).toFixed(1)} N`);
  }
  if (norm(world.push) > 0.2) {
    const from = sub(tool, scale(unit(world.push), arrowLength(norm(world.push))));
    arrow(context, camera, from, world.push, colours.axes[2], false, `push ${norm(world.push).toFixed(0)} N`);
  }
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {Camera} camera
 * @param {Vec3} from
 * @param {Vec3} force
 * @param {string} colour
 * @param {boolean} outlined
 * @param {string} label
 */
function arrow(context, camera, from, force, colour, outlined, label) {
  const to = add(from, scale(unit(force), arrowLength(norm(force))));
  const [a, b] = [camera.project(from), camera.project(to)];
  const length = Math.hypot(b.x - a.x, b.y - a.y);
  context.strokeStyle = colour;
  context.fillStyle = colour;
  if (length > 3) {
    const [dx, dy] = [(b.x - a.x) / length, (b.y - a.y) / length];
    const head = Math.min(13, 0.6 * length);
    context.lineWidth = outlined ? 1.5 : 4;
    context.lineCap = 'butt';
    context.setLineDash(outlined ? [4, 3] : []);
    context.beginPath();
    context.moveTo(a.x, a.y);
    context.lineTo(b.x - dx * head, b.y - dy * head);
    context.stroke();
    context.setLineDash([]);
    context.beginPath();
    context.moveTo(b.x, b.y);
    context.lineTo(b.x - dx * head - dy * head * 0.5, b.y - dy * head + dx * head * 0.5);
    context.lineTo(b.x - dx * head + dy * head * 0.5, b.y - dy * head - dx * head * 0.5);
    context.closePath();
    if (outlined) context.stroke();
    else context.fill();
  }
  if (!label) return;
  context.font = '600 13px system-ui, sans-serif';
  context.textAlign = dot(unit(force), camera.right) >= 0 ? 'left' : 'right';
  context.textBaseline = 'bottom';
  context.lineWidth = 4;
  context.lineJoin = 'round';
  context.strokeStyle = haloColour(context) ?? colour;
  const away = context.textAlign === 'left' ? 8 : -8;
  context.strokeText(label, b.x + away, b.y - 4);
  context.fillText(label, b.x + away, b.y - 4);
}

/** @type {(context: CanvasRenderingContext2D) => string | null} colour of the outline that keeps labels readable */
function haloColour(context) {
  return context.canvas.width > 0 ? palette().scene : null;
}
