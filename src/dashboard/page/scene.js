// The three-dimensional scene: its camera, the bodies drawn with WebGL or on the canvas, and signs and labels over them.

import { forces, target } from './arrows.js';
import { CanvasScene } from './canvas_scene.js';
import { drawNames, drawTargets, firstArea, modeOf, panes } from './compare.js';
import { Framing } from './framing.js';
import { Camera } from './geometry.js';
import { Orbit } from './orbit.js';
import { drawPairs } from './overlay.js';
import { Pace } from './pace.js';
import { solidScene } from './renderer_choice.js';
import { drawSigns } from './signs.js';
import { axes, spring } from './surroundings.js';
import { palette } from './theme.js';

/**
 * @typedef {import('./types.js').ArmView} ArmView
 * @typedef {import('./types.js').Vec3} Vec3
 * @typedef {import('./theme.js').Palette} Palette
 *
 * @typedef {object} Contact a wall or a spring
 * @property {boolean} isWall true for a wall or a plane, false for a spring
 * @property {boolean} isVirtual whether it is an inequality of the controller
 * @property {boolean} isTouched whether the inequality is active
 * @property {Vec3} inwards unit vector into the material
 * @property {Vec3} at a point on its surface, m
 *
 * @typedef {object} World
 * @property {boolean} [moves] whether the target goes round by itself
 * @property {string} name of the arm: its method
 * @property {number} [colour] of its path, index in `Palette.ghosts`; none: that of the run
 * @property {number[] | null} swung posture of the ghost that swings its elbow
 * @property {import('./kinematics.js').Kinematics | null} kinematics of the shown robot
 * @property {ArmView | null} arm
 * @property {import('./signs.js').Signs | null} signs of the tasks
 * @property {boolean[]} atLimit
 * @property {import('./recording.js').Path} history path of the tool
 * @property {number | null} until end of the drawn path, s; null: its latest point
 * @property {Contact[]} contacts
 * @property {Vec3} start initial position of the tool, m
 * @property {Vec3} force on the environment, N
 * @property {(number | null)[]} target force, N
 * @property {Vec3} push force on the tool, N
 * @property {import('./ghosts.js').Ghost[]} ghosts
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
    /** The part of the picture that no panel covers, px. */
    this.whole = this.camera.free;
    this.flat = new CanvasScene();
    this.framing = new Framing(this.camera);
    this.orbit = new Orbit(this.camera);
    this.pace = new Pace();
    this.drawnAt = 0;
    this.drawings = 0;
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
    const { width } = this.camera;
    const { whole: free } = this;
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
    this.whole = this.freePart();
    Object.assign(camera, { width, height, free: firstArea(this.whole, modeOf(world)) });
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
    const parts = panes(camera, world, this.whole);
    if (solid) {
      context.clearRect(0, 0, width, height);
      this.pace.note(now);
      resize(this.solidCanvas, width, height, this.pace.density);
      solid.draw(parts, robot, colours);
    }
    for (const part of parts) this.drawPart(context, part, robot, colours, density);
    drawNames(context, parts, this.whole, world.ghosts, colours);
    this.drawings += 1;
    canvas.dataset.drawings = String(this.drawings);
  }

  /** Draws signs, and without WebGL the bodies, in one part of the picture. @type {(context: CanvasRenderingContext2D, part: import('./compare.js').Pane, robot: import('./types.js').Robot | null, colours: Palette, density: number) => void} */
  drawPart(context, { camera, world, from, to }, robot, colours, density) {
    context.save();
    context.beginPath();
    context.rect(from, 0, to - from, camera.height);
    context.clip();
    if (this.solid) axes(context, camera, colours, false);
    else this.flat.draw(context, camera, world, robot, colours, density);
    if (world.arm) this.drawSigns(context, camera, world, colours);
    context.restore();
  }

  /** Draws what is not a body: springs, distances, targets and forces. @type {(context: CanvasRenderingContext2D, camera: Camera, world: World, colours: Palette) => void} */
  drawSigns(context, camera, world, colours) {
    world.contacts.filter(({ isWall }) => !isWall).forEach((contact) => spring(context, camera, contact, world, colours));
    if (world.room) drawPairs(context, camera, world.room.pairs, colours);
    if (world.signs) drawSigns(context, camera, world.signs, colours);
    drawTargets(context, camera, world.ghosts, colours);
    target(context, camera, world, colours);
    forces(context, camera, world, colours);
  }

  /** Returns the part of the canvas that no panel covers, px. */
  freePart() {
    const [all, free] = [this.canvas, this.free].map((part) => part.getBoundingClientRect());
    if (free.width < MIN_FREE || free.height < MIN_FREE) return { left: 0, top: 0, width: all.width, height: all.height };
    return { left: free.left - all.left, top: free.top - all.top, width: free.width, height: free.height };
  }

}

/** @type {(canvas: HTMLCanvasElement, width: number, height: number, density: number) => void} */
function resize(canvas, width, height, density) {
  const [across, down] = [Math.round(width * density), Math.round(height * density)];
  if (canvas.width === across && canvas.height === down) return;
  canvas.width = across;
  canvas.height = down;
}
