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
 *
 * @typedef {object} Visuals
 * @property {Urdf} urdf
 * @property {{shape: Shape, triangles: import('./mesh.js').Triangles}[]} shapes
 */

/** Number of triangles of all shapes that a canvas draws fast enough. */
const MAX_TRIANGLES = 6000;

/**
 * Loads the shapes of a robot.
 * @param {Urdf} urdf
 * @param {Map<string, File>} files by path
 * @returns {Promise<{visuals: Visuals, missing: string[]}>} `missing`: meshes that were not found or are not readable
 */
export async function loadVisuals(urdf, files) {
  /** @type {string[]} */
  const missing = [];
  const most = Math.max(60, Math.floor(MAX_TRIANGLES / Math.max(1, urdf.shapes.length)));
  const load = async (/** @type {Shape} */ shape) => {
    const { geometry } = shape;
    if (geometry.kind === 'box') return { shape, triangles: box(geometry.size) };
    if (geometry.kind === 'cylinder') return { shape, triangles: cylinder(geometry.radius, geometry.length) };
    if (geometry.kind === 'sphere') return { shape, triangles: sphere(geometry.radius) };
    const file = findFile(files, geometry.file);
    const triangles = file ? readMesh(file.name, await file.arrayBuffer()) : null;
    if (triangles) return { shape, triangles: reduced(triangles.map((value, i) => value * geometry.scale[i % 3]), most) };
    missing.push(geometry.file.replace(/^.*\//, ''));
    return null;
  };
  const shapes = (await Promise.all(urdf.shapes.map(load))).filter((shape) => shape !== null);
  return { visuals: { urdf, shapes }, missing };
}

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
 * Draws the shapes, far triangles first.
 * @param {CanvasRenderingContext2D} context
 * @param {Camera} camera
 * @param {Visuals} visuals
 * @param {Robot} robot
 * @param {number[]} position q, rad or m
 * @param {boolean[]} atLimit per joint
 * @param {import('./theme.js').Palette} colours
 */
export function drawVisuals(context, camera, visuals, robot, position, atLimit, colours) {
  const names = robot.joints.map(({ name }) => name);
  const frames = linkFrames(visuals.urdf, new Map(names.map((name, i) => [name, position[i] ?? 0])));
  const limited = new Set(visuals.urdf.joints.filter(({ name }) => atLimit[names.indexOf(name)]).map(({ child }) => child));
  const light = lightOf(camera);
  /** @type {{depth: number, fill: string, corners: {x: number, y: number}[]}[]} */
  const faces = [];
  for (const { shape, triangles } of visuals.shapes) {
    const frame = frames.get(shape.link);
    if (!frame) continue;
    const { position: origin, orientation } = compose(frame, shape.origin);
    const rgb = colours.materials[limited.has(shape.link) ? 'limit' : 'link'];
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
