// Draws shaded rods and cylinders on a two-dimensional canvas. Colour gradients make them look round; needs no GPU.

import { perpendiculars, add, cross, dot, scale, sub, unit } from './geometry.js';

/**
 * @typedef {import('./types.js').Vec3} Vec3
 * @typedef {import('./geometry.js').Camera} Camera
 * @typedef {import('./geometry.js').Spot} Spot
 * @typedef {import('./arm.js').Body} Body
 * @typedef {[number, number, number]} Rgb 0 to 255
 */

/** Number of corners of a drawn circle. */
const CORNERS = 28;

/** Positions across a rod where its brightness is computed: −1 and 1 are the edges, 0 is the middle. */
const GRADIENT_STOPS = [-1, -0.7, -0.35, 0, 0.35, 0.7, 1];

/**
 * Draws bodies in order of decreasing distance to the camera.
 * @param {CanvasRenderingContext2D} context
 * @param {Camera} camera
 * @param {Body[]} bodies
 * @param {(body: Body) => Rgb} colour
 */
export function drawBodies(context, camera, bodies, colour) {
  const light = lightOf(camera);
  const depthOf = (/** @type {Body} */ body) => -dot(sub(scale(add(body.a, body.b), 0.5), camera.eye), camera.back);
  // While a robot changes, its posture can still be that of another one: then a body has no place.
  const placed = bodies.map((body) => ({ body, depth: depthOf(body) })).filter(({ depth }) => Number.isFinite(depth));
  const sorted = placed.sort((one, other) => other.depth - one.depth);
  for (const { body } of sorted) {
    if (body.kind === 'rod') drawRod(context, camera, body, colour(body), light);
    else drawCylinder(context, camera, body, colour(body), light);
  }
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {Camera} camera
 * @param {import('./arm.js').Rod} body
 * @param {Rgb} rgb
 * @param {Vec3} light
 */
function drawRod(context, camera, body, rgb, light) {
  const [a, b] = [camera.project(body.a), camera.project(body.b)];
  const [ra, rb] = [body.ra * a.scale, body.rb * b.scale];
  const length = Math.hypot(b.x - a.x, b.y - a.y);
  const axis = unit(sub(body.b, body.a));
  if (length < 0.5) {
    disc(context, a.depth < b.depth ? a : b, Math.max(ra, rb), shade(rgb, 0.9));
    return;
  }
  const [nx, ny] = [-(b.y - a.y) / length, (b.x - a.x) / length];
  context.fillStyle = gradient(context, camera, axis, a, b, Math.max(ra, rb), [nx, ny], rgb, light);
  const angle = Math.atan2(ny, nx);
  context.beginPath();
  context.arc(a.x, a.y, ra, angle, angle + Math.PI);
  context.arc(b.x, b.y, rb, angle + Math.PI, angle + 2 * Math.PI);
  context.closePath();
  context.fill();
}

/**
 * Returns the colour gradient across a round body whose axis goes from `a` to `b` on the screen.
 * @param {CanvasRenderingContext2D} context
 * @param {Camera} camera
 * @param {Vec3} axis
 * @param {Spot} a
 * @param {Spot} b
 * @param {number} radius px
 * @param {[number, number]} across direction on the screen
 * @param {Rgb} rgb
 * @param {Vec3} light
 */
function gradient(context, camera, axis, a, b, radius, [nx, ny], rgb, light) {
  const [mx, my] = [(a.x + b.x) / 2, (a.y + b.y) / 2];
  const fill = context.createLinearGradient(mx - nx * radius, my - ny * radius, mx + nx * radius, my + ny * radius);
  // `side`: direction in space across the body on the screen. `facing`: perpendicular to it, towards the camera.
  const flat = add(scale(camera.right, nx), scale(camera.up, -ny));
  const side = unit(sub(flat, scale(axis, dot(flat, axis))));
  const front = unit(cross(side, axis));
  const facing = dot(front, camera.back) >= 0 ? front : scale(front, -1);
  for (const stop of GRADIENT_STOPS) {
    const normal = add(scale(side, stop), scale(facing, Math.sqrt(Math.max(0, 1 - stop * stop))));
    fill.addColorStop((stop + 1) / 2, shade(rgb, brightness(normal, light)));
  }
  return fill;
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {Camera} camera
 * @param {import('./arm.js').Cylinder} body
 * @param {Rgb} rgb
 * @param {Vec3} light
 */
function drawCylinder(context, camera, body, rgb, light) {
  const axis = unit(sub(body.b, body.a));
  const [u, v] = perpendiculars(axis);
  /** @type {(center: Vec3, r: number) => Spot[]} */
  const rim = (center, r) =>
    Array.from({ length: CORNERS }, (_, i) => {
      const angle = (2 * Math.PI * i) / CORNERS;
      return camera.project(add(center, add(scale(u, r * Math.cos(angle)), scale(v, r * Math.sin(angle)))));
    });
  const towards = sub(camera.eye, scale(add(body.a, body.b), 0.5));
  const [near, far, normal] =
    dot(towards, axis) > 0 ? [body.b, body.a, axis] : [body.a, body.b, scale(axis, -1)];
  const [a, b] = [camera.project(body.a), camera.project(body.b)];
  const length = Math.hypot(b.x - a.x, b.y - a.y);
  if (length > 0.5) {
    const sideways = /** @type {[number, number]} */ ([-(b.y - a.y) / length, (b.x - a.x) / length]);
    context.fillStyle = gradient(context, camera, axis, a, b, body.r * a.scale, sideways, rgb, light);
    polygon(context, hull([...rim(near, body.r), ...rim(far, body.r)]));
  }
  context.fillStyle = shade(rgb, brightness(normal, light));
  polygon(context, rim(near, body.r));
  context.fillStyle = shade(rgb, 0.62 * brightness(normal, light));
  polygon(context, rim(near, body.r * 0.62));
  context.fillStyle = shade(rgb, 1.12 * brightness(normal, light));
  polygon(context, rim(near, body.r * 0.5));
}

/** Returns the direction towards the light, over the left shoulder of the viewer. @type {(camera: Camera) => Vec3} */
export function lightOf(camera) {
  return unit(add(add(scale(camera.right, -0.45), scale(camera.up, 0.75)), scale(camera.back, 0.6)));
}

/** @type {(normal: Vec3, light: Vec3) => number} */
export function brightness(normal, light) {
  const towards = dot(normal, light);
  return 0.42 + 0.62 * Math.max(0, towards) + 0.18 * Math.max(0, towards) ** 12 + 0.08 * Math.min(0, towards);
}

/** @type {(rgb: Rgb, factor: number) => string} */
export function shade(rgb, factor) {
  const [r, g, b] = rgb.map((part) => Math.round(Math.min(255, part * factor)));
  return `rgb(${r},${g},${b})`;
}

/** @type {(context: CanvasRenderingContext2D, center: Spot, radius: number, fill: string) => void} */
function disc(context, center, radius, fill) {
  context.fillStyle = fill;
  context.beginPath();
  context.arc(center.x, center.y, radius, 0, 2 * Math.PI);
  context.fill();
}

/** @type {(context: CanvasRenderingContext2D, corners: {x: number, y: number}[]) => void} */
export function polygon(context, corners) {
  context.beginPath();
  corners.forEach(({ x, y }, i) => (i === 0 ? context.moveTo(x, y) : context.lineTo(x, y)));
  context.closePath();
  context.fill();
}

/** @type {(spots: Spot[]) => Spot[]} the convex outline (Andrew's monotone chain) */
function hull(spots) {
  const sorted = [...spots].sort((one, other) => one.x - other.x || one.y - other.y);
  /** @type {(list: Spot[]) => Spot[]} */
  const chain = (list) => {
    /** @type {Spot[]} */
    const kept = [];
    for (const spot of list) {
      while (kept.length > 1 && orientation(kept[kept.length - 2], kept[kept.length - 1], spot) <= 0) kept.pop();
      kept.push(spot);
    }
    kept.pop();
    return kept;
  };
  return [...chain(sorted), ...chain(sorted.reverse())];
}

/** @type {(a: Spot, b: Spot, c: Spot) => number} positive if a, b, c turn in the direction from x to y */
function orientation(a, b, c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}
