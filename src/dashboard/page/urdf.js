// Reads the links, joints and shapes of a URDF text, and computes where the links are.

import { add, scale } from './geometry.js';
import { IDENTITY, fromVector, multiply, rotate } from './rotation.js';

/**
 * @typedef {import('./types.js').Vec3} Vec3
 * @typedef {import('./types.js').Quaternion} Quaternion
 * @typedef {{position: Vec3, orientation: Quaternion}} Placement
 *
 * @typedef {object} Shape a visual of a link
 * @property {string} link
 * @property {Placement} origin in the frame of the link
 * @property {import('./shading.js').Rgb | null} colour of its material; null if it states none
 * @property {{kind: 'mesh', file: string, scale: Vec3} | {kind: 'box', size: Vec3} | {kind: 'cylinder', radius: number, length: number} | {kind: 'sphere', radius: number}} geometry
 *
 * @typedef {object} Joint
 * @property {string} name
 * @property {string} kind
 * @property {string} parent
 * @property {string} child
 * @property {Placement} origin
 * @property {Vec3} axis
 * @property {{joint: string, multiplier: number, offset: number} | null} mimic
 *
 * @typedef {object} Urdf
 * @property {string} name
 * @property {Joint[]} joints
 * @property {Shape[]} shapes
 * @property {string} root
 */

/** @type {(text: string | null | undefined, missing: Vec3) => Vec3} */
function vector(text, missing) {
  const values = (text ?? '').trim().split(/\s+/).map(Number);
  return values.length === 3 && values.every(Number.isFinite) ? [values[0], values[1], values[2]] : missing;
}

/** @type {(element: Element | null | undefined) => Placement} */
function placement(element) {
  const [roll, pitch, yaw] = vector(element?.getAttribute('rpy'), [0, 0, 0]);
  const turn = multiply(fromVector([0, 0, yaw]), multiply(fromVector([0, pitch, 0]), fromVector([roll, 0, 0])));
  return { position: vector(element?.getAttribute('xyz'), [0, 0, 0]), orientation: turn };
}

/** @type {(element: Element, name: string) => Element | undefined} the first child with this tag */
const child = (element, name) => Array.from(element.children).find(({ tagName }) => tagName === name);

/** @type {(element: Element, name: string) => Element[]} */
const children = (element, name) => Array.from(element.children).filter(({ tagName }) => tagName === name);

/** @type {(text: string) => Urdf} throws an error if the text is not a URDF */
export function parseUrdf(text) {
  const root = new DOMParser().parseFromString(text, 'text/xml').documentElement;
  if (root.tagName === 'mujoco') throw new Error('this is a MuJoCo model (MJCF), not URDF; convert it in Python: revprio.read_mjcf(FILE) returns URDF');
  if (root.tagName !== 'robot') throw new Error('this is not a URDF text: it has no <robot> element');
  const links = children(root, 'link').map((link) => link.getAttribute('name') ?? '');
  const joints = children(root, 'joint').map(joint);
  const colours = new Map(children(root, 'material').map((material) => [material.getAttribute('name') ?? '', colour(material)]));
  const inner = new Set(joints.map((joint) => joint.child));
  return {
    name: root.getAttribute('name') ?? '',
    joints,
    shapes: children(root, 'link').flatMap((link) => shapes(link, colours)),
    root: links.find((link) => !inner.has(link)) ?? '',
  };
}

/** @type {(element: Element) => Joint} */
function joint(element) {
  const mimic = child(element, 'mimic');
  return {
    name: element.getAttribute('name') ?? '',
    kind: element.getAttribute('type') ?? 'fixed',
    parent: child(element, 'parent')?.getAttribute('link') ?? '',
    child: child(element, 'child')?.getAttribute('link') ?? '',
    origin: placement(child(element, 'origin')),
    axis: vector(child(element, 'axis')?.getAttribute('xyz'), [1, 0, 0]),
    mimic: mimic ? {
      joint: mimic.getAttribute('joint') ?? '',
      multiplier: Number(mimic.getAttribute('multiplier') ?? 1),
      offset: Number(mimic.getAttribute('offset') ?? 0),
    } : null,
  };
}

/** @type {(material: Element) => import('./shading.js').Rgb | null} */
function colour(material) {
  const [r, g, b] = (child(material, 'color')?.getAttribute('rgba') ?? '').trim().split(/\s+/).map(Number);
  return [r, g, b].every(Number.isFinite) ? [255 * r, 255 * g, 255 * b] : null;
}

/** `colours`: of the named materials of the robot. @type {(link: Element, colours: Map<string, import('./shading.js').Rgb | null>) => Shape[]} */
function shapes(link, colours) {
  return children(link, 'visual').flatMap((visual) => {
    const given = child(visual, 'geometry')?.firstElementChild;
    const shape = given ? geometry(given) : null;
    const origin = placement(child(visual, 'origin'));
    const material = child(visual, 'material');
    const rgb = material ? (colour(material) ?? colours.get(material.getAttribute('name') ?? '') ?? null) : null;
    return shape ? [{ link: link.getAttribute('name') ?? '', origin, colour: rgb, geometry: shape }] : [];
  });
}

/** @type {(element: Element) => Shape['geometry'] | null} null for unknown kinds */
function geometry(element) {
  const number = (/** @type {string} */ attribute) => Number(element.getAttribute(attribute) ?? 0);
  switch (element.tagName) {
    case 'mesh':
      return { kind: 'mesh', file: element.getAttribute('filename') ?? '', scale: vector(element.getAttribute('scale'), [1, 1, 1]) };
    case 'box':
      return { kind: 'box', size: vector(element.getAttribute('size'), [0, 0, 0]) };
    case 'cylinder':
      return { kind: 'cylinder', radius: number('radius'), length: number('length') };
    case 'sphere':
      return { kind: 'sphere', radius: number('radius') };
    default:
      return null;
  }
}

/**
 * Returns the frames of the links.
 * @param {Urdf} urdf
 * @param {Map<string, number>} positions of the joints by name, rad or m; others are at 0
 * @returns {Map<string, Placement>}
 */
export function linkFrames({ joints, root }, positions) {
  /** @type {Map<string, Placement>} */
  const frames = new Map([[root, { position: [0, 0, 0], orientation: IDENTITY }]]);
  const waiting = [root];
  while (waiting.length > 0) {
    const parent = waiting.pop() ?? '';
    const frame = frames.get(parent);
    for (const joint of joints) {
      if (joint.parent !== parent || !frame || frames.has(joint.child)) continue;
      const { mimic } = joint;
      const q = mimic ? mimic.multiplier * (positions.get(mimic.joint) ?? 0) + mimic.offset : (positions.get(joint.name) ?? 0);
      frames.set(joint.child, compose(compose(frame, joint.origin), motion(joint, q)));
      waiting.push(joint.child);
    }
  }
  return frames;
}

/** @type {(joint: Joint, q: number) => Placement} */
function motion({ kind, axis }, q) {
  const along = scale(axis, q / Math.max(1e-9, Math.hypot(...axis)));
  if (kind === 'revolute' || kind === 'continuous') return { position: [0, 0, 0], orientation: fromVector(along) };
  return { position: kind === 'prismatic' ? along : [0, 0, 0], orientation: IDENTITY };
}

/** @type {(a: Placement, b: Placement) => Placement} */
export function compose(a, b) {
  return { position: add(a.position, rotate(a.orientation, b.position)), orientation: multiply(a.orientation, b.orientation) };
}
