// The shapes of a robot's links, from its URDF and mesh files, and how the canvas draws them.

import { vec } from './arm.js';
import { add, cross, dot, scale, sub, unit } from './geometry.js';
import { box, cylinder, readMesh, reduced, sphere } from './mesh.js';
import { rotate } from './rotation.js';
import { brightness, lightOf, shade } from './shading.js';
import { compose, linkFrames } from './urdf.js';

/**
 * @typedef {import('./types.js').Vec3} Vec3
 * @typedef {import('./types.js').Robot} Robot
 * @typedef {import('./urdf.js').Urdf} Urdf
 * @typedef {import('./urdf.js').Shape} Shape
 * @typedef {import('./geometry.js').Camera} Camera
 * @typedef {import('./mesh_parts.js').Part} Part
 *
 * @typedef {object} Visuals
 * @property {Urdf} urdf
 * @property {{shape: Shape, parts: Part[]}[]} shapes
 */

/** Number of triangles of all shapes that are kept, and that a canvas draws fast enough. */
const MAX_TRIANGLES = 60_000;
const CANVAS_TRIANGLES = 6000;

/** Smallest value of red, green and blue that is drawn. */
const DARKEST = 34;

/** Smallest number of triangles that each part of a mesh keeps. */
const MIN_TRIANGLES = 24;

/**
 * Loads the shapes of a robot.
 * @param {Urdf} urdf
 * @param {Map<string, File>} files by path
 * @returns {Promise<{visuals: Visuals, missing: string[], unreadable: string[]}>} names of meshes that were not found, and
 *   of those that are not readable, with the reason
 */
