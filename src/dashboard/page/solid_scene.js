// The bodies of the scene for the WebGL renderer: arm, ghost, walls, obstacles, shapes of links, and the path of the tool.

import { modelOf } from './any_model.js';
import { axisOf } from './arm.js';
import { hexOf } from './ghost_curves.js';
import { add, dot, perpendiculars, scale, sub } from './geometry.js';
import { along, transform } from './matrices.js';
import { IDENTITY } from './rotation.js';
import { BOX, CYLINDER, SPHERE, flatMesh, grid, ribbon, square } from './solid_meshes.js';
import { AXIS, wallCenter } from './surroundings.js';
import { areDrawable, placedParts } from './visuals.js';
import { Renderer } from './webgl.js';

/**
 * @typedef {import('./types.js').Vec3} Vec3
 * @typedef {import('./types.js').Robot} Robot
 * @typedef {import('./compare.js').Pane} Pane
 * @typedef {import('./geometry.js').Camera} Camera
 * @typedef {import('./kinematics.js').Kinematics} Kinematics
 * @typedef {import('./scene.js').World} World
 * @typedef {import('./scene.js').Contact} Contact
 * @typedef {import('./shading.js').Rgb} Rgb
 * @typedef {import('./solids.js').Solid} Solid
 * @typedef {import('./theme.js').Palette} Palette
 * @typedef {import('./urdf.js').Placement} Placement
 * @typedef {import('./webgl.js').Item} Item
 */

/** Opacity of ghosts, walls and overlays. */
const GHOST = 0.3;
const OVERLAY = 0.42;
const OBSTACLE = 0.6;

/** Force above which a wall is touched, N. */
const TOUCH = 0.5;

/** Half the width of a drawn wall and of a half-space, m. */
const WALL = 0.32;
const HALF_SPACE = 0.7;

/** Width of the path of the tool, px, and the largest number of its points. */
const PATH_WIDTH = 2.2;
const PATH_POINTS = 500;

/** @type {Placement} */
const BASE = { position: [0, 0, 0], orientation: IDENTITY };

export class SolidScene {
  /** @param {WebGL2RenderingContext} gl */
  constructor(gl) {
    this.renderer = new Renderer(gl);
    /** Draws the same again: a browser keeps a picture only until it has shown it. */
    this.redraw = () => {};
  }

 /** Draws the parts of the picture. @type {(parts: Pane[], robot: Robot | null, colours: Palette) => void} */
  draw(parts, robot, colours) {
    this.redraw = () => this.draw(parts, robot, colours);
    for (const part of parts) this.drawPart(part, robot, colours);
  }

  /** @type {(part: Pane, robot: Robot | null, colours: Palette) => void} */
  drawPart({ camera, world, from, to }, robot, colours) {
    const items = [
      ...armItems(world, robot, colours),
      ...world.ghosts.flatMap(({ position, colour }) => ghostItems(world.kinematics, position, linearOf(hexOf(colours, colour)))),
      ...ghostItems(world.kinematics, world.swung ?? [], linearOf(colours.axes[2])),
      ...world.contacts.filter(({ isWall }) => isWall).flatMap((contact) => wallItems(contact, world, colours)),
      ...roomItems(camera, world, colours),
      ...pathItems(camera, world, colours),
      ...axisItems(camera, colours),
    ];
    const reach = camera.size;
    this.renderer.draw(camera, items, colours.look, [0, 0, 0.45 * reach], reach, [from / camera.width, to / camera.width]);
  }
}

/** @type {(rgb: Rgb) => Vec3} linear colour */
const linear = ([r, g, b]) => [(r / 255) ** 2.2, (g / 255) ** 2.2, (b / 255) ** 2.2];

/** @type {(hex: string) => Vec3} linear colour */
const linearOf = (hex) => linear(/** @type {Rgb} */ (shownOf(hex).map((part) => 255 * part)));

/** @type {(hex: string) => Vec3} colour as shown, without light */
function shownOf(hex) {
  const value = Number.parseInt(hex.slice(1), 16);
  return [(value >> 16) / 255, ((value >> 8) & 255) / 255, (value & 255) / 255];
}

/** @type {(world: World, robot: Robot | null, colours: Palette) => Item[]} */
function armItems({ visuals, kinematics, position, atLimit }, robot, colours) {
  if (robot && areDrawable(visuals)) {
    return placedParts(visuals, robot, position, atLimit, colours).map(({ triangles, frame, rgb }) => ({
      mesh: flatMesh(triangles), world: transform(frame), colour: linear(rgb), castsShadow: true,
    }));
  }
  if (!kinematics || position.length === 0) return [];
  const frames = kinematics.frames(position);
  return modelOf(kinematics).map(({ joint, mesh, finish, marks }) => {
    const isLimited = marks && atLimit[joint];
    return {
      mesh, world: transform(frames[joint] ?? BASE), colour: linear(isLimited ? colours.materials.limit : finish.rgb),
      roughness: finish.roughness, metal: isLimited ? 0 : finish.metal, castsShadow: true,
    };
  });
}

