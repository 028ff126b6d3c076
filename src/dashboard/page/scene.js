// Draws the three-dimensional scene: arm, walls, springs, forces and the path of the tool.

import { bodies, vec } from './arm.js';
import { forces, target } from './arrows.js';
import { Framing } from './framing.js';
import { Orbit } from './orbit.js';
import { Pace } from './pace.js';
import { solidScene } from './renderer_choice.js';
import { Camera, dot, sub } from './geometry.js';
import { depthOf, drawHalfSpace, drawPairs, drawSolids, facesCamera } from './overlay.js';
import { drawBodies } from './shading.js';
import { drawSigns } from './signs.js';
import { axes, floor, spring, wall } from './surroundings.js';
import { palette } from './theme.js';
import { areDrawable, drawParts, placedParts } from './visuals.js';

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
 * @property {number[]} position q, rad or m
 *
 * @typedef {object} World
 * @property {boolean} [moves] whether the target goes round by itself
 * @property {import('./kinematics.js').Kinematics | null} kinematics of the shown robot
 * @property {ArmView | null} arm
 * @property {import('./signs.js').Signs | null} signs of the tasks
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

/** Smallest width and height of the free part of the scene that the camera uses, px. */
const MIN_FREE = 120;

export class Scene {
  /**
   * @param {HTMLCanvasElement} canvas for everything without WebGL, else for labels and arrows
   * @param {HTMLCanvasElement} solidCanvas for WebGL, behind it
   * @param {HTMLElement} free covers the part that no panel covers
   */
  constructor(canvas, solidCanvas, free) {
    this.canvas = canvas;
    this.solidCanvas = solidCanvas;
    this.free = free;
    this.camera = new Camera();
    this.layer = document.createElement('canvas');
    this.framing = new Framing(this.camera);
    this.orbit = new Orbit(this.camera);
    this.pace = new Pace();
    this.drawnAt = 0;
    /** View of the link that opened the page. @type {ReturnType<typeof import('./shared_state.js').viewOf>} */
    this.viewOfLink = null;
    this.solid = solidScene(solidCanvas, () => this.useCanvas());
    solidCanvas.hidden = !this.solid;
    canvas.dataset.renderer = this.solid ? 'webgl' : 'canvas';
  }

  /** @param {NonNullable<Scene['viewOfLink']>} view */
  showView(view) {
    Object.assign(this.camera, view);
    this.framing.isManual = true;
    this.framing.goal = null;
    this.viewOfLink = null;
  }

  /** Draws on the canvas from now on: the graphics card was lost. */
  useCanvas() {
    this.solid = null;
    this.solidCanvas.hidden = true;
    this.canvas.dataset.renderer = 'canvas';
  }

  /** Paints what is shown, without the parts behind panels, on another canvas. @param {HTMLCanvasElement} canvas */
  paint(canvas) {
    const { free, width } = this.camera;
    const factor = this.canvas.width / Math.max(1, width);
    // Films need an even number of pixels.
    resize(canvas, 2 * Math.floor((free.width * factor) / 2), 2 * Math.floor((free.height * factor) / 2), 1);
    const context = canvas.getContext('2d');
    if (!context) return;
    this.solid?.redraw();
    for (const layer of this.solid ? [this.solidCanvas, this.canvas] : [this.canvas]) {
      const scale = layer.width / Math.max(1, width);
      context.drawImage(layer, free.left * scale, free.top * scale, free.width * scale, free.height * scale, 0, 0, canvas.width, canvas.height);
    }
  }

  /** Returns whether the camera moves by itself. */
  get isMoving() {
    return this.framing.isMoving || this.orbit.isMoving;
  }

  /**
   * @param {World} world
   * @param {import('./types.js').Robot | null} robot
   * @param {string} subject name of the scenario and the robot, or id of the session
   * @param {number} now ms
   */
  draw(world, robot, subject, now) {
    const { canvas, camera, solid } = this;
    const density = Math.min(2, devicePixelRatio || 1);
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    if (width === 0 || height === 0) return;
    resize(canvas, width, height, density);
    Object.assign(camera, { width, height, free: this.freePart() });
    const elapsed = Math.min(0.1, (now - this.drawnAt) / 1000);
    this.drawnAt = now;
    this.orbit.glide(elapsed);
    this.framing.follow(world, subject, elapsed);
    if (world.arm && this.viewOfLink) this.showView(this.viewOfLink);
    camera.update();
    const context = canvas.getContext('2d');
    if (!context) return;
    const colours = palette();
    context.setTransform(density, 0, 0, density, 0, 0);
    if (solid) {
      context.clearRect(0, 0, width, height);
      this.pace.note(now);
      resize(this.solidCanvas, width, height, this.pace.density);
      solid.draw(camera, world, robot, colours);
      axes(context, camera, colours, false);
    } else {
      backdrop(context, camera, colours);
      floor(context, camera, colours);
      if (world.arm) this.drawBodies(context, world, world.arm, robot, colours, density);
    }
    if (world.arm) this.drawSigns(context, world, colours);
  }

  /** Draws arms, walls and obstacles on the canvas. @type {(context: CanvasRenderingContext2D, world: World, arm: ArmView, robot: import('./types.js').Robot | null, colours: Palette, density: number) => void} */
  drawBodies(context, world, arm, robot, colours, density) {
    const { camera } = this;
    const { visuals } = world;
    const parts = bodies(arm, world.atLimit);
    shadow(context, camera, parts, colours);
    const walls = world.contacts.filter(({ isWall }) => isWall);
    walls.filter((contact) => isBehind(camera, contact)).forEach((contact) => wall(context, camera, contact, world, colours));
    if (world.room) this.drawObstacles(context, world.room, arm, true, colours, density);
    if (world.ghost) this.drawGhost(context, world.ghost, world.until, colours, density);
    trail(context, camera, world.history, world.until, colours.accent, []);
    if (robot && areDrawable(visuals)) drawParts(context, camera, placedParts(visuals, robot, world.position, world.atLimit, colours));
    else drawBodies(context, camera, parts, ({ material }) => colours.materials[material]);
    walls.filter((contact) => !isBehind(camera, contact)).forEach((contact) => wall(context, camera, contact, world, colours));
    if (world.room) this.drawRoom(context, world.room, arm, colours, density);
  }

  /** Draws what is not a body: springs, distances, targets and forces. @type {(context: CanvasRenderingContext2D, world: World, colours: Palette) => void} */
  drawSigns(context, world, colours) {
    const { camera } = this;
    world.contacts.filter(({ isWall }) => !isWall).forEach((contact) => spring(context, camera, contact, world, colours));
    if (world.room) drawPairs(context, camera, world.room.pairs, colours);
    if (world.signs) drawSigns(context, camera, world.signs, colours);
    target(context, camera, world, colours);
    forces(context, camera, world, colours);
  }

  /** Returns the part of the canvas that no panel covers, px. */
  freePart() {
    const [all, free] = [this.canvas, this.free].map((part) => part.getBoundingClientRect());
    if (free.width < MIN_FREE || free.height < MIN_FREE) return { left: 0, top: 0, width: all.width, height: all.height };
    return { left: free.left - all.left, top: free.top - all.top, width: free.width, height: free.height };
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

/** @type {(canvas: HTMLCanvasElement, width: number, height: number, density: number) => void} */
function resize(canvas, width, height, density) {
  const [across, down] = [Math.round(width * density), Math.round(height * density)];
  if (canvas.width === across && canvas.height === down) return;
  canvas.width = across;
  canvas.height = down;
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