export async function loadVisuals(urdf, files) {
  /** @type {string[][]} */
  const [missing, unreadable] = [[], []];
  const most = Math.max(60, Math.floor(MAX_TRIANGLES / Math.max(1, urdf.shapes.length)));
  const load = async (/** @type {Shape} */ shape) => {
    const { geometry, colour } = shape;
    if (geometry.kind !== 'mesh') return { shape, parts: [{ triangles: simple(geometry), colour }] };
    const name = geometry.file.replace(/^.*\//, '');
    const file = findFile(files, geometry.file);
    if (!file) {
      missing.push(name);
      return null;
    }
    try {
      const parts = await readMesh(file.name, await file.arrayBuffer(), (uri) => neighbour(files, geometry.file, uri));
      return { shape, parts: fitted(parts, geometry.scale, most, colour) };
    } catch (error) {
      unreadable.push(`${name} (${error instanceof Error ? error.message : error})`);
      return null;
    }
  };
  const shapes = (await Promise.all(urdf.shapes.map(load))).filter((shape) => shape !== null);
  return { visuals: { urdf, shapes }, missing, unreadable };
}

/** @type {(geometry: Exclude<Shape['geometry'], {kind: 'mesh'}>) => import('./mesh.js').Triangles} */
function simple(geometry) {
  if (geometry.kind === 'box') return box(geometry.size);
  return geometry.kind === 'cylinder' ? cylinder(geometry.radius, geometry.length) : sphere(geometry.radius);
}

/** Scales the parts of a mesh, and reduces them to a number of triangles. @type {(parts: Part[], factors: Vec3, most: number, colour: import('./shading.js').Rgb | null) => Part[]} */
function fitted(parts, factors, most, colour) {
  const total = parts.reduce((sum, { triangles }) => sum + triangles.length, 0);
  return parts.map((part) => {
    const share = Math.max(MIN_TRIANGLES, Math.floor((most * part.triangles.length) / total));
    return { colour: part.colour ?? colour, triangles: reduced(part.triangles.map((value, i) => value * factors[i % 3]), share) };
  });
}

/** Reads a file that a mesh names. @type {(files: Map<string, File>, mesh: string, uri: string) => Promise<ArrayBuffer>} */
function neighbour(files, mesh, uri) {
  const file = findFile(files, mesh.replace(/[^/]*$/, uri));
  if (!file) throw new Error(`${uri} was not dropped with it`);
  return file.arrayBuffer();
}

/** Returns a colour that shading and a dark background leave visible. @type {(rgb: import('./shading.js').Rgb) => import('./shading.js').Rgb} */
const visible = ([r, g, b]) => [lift(r), lift(g), lift(b)];

/** @type {(value: number) => number} */
const lift = (value) => DARKEST + (1 - DARKEST / 255) * Math.min(255, Math.max(0, value));

/** Returns the file whose path ends like a `package://` address. @type {(files: Map<string, File>, address: string) => File | undefined} */
function findFile(files, address) {
  const words = address.replace(/^\w+:\/\//, '').split('/');
  for (let i = 0; i < words.length; i += 1) {
    const end = words.slice(i).join('/');
    const found = [...files].find(([path]) => path === end || path.endsWith(`/${end}`));
    if (found) return found[1];
  }
  return undefined;
}

/** Returns whether there is a shape to draw. @type {(visuals: Visuals | null) => visuals is Visuals} */
export function areDrawable(visuals) {
  return visuals !== null && visuals.shapes.length > 0;
}

/**
 * Returns the parts of the shapes with their frames and colours.
 * @param {Visuals} visuals
 * @param {Robot} robot
 * @param {number[]} position q, rad or m
 * @param {boolean[]} atLimit per joint
 * @param {import('./theme.js').Palette} colours
 * @returns {{triangles: import('./mesh.js').Triangles, frame: import('./urdf.js').Placement, rgb: import('./shading.js').Rgb}[]}
 */
export function placedParts(visuals, robot, position, atLimit, colours) {
  const names = robot.joints.map(({ name }) => name);
  const frames = linkFrames(visuals.urdf, new Map(names.map((name, i) => [name, position[i] ?? 0])));
  const limited = new Set(visuals.urdf.joints.filter(({ name }) => atLimit[names.indexOf(name)]).map(({ child }) => child));
  return visuals.shapes.flatMap(({ shape, parts }) => {
    const link = frames.get(shape.link);
    if (!link) return [];
    const frame = compose(link, shape.origin);
    return parts.map(({ triangles, colour }) => ({
      triangles, frame, rgb: limited.has(shape.link) ? colours.materials.limit : (colour ? visible(colour) : colours.materials.link),
    }));
  });
}

/** Triangles that a canvas draws fast enough, by the full ones. @type {WeakMap<import('./mesh.js').Triangles, import('./mesh.js').Triangles>} */
const coarse = new WeakMap();

/** Returns fewer triangles, so that all parts together have about `CANVAS_TRIANGLES`. @type {(triangles: import('./mesh.js').Triangles, total: number) => import('./mesh.js').Triangles} */
function fewer(triangles, total) {
  const known = coarse.get(triangles);
  if (known) return known;
  const most = Math.max(MIN_TRIANGLES, Math.floor((CANVAS_TRIANGLES * triangles.length) / total));
  const result = triangles.length / 9 > most ? reduced(triangles, most) : triangles;
  coarse.set(triangles, result);
  return result;
}

/**
 * Draws the shapes on a canvas, far triangles first.
 * @param {CanvasRenderingContext2D} context
 * @param {Camera} camera
 * @param {{triangles: import('./mesh.js').Triangles, frame: import('./urdf.js').Placement, rgb: import('./shading.js').Rgb}[]} parts
 */
export function drawParts(context, camera, parts) {
  const light = lightOf(camera);
  const total = parts.reduce((sum, { triangles }) => sum + triangles.length, 0);
  /** @type {{depth: number, fill: string, corners: {x: number, y: number}[]}[]} */
  const faces = [];
  for (const { triangles: all, frame: { position: origin, orientation }, rgb } of parts) {
    const triangles = fewer(all, total);
    for (let i = 0; i < triangles.length; i += 9) {
      const corner = (/** @type {number} */ k) => add(origin, rotate(orientation, vec([triangles[i + k], triangles[i + k + 1], triangles[i + k + 2]])));
      const [a, b, c] = [corner(0), corner(3), corner(6)];
      const normal = unit(cross(sub(b, a), sub(c, a)));
      const facing = dot(sub(camera.eye, a), normal) < 0 ? scale(normal, -1) : normal;
      const spots = [camera.project(a), camera.project(b), camera.project(c)];
      const depth = spots[0].depth + spots[1].depth + spots[2].depth;
      faces.push({ depth, fill: shade(rgb, brightness(facing, light)), corners: spots });
    }
  }
  faces.sort((one, other) => other.depth - one.depth);
  for (const { fill, corners } of faces) {
    context.fillStyle = fill;
    context.strokeStyle = fill;
    context.lineWidth = 0.6;
    context.beginPath();
    corners.forEach(({ x, y }, k) => (k === 0 ? context.moveTo(x, y) : context.lineTo(x, y)));
    context.closePath();
    context.fill();
    context.stroke();
  }
}
