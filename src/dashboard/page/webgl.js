// A small renderer with WebGL 2: lit bodies with shadows, a floor, translucent bodies and paths, with anti-aliasing.

import { lightProjection, projection, transform } from './matrices.js';
import { IDENTITY } from './rotation.js';
import { SOURCES } from './webgl_shaders.js';

/**
 * @typedef {import('./types.js').Vec3} Vec3
 * @typedef {import('./geometry.js').Camera} Camera
 * @typedef {import('./matrices.js').Matrix} Matrix
 * @typedef {keyof typeof SOURCES} ProgramName
 *
 * @typedef {object} Mesh triangles with their normals, x y z per corner
 * @property {Float32Array} places
 * @property {Float32Array} normals
 * @property {boolean} [isTemporary] drawn once
 *
 * @typedef {object} Item a body to draw
 * @property {Mesh} mesh
 * @property {Matrix} world from the mesh to the base
 * @property {Vec3} colour linear red, green and blue, 0 to 1
 * @property {number} [roughness]
 * @property {number} [metal]
 * @property {number} [opacity]
 * @property {boolean} [castsShadow]
 * @property {boolean} [plain] one colour without light
 *
 * @typedef {object} Look
 * @property {Vec3} above colour of the sky as shown
 * @property {Vec3} below
 * @property {Vec3} line of the grid
 * @property {Vec3} sky light from above
 * @property {Vec3} ground light from below
 * @property {Vec3} lamp
 * @property {number} darkness of the shadow on the floor
 *
 * @typedef {{array: WebGLVertexArrayObject, buffers: WebGLBuffer[], count: number}} Uploaded
 * @typedef {{program: WebGLProgram, places: Map<string, WebGLUniformLocation>}} Program
 */

/** Width and height of the shadow map, px. */
const SHADOW_SIZE = 2048;

/** Direction towards the lamp. */
const LIGHT = /** @type {Vec3} */ ([-0.352, -0.528, 0.773]);

/** The floor and the picture as two triangles each. */
const SQUARE = new Float32Array([-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, -1, 0, 1, 1, 0, -1, 1, 0]);

export class Renderer {
  /** @param {WebGL2RenderingContext} gl */
  constructor(gl) {
    this.gl = gl;
    const entries = Object.entries(SOURCES).map(([name, sources]) => [name, link(gl, sources[0], sources[1])]);
    this.programs = /** @type {Record<ProgramName, Program>} */ (Object.fromEntries(entries));
    /** @type {WeakMap<Mesh, Uploaded>} */
    this.arrays = new WeakMap();
    this.square = { places: SQUARE, normals: new Float32Array(SQUARE.map((_, i) => Number(i % 3 === 2))) };
    this.shadows = shadowMap(gl);
    gl.enable(gl.DEPTH_TEST);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
  }

  /** Draws the picture, or the part between two places across, 0 to 1. @type {(camera: Camera, items: Item[], look: Look, center: Vec3, reach: number, span?: [number, number]) => void} */
  draw(camera, items, look, center, reach, [from, to] = [0, 1]) {
    const { gl } = this;
    gl.disable(gl.SCISSOR_TEST);
    const shade = lightProjection(LIGHT, center, 1.25 * reach);
    const view = projection(camera);
    this.drawShadows(items.filter(({ castsShadow }) => castsShadow), shade);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.viewport(0, 0, gl.drawingBufferWidth, gl.drawingBufferHeight);
    if (from > 0 || to < 1) {
      const [left, right] = [from, to].map((part) => Math.round(part * gl.drawingBufferWidth));
      gl.enable(gl.SCISSOR_TEST);
      gl.scissor(left, 0, Math.max(0, right - left), gl.drawingBufferHeight);
    }
    gl.clear(gl.DEPTH_BUFFER_BIT | gl.COLOR_BUFFER_BIT);
    this.drawSky(look);
    const solid = items.filter(({ opacity = 1 }) => opacity >= 1);
    const program = this.use('lit', { view, shade, eye: camera.eye, light: LIGHT, shadowed: 1, emitted: [0, 0, 0], ...look });
    for (const item of solid.filter(({ plain }) => !plain)) this.drawItem(program, item);
    this.drawFloor(camera, look, view, shade, reach);
    const lines = this.use('plain', { view });
    for (const item of solid.filter(({ plain }) => plain)) this.drawItem(lines, item);
    const clear = items.filter(({ opacity = 1 }) => opacity < 1);
    for (const group of new Set(clear.map(({ opacity }) => opacity))) {
      this.drawClear(clear.filter(({ opacity }) => opacity === group), view, shade, camera.eye, look);
    }
  }

