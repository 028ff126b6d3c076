// Reads the triangles and base colours of glTF files (.gltf, .glb).

import { IDENTITY, apply, multiply, rotation, scaling, translation, transposed } from './matrix.js';
import { PartList, triples } from './mesh_parts.js';

/**
 * @typedef {import('./matrix.js').Matrix} Matrix
 * @typedef {import('./mesh_parts.js').Part} Part
 * @typedef {import('./shading.js').Rgb} Rgb
 * @typedef {import('./types.js').Vec3} Vec3
 * @typedef {(uri: string) => Promise<ArrayBuffer>} Load reads the file at an address relative to the mesh
 * @typedef {{json: any, buffers: ArrayBuffer[], parts: PartList}} Reader
 */

/** The first four bytes of a binary file, and the types of its chunks. */
const MAGIC = 0x46546c67;
const JSON_CHUNK = 0x4e4f534a;
const BINARY_CHUNK = 0x004e4942;

const MAX_DEPTH = 40;

/** Size of a number in bytes, and how a view reads it. @type {Record<number, [number, (view: DataView, at: number) => number]>} */
const COMPONENTS = {
  5120: [1, (view, at) => view.getInt8(at)],
  5121: [1, (view, at) => view.getUint8(at)],
  5122: [2, (view, at) => view.getInt16(at, true)],
  5123: [2, (view, at) => view.getUint16(at, true)],
  5125: [4, (view, at) => view.getUint32(at, true)],
  5126: [4, (view, at) => view.getFloat32(at, true)],
};

/** Factors of normalized whole numbers. @type {Record<number, number>} */
const NORMALIZED = { 5120: 127, 5121: 255, 5122: 32767, 5123: 65535 };

/** Kinds of primitives that have triangles. @type {Record<number, 'list' | 'strip' | 'fan'>} */
const MODES = { 4: 'list', 5: 'strip', 6: 'fan' };

/**
 * Reads a file. The axes of the file are those of the link, as in other ROS tools.
 * @param {ArrayBuffer} data
 * @param {Load} load
 * @returns {Promise<Part[]>}
 */
export async function readGltf(data, load) {
  const { json, binary } = chunksOf(data);
  const compressed = (json.extensionsRequired ?? []).find((/** @type {string} */ name) => name.includes('compression'));
  if (compressed) throw new Error(`it is compressed with ${compressed}`);
  /** @type {ArrayBuffer[]} */
  const buffers = await Promise.all((json.buffers ?? []).map((/** @type {{uri?: string}} */ { uri }, /** @type {number} */ i) => {
    if (uri === undefined) return i === 0 && binary ? binary : new ArrayBuffer(0);
    return uri.startsWith('data:') ? decoded(uri) : load(decodeURIComponent(uri));
  }));
  const reader = { json, buffers, parts: new PartList() };
  for (const node of rootsOf(json)) readNode(reader, node, IDENTITY, 0);
  return reader.parts.parts();
}

/** @type {(data: ArrayBuffer) => {json: any, binary: ArrayBuffer | null}} */
function chunksOf(data) {
  const view = new DataView(data);
  const text = (/** @type {ArrayBuffer} */ part) => JSON.parse(new TextDecoder().decode(part));
  if (data.byteLength < 20 || view.getUint32(0, true) !== MAGIC) return { json: text(data), binary: null };
  if (view.getUint32(4, true) !== 2) throw new Error('only version 2 of glTF can be read');
  /** @type {Map<number, ArrayBuffer>} */
  const chunks = new Map();
  for (let at = 12; at + 8 <= data.byteLength;) {
    const [length, kind] = [view.getUint32(at, true), view.getUint32(at + 4, true)];
    if (at + 8 + length > data.byteLength) throw new Error('it ends too early');
    if (!chunks.has(kind)) chunks.set(kind, data.slice(at + 8, at + 8 + length));
    at += 8 + length;
  }
  return { json: text(chunks.get(JSON_CHUNK) ?? new ArrayBuffer(0)), binary: chunks.get(BINARY_CHUNK) ?? null };
}

