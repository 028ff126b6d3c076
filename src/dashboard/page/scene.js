// Draws the three-dimensional scene: arm, walls, springs, forces and the path of the tool.

import { bodies, vec } from './arm.js';
import { forces, target } from './arrows.js';
import { Framing } from './framing.js';
import { Camera, dot, sub } from './geometry.js';
import { depthOf, drawHalfSpace, drawPairs, drawSolids, facesCamera } from './overlay.js';
import { drawBodies } from './shading.js';
import { floor, spring, wall } from './surroundings.js';
import { palette } from './theme.js';
import { areDrawable, drawVisuals } from './visuals.js';

/**
 * @typedef {import('./types.js').ArmView} ArmView
 * @typedef {import('./types.js').Vec3} Vec3
 * @typedef {import('./history.js').History} History
 * @typedef {import('./theme.js').Palette} Palette
 *
 * @typedef {object} Contact a wall or a spring
 * @property {boolean} isWall true for a wall or a plane, false for a spring
 * @property {boolean} isVirtual whether it is an inequality of the controller
 * @property {boolean} isTouched whether the inequality is active
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
 * @property {number | null} until end of the drawn path, s; null: its latest point
 * @property {Contact[]} contacts
 * @property {Vec3} start initial position of the tool, m
 * @property {Vec3} force on the environment, N
 * @property {(number | null)[]} target force, N
 * @property {Vec3} push force on the tool, N
 * @property {Ghost | null} ghost
 * @property {import('./target.js').Goal | null} goal the target that can be dragged
 * @property {import('./room.js').Room | null} room the overlay of shapes and distances
 * @property {import('./visuals.js').Visuals | null} visuals shapes of the links
 * @property {number[]} position q, rad or m
 */

/** Width of the buttons over the scene, px. */
const PUSH_WIDTH = 100;

/** On narrow screens the buttons are below the scene. */
const isNarrow = matchMedia('(max-width: 760px)');

export class Scene {
  /** @param {HTMLCanvasElement} canvas */
  constructor(canvas) {
    this.canvas = canvas;
    this.camera = new Camera();
    this.layer = document.createElement('canvas');
    this.framing = new Framing(this.camera);
  }

  /**
   * @param {World} world
   * @param {import('./types.js').Robot | null} robot
   * @param {string} subject name of the scenario and the robot, or id of the session
   */
  draw(world, robot, subject) {
    const { canvas, camera } = this;
    const density = Math.min(2, devicePixelRatio || 1);
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    if (width === 0 || height === 0) return;
    if (canvas.width !== Math.round(width * density) || canvas.height !== Math.round(height * density)) {
      canvas.width = Math.round(width * density);
      canvas.height = Math.round(height * density);
    }
    Object.assign(camera, { width, height, covered: isNarrow.matches ? 0 : PUSH_WIDTH });
    this.framing.follow(world, subject);
    camera.update();
    const context = canvas.getContext('2d');
    if (!context) return;
    context.setTransform(density, 0, 0, density, 0, 0);
    const colours = palette();
    backdrop(context, camera, colours);
    floor(context, camera, colours);
    if (!world.arm) return;
    const { arm } = world;
    const { visuals } = world;
    const parts = bodies(arm, world.atLimit);
    shadow(context, camera, parts, colours);
    const wallsBehind = world.contacts.filter((contact) => contact.isWall && isBehind(camera, contact));
    const wallsInFront = world.contacts.filter((contact) => contact.isWall && !isBehind(camera, contact));
    wallsBehind.forEach((contact) => wall(context, camera, contact, world, colours));
    world.contacts.filter(({ isWall }) => !isWall).forEach((contact) => spring(context, camera, contact, world, colours));
    if (world.room) this.drawObstacles(context, world.room, arm, true, colours, density);
    if (world.ghost) this.drawGhost(context, world.ghost, world.until, colours, density);
    trail(context, camera, world.history, world.until, colours.accent, []);
    if (robot && areDrawable(visuals)) drawVisuals(context, camera, visuals, robot, world.position, world.atLimit, colours);
    else drawBodies(context, camera, parts, ({ material }) => colours.materials[material]);
    wallsInFront.forEach((contact) => wall(context, camera, contact, world, colours));
    if (world.room) this.drawRoom(context, world.room, arm, colours, density);
    target(context, camera, world, colours);
    forces(context, camera, world, colours);
  }

  /**
   * Draws the second arm transparently.
   * @param {CanvasRenderingContext2D} context
   * @param {Ghost} ghost
   * @param {number | null} until end of its path, s
   * @param {Palette} colours
   * @param {number} density
   */
  drawGhost(context, ghost, until, colours, density) {
    trail(context, this.camera, ghost.history, until, colours.ghost, [5, 4]);
    const tint = rgbOf(colours.ghost);
    this.translucent(context, 0.42, density, (on) => drawBodies(on, this.camera, bodies(ghost.arm, []), () => tint));
  }

  /**
   * Draws the obstacles behind the arm, or those in front of it.
   * @param {CanvasRenderingContext2D} context
   * @param {import('./room.js').Room} room
   * @param {ArmView} arm
   * @param {boolean} behind
   * @param {Palette} colours
   * @param {number} density
   */
  drawObstacles(context, { obstacles }, arm, behind, colours, density) {
    const { camera } = this;
    const places = [...arm.joints.map(({ origin }) => vec(origin)), vec(arm.tool.position)];
    const depth = places.reduce((sum, place) => sum - dot(sub(place, camera.eye), camera.back) / places.length, 0);
    const planes = obstacles.filter((solid) => solid.kind === 'half_space').filter((plane) => facesCamera(camera, plane) === behind);
    planes.forEach((plane) => drawHalfSpace(context, camera, plane, colours));
    const solids = obstacles.filter((solid) => solid.kind !== 'half_space' && (depthOf(camera, solid) > depth) === behind);
    if (solids.length > 0) this.translucent(context, 0.55, density, (on) => drawSolids(on, camera, solids, colours.room.obstacle));
  }

  /** @type {(context: CanvasRenderingContext2D, room: import('./room.js').Room, arm: ArmView, colours: Palette, density: number) => void} */
  drawRoom(context, room, arm, colours, density) {
    if (room.shapes.length > 0) {
      this.translucent(context, 0.42, density, (on) => drawSolids(on, this.camera, room.shapes, colours.room.shape));
    }
    this.drawObstacles(context, room, arm, false, colours, density);
    drawPairs(context, this.camera, room.pairs, colours);
  }

  /**
   * Draws on a separate canvas first, so that the parts of a translucent thing do not show through each other.
   * @param {CanvasRenderingContext2D} context
   * @param {number} opacity
   * @param {number} density
   * @param {(on: CanvasRenderingContext2D) => void} draw
   */
  translucent(context, opacity, density, draw) {
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
    draw(on);
    context.globalAlpha = opacity;
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

/** @type {(context: CanvasRenderingContext2D, camera: Camera, history: History, until: number | null, colour: string, dash: number[]) => void} */
function trail(context, camera, history, until, colour, dash) {
  const { columns } = history;
  const length = until === null ? history.length : history.indexAt(until) + 1;
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
