// Draws the bodies of the scene on a two-dimensional canvas, far ones first: for computers without a graphics card.

import { simpleColours } from './any_model.js';
import { bodies, vec } from './arm.js';
import { Camera, dot, sub } from './geometry.js';
import { hexOf } from './ghost_curves.js';
import { depthOf, drawHalfSpace, drawSolids, facesCamera } from './overlay.js';
import { drawBodies } from './shading.js';
import { floor, wall } from './surroundings.js';
import { areDrawable, drawParts, placedParts } from './visuals.js';

/**
 * @typedef {import('./types.js').ArmView} ArmView
 * @typedef {import('./scene.js').Contact} Contact
 * @typedef {import('./ghosts.js').Ghost} Ghost
 * @typedef {import('./scene.js').World} World
 * @typedef {import('./theme.js').Palette} Palette
 */

export class CanvasScene {
  constructor() {
    this.camera = new Camera();
    /** Translucent bodies are drawn here first. */
    this.layer = document.createElement('canvas');
  }

  /** Draws floor, arms, walls and obstacles. @type {(context: CanvasRenderingContext2D, camera: Camera, world: World, robot: import('./types.js').Robot | null, colours: Palette, density: number) => void} */
  draw(context, camera, world, robot, colours, density) {
    this.camera = camera;
    backdrop(context, camera, colours);
    floor(context, camera, colours);
    const { arm, visuals } = world;
    if (!arm) return;
    const parts = bodies(arm, world.atLimit);
    const materials = { ...colours.materials, ...simpleColours(world.kinematics?.robot ?? '') };
    shadow(context, camera, parts, colours);
    const walls = world.contacts.filter(({ isWall }) => isWall);
    walls.filter((contact) => isBehind(camera, contact)).forEach((contact) => wall(context, camera, contact, world, colours));
    if (world.room) this.drawObstacles(context, world.room, arm, true, colours, density);
    for (const ghost of world.ghosts) this.drawGhost(context, ghost, colours, density);
    if (world.swung && world.kinematics) {
      const swung = bodies(world.kinematics.armAt(arm, world.swung), []);
      const tint = rgbOf(colours.axes[2]);
      this.translucent(context, 0.42, density, (on) => drawBodies(on, camera, swung, () => tint));
    }
    trail(context, camera, world.history, world.until, world.colour === undefined ? colours.accent : hexOf(colours, world.colour), []);
    if (robot && areDrawable(visuals)) drawParts(context, camera, placedParts(visuals, robot, world.position, world.atLimit, colours));
    else drawBodies(context, camera, parts, ({ material }) => materials[material]);
    walls.filter((contact) => !isBehind(camera, contact)).forEach((contact) => wall(context, camera, contact, world, colours));
    if (world.room) this.drawRoom(context, world.room, arm, colours, density);
  }

  /**
   * Draws another arm transparently.
   * @param {CanvasRenderingContext2D} context
   * @param {Ghost} ghost
   * @param {Palette} colours
   * @param {number} density
   */
  drawGhost(context, { arm, history, until, colour }, colours, density) {
    const hex = hexOf(colours, colour);
    trail(context, this.camera, history, until, hex, [5, 4]);
    if (!arm) return;
    const tint = rgbOf(hex);
    this.translucent(context, 0.42, density, (on) => drawBodies(on, this.camera, bodies(arm, []), () => tint));
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
    const { canvas } = context;
    if (layer.width !== canvas.width || layer.height !== canvas.height) {
      layer.width = canvas.width;
      layer.height = canvas.height;
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

/** @type {(context: CanvasRenderingContext2D, camera: Camera, history: import('./recording.js').Path, until: number | null, colour: string, dash: number[]) => void} */
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