/** @type {(kinematics: Kinematics | null, position: number[], colour: Vec3) => Item[]} */
function ghostItems(kinematics, position, colour) {
  if (!kinematics || position.length === 0) return [];
  const frames = kinematics.frames(position);
  return modelOf(kinematics).map(({ joint, mesh }) =>
    ({ mesh, world: transform(frames[joint] ?? BASE), colour, opacity: GHOST, roughness: 0.6 }));
}

/** @type {(contact: Contact, world: World, colours: Palette) => Item[]} */
function wallItems(contact, world, colours) {
  const touched = contact.isVirtual ? contact.isTouched : Math.abs(dot(world.force, contact.inwards)) > TOUCH;
  const colour = contact.isVirtual ? linearOf(colours.ghost) : linearOf(colours.accent);
  const place = facing(wallCenter(contact, world), contact.inwards, WALL);
  return [
    { mesh: square(), world: place, colour, opacity: touched ? 0.32 : 0.2, roughness: 0.9 },
    { mesh: grid(), world: place, colour, opacity: touched ? 0.85 : 0.5, roughness: 0.9 },
  ];
}

/** Returns the transform of a square of half a width that faces along a normal. @type {(center: Vec3, normal: Vec3, half: number) => import('./matrices.js').Matrix} */
function facing(center, normal, half) {
  const [u, v] = perpendiculars(normal);
  return new Float32Array([...scale(u, half), 0, ...scale(v, half), 0, ...normal, 0, ...center, 1]);
}

/** @type {(camera: Camera, world: World, colours: Palette) => Item[]} */
function roomItems(camera, { room }, colours) {
  if (!room) return [];
  return [
    ...room.obstacles.flatMap((solid) => solidItems(camera, solid, linear(colours.room.obstacle), OBSTACLE)),
    ...room.shapes.flatMap((solid) => solidItems(camera, solid, linear(colours.room.shape), OVERLAY)),
  ];
}

/** @type {(camera: Camera, solid: Solid, colour: Vec3, opacity: number) => Item[]} */
function solidItems(camera, solid, colour, opacity) {
  const look = { colour, opacity, roughness: 0.55, castsShadow: opacity === OBSTACLE };
  if (solid.kind === 'box') {
    return [{ ...look, mesh: BOX, world: transform({ position: solid.center, orientation: solid.orientation }, solid.size) }];
  }
  if (solid.kind === 'half_space') {
    const center = add(camera.target, scale(solid.normal, solid.offset - dot(camera.target, solid.normal)));
    return [square(), grid()].map((mesh, i) => ({ ...look, mesh, world: facing(center, solid.normal, HALF_SPACE), opacity: i === 0 ? 0.18 : 0.4, castsShadow: false }));
  }
  const { a, b, radius } = solid;
  const ends = (/** @type {Vec3} */ position) => ({ ...look, mesh: SPHERE, world: transform({ position, orientation: IDENTITY }, [radius, radius, radius]) });
  if (Math.hypot(...sub(b, a)) < 1e-6) return [ends(a)];
  return [ends(a), ends(b), { ...look, mesh: CYLINDER, world: along(a, b, radius) }];
}

/** @type {(camera: Camera, colours: Palette) => Item[]} */
function axisItems(camera, colours) {
  return [0, 1, 2].map((axis) => ({
    mesh: ribbon([[0, 0, 0.001], scale(axisOf(axis), AXIS * camera.size)], camera, PATH_WIDTH, false), world: transform(BASE), colour: shownOf(colours.axes[axis]), plain: true,
  }));
}

/** @type {(camera: Camera, world: World, colours: Palette) => Item[]} */
function pathItems(camera, { history, until, ghosts, colour }, colours) {
  const world = transform(BASE);
  /** @type {(of: import('./recording.js').Path, until: number | null, hex: string, isDashed: boolean) => Item[]} */
  const path = (of, until, hex, isDashed) => {
    const { columns } = of;
    const end = until === null ? of.length : of.indexAt(until) + 1;
    const step = Math.max(1, Math.ceil(end / PATH_POINTS));
    /** @type {Vec3[]} */
    const points = [];
    for (let i = 0; i < end; i += step) points.push([columns.x[i], columns.y[i], columns.z[i]]);
    if (points.length < 2) return [];
    return [{ mesh: ribbon(points, camera, PATH_WIDTH, isDashed), world, colour: shownOf(hex), plain: true }];
  };
  return [...path(history, until, colour === undefined ? colours.accent : hexOf(colours, colour), false), ...ghosts.flatMap((ghost) => path(ghost.history, ghost.until, hexOf(colours, ghost.colour), true))];
}

