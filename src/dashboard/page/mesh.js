// Triangles of meshes: reads mesh files, makes simple bodies, and reduces large meshes.

import { readCollada } from './collada.js';
import { readGltf } from './gltf.js';

/** @typedef {import('./types.js').Vec3} Vec3 */
/** Three corners per triangle, x y z each: nine numbers. @typedef {Float32Array} Triangles */

/**
 * Reads a mesh file. Throws an error with the reason if it is not readable.
 * @param {string} name
 * @param {ArrayBuffer} data
 * @param {import('./gltf.js').Load} load reads other files that it names
 * @returns {Promise<import('./mesh_parts.js').Part[]>}
 */
export async function readMesh(name, data, load) {
  const parts = await partsOf(name, data, load);
  const filled = parts.filter(({ triangles }) => triangles.length > 0);
  if (filled.length === 0) throw new Error('it has no triangles');
  if (filled.some(({ triangles }) => !triangles.every(Number.isFinite))) throw new Error('a corner of it is not a number');
  return filled;
}

/** @type {(name: string, data: ArrayBuffer, load: import('./gltf.js').Load) => Promise<import('./mesh_parts.js').Part[]>} */
async function partsOf(name, data, load) {
  const text = () => new TextDecoder().decode(data);
  if (/\.stl$/i.test(name)) return [{ triangles: readStl(data), colour: null }];
  if (/\.obj$/i.test(name)) return [{ triangles: readObj(text()), colour: null }];
  if (/\.dae$/i.test(name)) return readCollada(text());
  if (/\.(gltf|glb)$/i.test(name)) return readGltf(data, load);
  throw new Error('its format is not known');
}

/** @type {(data: ArrayBuffer) => Triangles} */
function readStl(data) {
  const view = new DataView(data);
  const count = data.byteLength >= 84 ? view.getUint32(80, true) : 0;
  if (data.byteLength !== 84 + 50 * count) return readStlText(new TextDecoder().decode(data));
  const triangles = new Float32Array(9 * count);
  for (let i = 0; i < count; i += 1) {
    for (let k = 0; k < 9; k += 1) triangles[9 * i + k] = view.getFloat32(84 + 50 * i + 12 + 4 * k, true);
  }
  return triangles;
}

/** @type {(text: string) => Triangles} */
function readStlText(text) {
  const numbers = Array.from(text.matchAll(/vertex\s+(\S+)\s+(\S+)\s+(\S+)/g), ([, x, y, z]) => [x, y, z].map(Number)).flat();
  return new Float32Array(numbers.slice(0, numbers.length - (numbers.length % 9)));
}

/** @type {(text: string) => Triangles} */
function readObj(text) {
  /** @type {number[][]} */
  const points = [];
  /** @type {number[]} */
  const triangles = [];
  for (const line of text.split('\n')) {
    const [kind, ...words] = line.trim().split(/\s+/);
    if (kind === 'v') points.push(words.slice(0, 3).map(Number));
    if (kind !== 'f') continue;
    const corners = words.map((word) => {
      const index = Number.parseInt(word, 10);
      return points[index < 0 ? points.length + index : index - 1] ?? [0, 0, 0];
    });
    for (let i = 2; i < corners.length; i += 1) triangles.push(...corners[0], ...corners[i - 1], ...corners[i]);
  }
  return new Float32Array(triangles);
}

/** Returns the triangles of a convex body from rings of points along z. @type {(rings: Vec3[][]) => Triangles} */
function fromRings(rings) {
  /** @type {number[]} */
  const triangles = [];
  for (let i = 0; i + 1 < rings.length; i += 1) {
    const [low, high] = [rings[i], rings[i + 1]];
    low.forEach((_, k) => {
      const next = (k + 1) % low.length;
      triangles.push(...low[k], ...low[next], ...high[next], ...low[k], ...high[next], ...high[k]);
    });
  }
  return new Float32Array(triangles);
}

/** @type {(corners: number, radius: number, z: number, turn?: number) => Vec3[]} */
function ring(corners, radius, z, turn = 0) {
  return Array.from({ length: corners }, (_, k) => {
    const angle = turn + (2 * Math.PI * k) / corners;
    return [radius * Math.cos(angle), radius * Math.sin(angle), z];
  });
}

/** @type {(size: Vec3) => Triangles} */
export function box([x, y, z]) {
  const square = (/** @type {number} */ at, /** @type {number} */ size) =>
    ring(4, size * Math.SQRT1_2, at, Math.PI / 4).map(([a, b, c]) => /** @type {Vec3} */ ([a * x, b * y, c]));
  return fromRings([square(-z / 2, 0), square(-z / 2, 1), square(z / 2, 1), square(z / 2, 0)]);
}

/** @type {(radius: number, length: number) => Triangles} */
export function cylinder(radius, length) {
  const half = length / 2;
  return fromRings([ring(20, 0, -half), ring(20, radius, -half), ring(20, radius, half), ring(20, 0, half)]);
}

/** @type {(radius: number) => Triangles} */
export function sphere(radius) {
  const angles = Array.from({ length: 9 }, (_, i) => (Math.PI * i) / 8 - Math.PI / 2);
  return fromRings(angles.map((angle) => ring(14, radius * Math.cos(angle), radius * Math.sin(angle))));
}

/**
 * Reduces a mesh: corners in the same cell of a grid become one. Triangles without area disappear.
 * @param {Triangles} triangles
 * @param {number} most number of triangles that should be left
 * @returns {Triangles}
 */
export function reduced(triangles, most) {
  let result = triangles;
  for (let cells = 48; result.length / 9 > most && cells >= 6; cells = Math.floor(cells * 0.75)) {
    result = clustered(triangles, cells);
  }
  return result;
}

/** @type {(triangles: Triangles, cells: number) => Triangles} */
function clustered(triangles, cells) {
  const [low, high] = [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]];
  triangles.forEach((value, i) => {
    low[i % 3] = Math.min(low[i % 3], value);
    high[i % 3] = Math.max(high[i % 3], value);
  });
  const size = Math.max(high[0] - low[0], high[1] - low[1], high[2] - low[2], 1e-9) / cells;
  const cell = (/** @type {number} */ corner) =>
    [0, 1, 2].reduce((key, k) => key * 64 + Math.floor((triangles[corner + k] - low[k]) / size), 0);
  /** Sum of the corners in each cell, and their number. @type {Map<number, number[]>} */
  const sums = new Map();
  for (let corner = 0; corner < triangles.length; corner += 3) {
    const sum = sums.get(cell(corner)) ?? [0, 0, 0, 0];
    sums.set(cell(corner), [sum[0] + triangles[corner], sum[1] + triangles[corner + 1], sum[2] + triangles[corner + 2], sum[3] + 1]);
  }
  /** @type {number[]} */
  const kept = [];
  const seen = new Set();
  for (let i = 0; i < triangles.length; i += 9) {
    const keys = [cell(i), cell(i + 3), cell(i + 6)];
    if (new Set(keys).size < 3) continue;
    const name = [...keys].sort((a, b) => a - b).join(' ');
    if (seen.has(name)) continue;
    seen.add(name);
    for (const key of keys) {
      const [x, y, z, count] = sums.get(key) ?? [0, 0, 0, 1];
      kept.push(x / count, y / count, z / count);
    }
  }
  return new Float32Array(kept);
}
