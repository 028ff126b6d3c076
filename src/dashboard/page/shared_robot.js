// A dropped robot in a link: its URDF text, compressed. Meshes are not in the link.

import { named } from './robots_form.js';
import { post } from './transport.js';
import { parseUrdf } from './urdf.js';
import { loadVisuals } from './visuals.js';

/**
 * @typedef {import('./run_control.js').RunControl} RunControl
 * @typedef {import('./types.js').RobotRegistration} RobotRegistration
 */

/** Largest length of the compressed text in a link, and of the text itself, in characters and bytes. */
export const MAX_LINK = 60_000;
const MAX_TEXT = 2_000_000;

/** Fields of a registration that a link has besides the URDF text; others are ignored. */
const FIELDS = /** @type {const} */ (['limits', 'joint_names', 'tool_offset', 'base', 'tip', 'tips', 'srdf', 'shapes', 'shape_list', 'collision_pairs']);

/** Returns the registration as text for a link. @type {(registration: RobotRegistration) => Promise<string>} */
export async function packed(registration) {
  const content = Object.fromEntries([['urdf', registration.urdf], ...FIELDS.flatMap((name) => (registration[name] ? [[name, registration[name]]] : []))]);
  const bytes = await collected(new Blob([JSON.stringify(content)]).stream().pipeThrough(new CompressionStream('deflate-raw')), Infinity);
  let binary = '';
  for (const byte of bytes) binary += String.fromCharCode(byte);
  return btoa(binary).replaceAll('+', '-').replaceAll('/', '_').replace(/=+$/, '');
}

/** Reads what `packed` wrote; throws if it is broken, too long, or no robot. @type {(text: string) => Promise<Omit<RobotRegistration, 'name'> & {urdf: string}>} */
export async function unpacked(text) {
  if (text.length > MAX_LINK) throw new Error(`the robot of the link has more than ${MAX_LINK} characters`);
  if (!/^[A-Za-z0-9_-]+$/.test(text)) throw new Error('the robot of the link is damaged');
  /** @type {any} */
  let content;
  try {
    const binary = atob(text.replaceAll('-', '+').replaceAll('_', '/'));
    const stream = new Blob([Uint8Array.from(binary, (letter) => letter.charCodeAt(0))]).stream().pipeThrough(new DecompressionStream('deflate-raw'));
    content = JSON.parse(new TextDecoder('utf-8', { fatal: true }).decode(await collected(stream, MAX_TEXT)));
  } catch (error) {
    if (error instanceof TooLong) throw error;
    throw new Error('the robot of the link is damaged');
  }
  const urdf = content?.urdf;
  // A robot needs no entities, and those of XML can grow without limit.
  if (typeof urdf !== 'string' || /<!(DOCTYPE|ENTITY)/i.test(urdf)) throw new Error('the link has no URDF file of a robot');
  return { urdf, ...Object.fromEntries(FIELDS.flatMap((name) => (name in content ? [[name, content[name]]] : []))) };
}

class TooLong extends Error {}

/** Returns the bytes of a stream of at most a length. @type {(stream: ReadableStream<Uint8Array>, longest: number) => Promise<Uint8Array<ArrayBuffer>>} */
async function collected(stream, longest) {
  const reader = stream.getReader();
  /** @type {Uint8Array[]} */
  const parts = [];
  let length = 0;
  for (;;) {
    const { value, done } = await reader.read();
    if (done) break;
    length += value.length;
    if (length > longest) {
      await reader.cancel();
      throw new TooLong(`the robot of the link has more than ${longest / 1e6} MB`);
    }
    parts.push(value);
  }
  const all = new Uint8Array(length);
  let at = 0;
  for (const part of parts) {
    all.set(part, at);
    at += part.length;
  }
  return all;
}

/**
 * Registers the robot of a link under a name that depends on its content, so that it replaces no other robot.
 * @type {(runControl: RunControl, text: string, wanted: string) => Promise<string>} its name; `wanted`: its name where the link was made
 */
export async function registerShared(runControl, text, wanted) {
  const registration = await unpacked(text);
  const mark = await digest(JSON.stringify(registration));
  const stem = wanted.replace(/[^A-Za-z0-9_.-]/g, '_').replace(/^my_/, '').replace(/_[0-9a-f]{10}$/, '').slice(0, 36);
  const name = `my_${stem || 'robot'}_${mark}`;
  const known = runControl.robots.find((robot) => robot.name === name);
  /** @type {import('./types.js').Robot} */
  const robot = known ?? await post('/v1/robots', { ...registration, name });
  // The service has read the text, so it is a robot.
  const model = parseUrdf(registration.urdf);
  runControl.dropped.set(name, { ...registration, name });
  const { visuals } = await loadVisuals(named(model, registration.joint_names ?? {}, robot.chain?.base ?? model.root), new Map());
  runControl.visuals.set(name, visuals);
  await runControl.loadRobots();
  return name;
}

/** Returns the first ten digits of the SHA-256 of a text; of a simple sum on addresses without encryption. @param {string} text */
async function digest(text) {
  const bytes = new TextEncoder().encode(text);
  if (globalThis.crypto?.subtle) {
    const hash = new Uint8Array(await crypto.subtle.digest('SHA-256', bytes));
    return Array.from(hash.subarray(0, 5), (byte) => byte.toString(16).padStart(2, '0')).join('');
  }
  let [a, b] = [1, 0];
  for (const byte of bytes) {
    a = (a * 31 + byte) % 1_048_573;
    b = (b * 37 + a) % 1_048_573;
  }
  return a.toString(16).padStart(5, '0') + b.toString(16).padStart(5, '0');
}