  /** @type {(items: Item[], shade: Matrix) => void} */
  drawShadows(items, shade) {
    const { gl } = this;
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.shadows.buffer);
    gl.viewport(0, 0, SHADOW_SIZE, SHADOW_SIZE);
    gl.clear(gl.DEPTH_BUFFER_BIT);
    const program = this.use('depth', { view: shade, shade });
    for (const item of items) this.drawItem(program, item);
  }

  /** @param {Look} look */
  drawSky(look) {
    const { gl } = this;
    this.use('sky', look);
    gl.depthMask(false);
    this.drawMesh(this.square);
    gl.depthMask(true);
  }

  /** @type {(camera: Camera, look: Look, view: Matrix, shade: Matrix, reach: number) => void} */
  drawFloor(camera, look, view, shade, reach) {
    const { gl } = this;
    const size = 4 * reach;
    const world = transform({ position: [0, 0, 0], orientation: IDENTITY }, [size, size, 1]);
    this.use('floor', { ...look, world, view, shade, eye: camera.eye, cell: reach > 0.6 ? 0.5 : reach > 0.12 ? 0.1 : 0.02, reach: size, shadowed: 1 });
    gl.enable(gl.BLEND);
    gl.depthMask(false);
    this.drawMesh(this.square);
    gl.depthMask(true);
    gl.disable(gl.BLEND);
  }

  /** Draws translucent bodies: their nearest faces alone, so that none shows through another. @type {(items: Item[], view: Matrix, shade: Matrix, eye: Vec3, look: Look) => void} */
  drawClear(items, view, shade, eye, look) {
    const { gl } = this;
    // A ghost is behind the arm where both are at the same place.
    gl.enable(gl.POLYGON_OFFSET_FILL);
    gl.polygonOffset(1, 4);
    gl.colorMask(false, false, false, false);
    const depth = this.use('depth', { view, shade });
    for (const item of items) this.drawItem(depth, item);
    gl.colorMask(true, true, true, true);
    gl.depthFunc(gl.LEQUAL);
    gl.enable(gl.BLEND);
    const program = this.use('lit', { view, shade, eye, light: LIGHT, shadowed: 0, emitted: [0, 0, 0], ...look });
    for (const item of items) this.drawItem(program, item);
    gl.disable(gl.BLEND);
    gl.disable(gl.POLYGON_OFFSET_FILL);
    gl.depthFunc(gl.LESS);
  }

  /** @type {(program: Program, item: Item) => void} */
  drawItem(program, { mesh, world, colour, roughness = 0.45, metal = 0, opacity = 1 }) {
    set(this.gl, program, { world, colour, roughness, metal, opacity });
    this.drawMesh(mesh);
  }

  /** @param {Mesh} mesh */
  drawMesh(mesh) {
    const { gl } = this;
    const known = this.arrays.get(mesh) ?? upload(gl, mesh);
    gl.bindVertexArray(known.array);
    gl.drawArrays(gl.TRIANGLES, 0, known.count);
    if (!mesh.isTemporary) {
      this.arrays.set(mesh, known);
      return;
    }
    gl.deleteVertexArray(known.array);
    known.buffers.forEach((buffer) => gl.deleteBuffer(buffer));
  }

  /** @type {(name: ProgramName, values: Record<string, unknown>) => Program} */
  use(name, values) {
    const program = this.programs[name];
    this.gl.useProgram(program.program);
    set(this.gl, program, values);
    return program;
  }
}

/** Sets the uniforms that a program has. @type {(gl: WebGL2RenderingContext, program: Program, values: Record<string, unknown>) => void} */
function set(gl, { places }, values) {
  for (const [name, value] of Object.entries(values)) {
    const place = places.get(name);
    if (!place) continue;
    if (typeof value === 'number') gl.uniform1f(place, value);
    else if (value instanceof Float32Array) gl.uniformMatrix4fv(place, false, value);
    else if (Array.isArray(value)) gl.uniform3fv(place, value);
  }
}

/** @type {(gl: WebGL2RenderingContext, vertex: string, fragment: string) => Program} */
function link(gl, vertex, fragment) {
  const program = gl.createProgram();
  for (const [kind, text] of /** @type {[number, string][]} */ ([[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]])) {
    const shader = /** @type {WebGLShader} */ (gl.createShader(kind));
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(`WebGL: ${gl.getProgramInfoLog(program)}`);
  const places = new Map();
  for (let i = 0; i < gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS); i += 1) {
    const name = gl.getActiveUniform(program, i)?.name ?? '';
    places.set(name, gl.getUniformLocation(program, name));
  }
  return { program, places };
}

/** @type {(gl: WebGL2RenderingContext, mesh: Mesh) => Uploaded} */
function upload(gl, { places, normals }) {
  const array = gl.createVertexArray();
  gl.bindVertexArray(array);
  const buffers = [places, normals].map((data, slot) => {
    const buffer = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, data, gl.STATIC_DRAW);
    gl.enableVertexAttribArray(slot);
    gl.vertexAttribPointer(slot, 3, gl.FLOAT, false, 0, 0);
    return buffer;
  });
  return { array, buffers, count: places.length / 3 };
}

/** @type {(gl: WebGL2RenderingContext) => {buffer: WebGLFramebuffer}} */
function shadowMap(gl) {
  const texture = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, texture);
  gl.texStorage2D(gl.TEXTURE_2D, 1, gl.DEPTH_COMPONENT24, SHADOW_SIZE, SHADOW_SIZE);
  for (const [name, value] of [
    [gl.TEXTURE_COMPARE_MODE, gl.COMPARE_REF_TO_TEXTURE], [gl.TEXTURE_MIN_FILTER, gl.LINEAR], [gl.TEXTURE_MAG_FILTER, gl.LINEAR],
    [gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE], [gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE],
  ]) gl.texParameteri(gl.TEXTURE_2D, name, value);
  const buffer = gl.createFramebuffer();
  gl.bindFramebuffer(gl.FRAMEBUFFER, buffer);
  gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.TEXTURE_2D, texture, 0);
  gl.drawBuffers([gl.NONE]);
  gl.readBuffer(gl.NONE);
  return { buffer };
}
