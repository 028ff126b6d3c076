// Reads the triangles and diffuse colours of Collada files (.dae).

import { IDENTITY, apply, multiply, scaling, translation, turn } from './matrix.js';
import { PartList, triples } from './mesh_parts.js';

/**
 * @typedef {import('./matrix.js').Matrix} Matrix
 * @typedef {import('./mesh_parts.js').Part} Part
 * @typedef {import('./shading.js').Rgb} Rgb
 * @typedef {import('./types.js').Vec3} Vec3
 * @typedef {Map<string, Element>} Ids elements by their identifiers
 * @typedef {{ids: Ids, parts: PartList}} Reader
 */

/** Largest depth of nodes inside nodes; a node can name itself as its child. */
const MAX_DEPTH = 40;

/**
 * Reads a file. Lengths are converted to m. The axes of the file are those of the link, as in other ROS tools.
 * @param {string} text
 * @returns {Part[]}
 */
export function readCollada(text) {
  const document = new DOMParser().parseFromString(text, 'text/xml');
  const root = document.documentElement;
  if (root.tagName !== 'COLLADA' || document.querySelector('parsererror')) throw new Error('it is not a Collada file');
  const ids = new Map(Array.from(document.querySelectorAll('[id]'), (element) => [element.id, element]));
  const reader = { ids, parts: new PartList() };
  const meter = Number(root.querySelector('asset > unit')?.getAttribute('meter') ?? 1);
  const unit = meter > 0 ? meter : 1;
  const toMetres = scaling([unit, unit, unit]);
  const instance = root.querySelector('scene > instance_visual_scene');
  const scene = target(ids, instance, 'url') ?? root.querySelector('library_visual_scenes > visual_scene');
  if (scene) children(scene, 'node').forEach((node) => readNode(reader, node, toMetres, 0));
  else root.querySelectorAll('library_geometries > geometry').forEach((geometry) => readGeometry(reader, geometry, toMetres, new Map()));
  return reader.parts.parts();
}

/** @type {(element: Element, name: string) => Element[]} */
const children = (element, name) => Array.from(element.children).filter(({ tagName }) => tagName === name);

/** Returns the element that an attribute such as `#base` names. @type {(ids: Ids, element: Element | null | undefined, attribute: string) => Element | undefined} */
const target = (ids, element, attribute) => ids.get((element?.getAttribute(attribute) ?? '').replace(/^#/, ''));

/** @type {(element: Element | null | undefined) => number[]} */
function numbers(element) {
  const text = element?.textContent?.trim() ?? '';
  return text === '' ? [] : text.split(/\s+/).map(Number);
}

/** @type {(reader: Reader, node: Element, before: Matrix, depth: number) => void} */
function readNode(reader, node, before, depth) {
  if (depth > MAX_DEPTH) throw new Error('its nodes are nested too deeply');
  const matrix = Array.from(node.children, transform).reduce(multiply, before);
  for (const instance of children(node, 'instance_geometry')) {
    const geometry = target(reader.ids, instance, 'url');
    if (geometry) readGeometry(reader, geometry, matrix, materials(reader.ids, instance));
  }
  const named = children(node, 'instance_node').map((instance) => target(reader.ids, instance, 'url'));
  for (const child of [...children(node, 'node'), ...named]) if (child) readNode(reader, child, matrix, depth + 1);
}

/** Returns the transform of an element of a node; the identity for other elements. @type {(element: Element) => Matrix} */
function transform(element) {
  const values = numbers(element);
  const vector = /** @type {Vec3} */ ([values[0], values[1], values[2]]);
  switch (element.tagName) {
    case 'matrix':
      return values.length === 16 ? values : IDENTITY;
    case 'translate':
      return translation(vector);
    case 'rotate':
      return turn(vector, values[3]);
    case 'scale':
      return scaling(vector);
    default:
      return IDENTITY;
  }
}

/** Returns the colours of an instance by the names that its geometry uses. @type {(ids: Ids, instance: Element) => Map<string, Rgb | null>} */
function materials(ids, instance) {
  const bound = Array.from(instance.querySelectorAll('instance_material'));
  return new Map(bound.map((one) => [one.getAttribute('symbol') ?? '', colourOf(ids, target(ids, one, 'target'))]));
}

/** @type {(ids: Ids, material: Element | undefined) => Rgb | null} */
function colourOf(ids, material) {
  const effect = target(ids, material?.querySelector('instance_effect'), 'url');
  const [r, g, b] = numbers(effect?.querySelector('profile_COMMON diffuse > color'));
  return [r, g, b].every(Number.isFinite) ? [255 * r, 255 * g, 255 * b] : null;
}

/** @type {(reader: Reader, geometry: Element, matrix: Matrix, colours: Map<string, Rgb | null>) => void} */
function readGeometry(reader, geometry, matrix, colours) {
  const mesh = geometry.querySelector('mesh');
  for (const primitive of mesh?.children ?? []) {
    const kind = { triangles: 'list', tristrips: 'strip', trifans: 'fan', polylist: 'fan', polygons: 'fan' }[primitive.tagName];
    if (!kind) continue;
    const symbol = primitive.getAttribute('material') ?? '';
    const colour = colours.get(symbol) ?? colourOf(reader.ids, reader.ids.get(symbol));
    const points = positions(reader.ids, primitive).map((point) => apply(matrix, point));
    for (const loop of loops(primitive)) {
      for (const triple of triples(/** @type {'list' | 'strip' | 'fan'} */ (kind), loop.length)) {
        reader.parts.add(triple.map((k) => cornerOf(points, loop[k])), colour);
      }
    }
  }
}

/** @type {(points: Vec3[], index: number) => Vec3} */
function cornerOf(points, index) {
  const point = points[index];
  if (!point) throw new Error(`a triangle names the corner ${index} of ${points.length}`);
  return point;
}

/** Returns the points that a primitive uses. @type {(ids: Ids, primitive: Element) => number[][]} */
function positions(ids, primitive) {
  const vertex = children(primitive, 'input').find((input) => input.getAttribute('semantic') === 'VERTEX');
  const vertices = target(ids, vertex, 'source');
  const position = Array.from(vertices?.children ?? []).find((input) => input.getAttribute('semantic') === 'POSITION');
  const source = target(ids, position, 'source');
  const values = numbers(source?.querySelector('float_array'));
  const accessor = source?.querySelector('accessor');
  const stride = Math.max(3, Number(accessor?.getAttribute('stride') ?? 3));
  const first = Number(accessor?.getAttribute('offset') ?? 0);
  return Array.from({ length: Math.floor((values.length - first) / stride) }, (_, i) => values.slice(first + i * stride, first + i * stride + 3));
}

/** Returns the indices of points of each loop: all triangles, or one strip, fan or polygon. @type {(primitive: Element) => number[][]} */
function loops(primitive) {
  const inputs = children(primitive, 'input');
  const offsets = inputs.map((input) => Number(input.getAttribute('offset') ?? 0));
  const stride = Math.max(0, ...offsets) + 1;
  const at = offsets[inputs.findIndex((input) => input.getAttribute('semantic') === 'VERTEX')] ?? 0;
  const lists = children(primitive, 'p').map((list) => numbers(list).filter((_, i) => i % stride === at));
  if (primitive.tagName !== 'polylist') return lists;
  let next = 0;
  return numbers(children(primitive, 'vcount')[0]).map((count) => {
    next += count;
    return (lists[0] ?? []).slice(next - count, next);
  });
}