/** Returns the bytes of a `data:` address. The policy of the page forbids to fetch it. @type {(uri: string) => ArrayBuffer} */
function decoded(uri) {
  const [head, body = ''] = [uri.slice(0, uri.indexOf(',')), uri.slice(uri.indexOf(',') + 1)];
  const text = head.endsWith(';base64') ? atob(body) : decodeURIComponent(body);
  return Uint8Array.from(text, (character) => character.charCodeAt(0)).buffer;
}

/** Returns the indices of the nodes of the scene. @type {(json: any) => number[]} */
function rootsOf(json) {
  const scene = (json.scenes ?? [])[json.scene ?? 0];
  if (scene) return scene.nodes ?? [];
  const inner = new Set((json.nodes ?? []).flatMap((/** @type {any} */ node) => node.children ?? []));
  return (json.nodes ?? []).map((/** @type {any} */ _, /** @type {number} */ i) => i).filter((/** @type {number} */ i) => !inner.has(i));
}

/** @type {(reader: Reader, index: number, before: Matrix, depth: number) => void} */
function readNode(reader, index, before, depth) {
  const { json } = reader;
  const node = json.nodes?.[index];
  if (!node) throw new Error(`it has no node ${index}`);
  if (depth > MAX_DEPTH) throw new Error('its nodes are nested too deeply');
  const matrix = multiply(before, transform(node));
  for (const primitive of json.meshes?.[node.mesh]?.primitives ?? []) readPrimitive(reader, primitive, matrix);
  for (const child of node.children ?? []) readNode(reader, child, matrix, depth + 1);
}

/** @type {(node: any) => Matrix} */
function transform({ matrix, translation: shift, rotation: turn, scale: factors }) {
  if (matrix) return transposed(matrix);
  const [x, y, z, w] = turn ?? [0, 0, 0, 1];
  return [translation(shift ?? [0, 0, 0]), rotation({ w, x, y, z }), scaling(factors ?? [1, 1, 1])].reduce(multiply);
}

/** @type {(reader: Reader, primitive: any, matrix: Matrix) => void} */
function readPrimitive(reader, primitive, matrix) {
  const kind = MODES[primitive.mode ?? 4];
  if (!kind || primitive.attributes?.POSITION === undefined) return;
  const points = accessor(reader, primitive.attributes.POSITION, 3).map((point) => apply(matrix, point));
  const order = primitive.indices === undefined ? points.map((_, i) => i) : accessor(reader, primitive.indices, 1).map(([index]) => index);
  const colour = colourOf(reader.json.materials?.[primitive.material]);
  for (const triple of triples(kind, order.length)) {
    const corners = triple.map((k) => points[order[k]]);
    if (corners.some((corner) => !corner)) throw new Error('a triangle names a corner that is not in the file');
    reader.parts.add(corners, colour);
  }
}

/** Returns the base colour. It is stated in linear light. @type {(material: any) => Rgb | null} */
function colourOf(material) {
  const factor = material?.pbrMetallicRoughness?.baseColorFactor;
  if (!Array.isArray(factor) || factor.length < 3) return null;
  const shown = (/** @type {number} */ linear) => 255 * (linear <= 0.0031308 ? 12.92 * linear : 1.055 * linear ** (1 / 2.4) - 0.055);
  return [shown(factor[0]), shown(factor[1]), shown(factor[2])];
}

/** Returns the values of an accessor, `width` numbers each. @type {(reader: Reader, index: number, width: number) => number[][]} */
function accessor({ json, buffers }, index, width) {
  const { bufferView, byteOffset = 0, componentType, count, normalized, sparse } = json.accessors?.[index] ?? {};
  const view = json.bufferViews?.[bufferView];
  const component = COMPONENTS[componentType];
  if (sparse) throw new Error('it has sparse accessors');
  if (!view || !component) throw new Error(`its accessor ${index} has no data`);
  const [size, read] = component;
  const stride = view.byteStride ?? size * width;
  const start = (view.byteOffset ?? 0) + byteOffset;
  const buffer = buffers[view.buffer ?? 0] ?? new ArrayBuffer(0);
  if (!(count >= 0) || start + (count - 1) * stride + size * width > buffer.byteLength) throw new Error('it ends too early');
  const bytes = new DataView(buffer);
  const factor = normalized ? (NORMALIZED[componentType] ?? 1) : 1;
  return Array.from({ length: count }, (_, i) => Array.from({ length: width }, (_, k) => read(bytes, start + i * stride + k * size) / factor));
}
