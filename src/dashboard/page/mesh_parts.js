// The parts of a mesh: triangles with one colour.

/**
 * @typedef {import('./mesh.js').Triangles} Triangles
 * @typedef {import('./shading.js').Rgb} Rgb
 *
 * @typedef {{triangles: Triangles, colour: Rgb | null}} Part `colour`: null if the file states none
 */

/** Largest number of triangles of a file. */
const MAX_TRIANGLES = 2_000_000;

/** Collects triangles by colour. */
export class PartList {
  constructor() {
    /** @type {Map<string, {corners: number[], colour: Rgb | null}>} */
    this.byColour = new Map();
    this.count = 0;
  }

  /** Adds the triangle of three corners. @type {(corners: number[][], colour: Rgb | null) => void} */
  add(corners, colour) {
    this.count += 1;
    if (this.count > MAX_TRIANGLES) throw new Error(`it has more than ${MAX_TRIANGLES} triangles`);
    const key = String(colour);
    const part = this.byColour.get(key) ?? { corners: [], colour };
    this.byColour.set(key, part);
    for (const corner of corners) part.corners.push(corner[0], corner[1], corner[2]);
  }

  /** @returns {Part[]} */
  parts() {
    return Array.from(this.byColour.values(), ({ corners, colour }) => ({ triangles: new Float32Array(corners), colour }));
  }
}

/**
 * Returns triples of corners of a polygon, a strip or a list of triangles.
 * @param {'list' | 'strip' | 'fan'} kind
 * @param {number} count number of corners
 * @returns {[number, number, number][]}
 */
export function triples(kind, count) {
  /** @type {[number, number, number][]} */
  const found = [];
  const step = kind === 'list' ? 3 : 1;
  for (let i = 2; i < count; i += step) {
    if (kind === 'fan') found.push([0, i - 1, i]);
    else if (kind === 'strip' && i % 2 === 1) found.push([i - 1, i - 2, i]);
    else found.push([i - 2, i - 1, i]);
  }
  return found;
}
