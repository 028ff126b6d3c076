// Tests of the mesh files that the page reads: Collada and glTF, with colours, and files that are not readable.

import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { deflateRawSync } from 'node:zlib';

import { TIMEOUT_MS, cleanUp, drop, launch, open, serve, waitForState, waitForText } from './harness.mjs';

let browser;
let service;
before(async () => {
  browser = await launch();
  service = await serve();
}, { timeout: TIMEOUT_MS });
after(async () => {
  cleanUp();
  await browser?.close();
});

const options = { timeout: 2 * TIMEOUT_MS };

/** Opens the playground; afterwards the page must have had no errors. */
async function withPage(body) {
  const { page, pageErrors, close } = await open(browser, `${service.url}/#scenario=playground&robot=panda`);
  try {
    await waitForState(page, 'connection', 'ready');
    await body(page);
    // Chromium describes malformed XML in an element with a style, which the policy of the page forbids.
    assert.deepEqual(pageErrors.filter((text) => !text.startsWith('Applying inline style')), []);
  } finally {
    await page.goto('about:blank');
    await close();
  }
}

/** Reads mesh files in the page: per file its parts, or the message of the error. */
const read = (page, files) => page.evaluate(async (files) => {
  const { readMesh } = await import('/dashboard/mesh.js');
  const bytesOf = (list) => new Uint8Array(list).buffer;
  const load = async (uri) => {
    const found = files.find(([name]) => name === uri);
    if (!found) throw new Error(`${uri} was not dropped with it`);
    return bytesOf(found[1]);
  };
  return Promise.all(files.map(async ([name, bytes]) => {
    try {
      const parts = await readMesh(name, bytesOf(bytes), load);
      return parts.map(({ triangles, colour }) => ({ triangles: [...triangles].map((value) => Math.round(value * 1e6) / 1e6 + 0), colour: colour?.map(Math.round) ?? null }));
    } catch (error) {
      return error.message;
    }
  }));
}, files.map(([name, content]) => [name, [...Buffer.from(content)]]));

const material = (name, colour) => `<effect id="${name}-effect"><profile_COMMON><technique sid="common"><lambert><diffuse><color>${colour} 1</color></diffuse></lambert></technique></profile_COMMON></effect>`;

/** A triangle and a square in mm with two colours. Nodes turn, shift and scale them; the square is used twice. */
const COLLADA = `<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
  <asset><unit name="millimeter" meter="0.001"/><up_axis>Y_UP</up_axis></asset>
  <library_effects>${material('red', '1 0 0')}${material('grey', '0.5 0.5 0.5')}</library_effects>
  <library_materials>
    <material id="red"><instance_effect url="#red-effect"/></material>
    <material id="grey"><instance_effect url="#grey-effect"/></material>
  </library_materials>
  <library_geometries>
    <geometry id="triangle"><mesh>
      <source id="triangle-points"><float_array id="triangle-array" count="9">0 0 0 100 0 0 0 100 0</float_array>
        <technique_common><accessor source="#triangle-array" count="3" stride="3"/></technique_common></source>
      <vertices id="triangle-vertices"><input semantic="POSITION" source="#triangle-points"/></vertices>
      <triangles material="paint" count="1"><input semantic="VERTEX" source="#triangle-vertices" offset="0"/><input semantic="NORMAL" source="#none" offset="1"/><p>0 9 1 9 2 9</p></triangles>
    </mesh></geometry>
    <geometry id="square"><mesh>
      <source id="square-points"><float_array id="square-array" count="12">0 0 0 10 0 0 10 10 0 0 10 0</float_array></source>
      <vertices id="square-vertices"><input semantic="POSITION" source="#square-points"/></vertices>
      <polylist material="grey" count="1"><input semantic="VERTEX" source="#square-vertices" offset="0"/><vcount>4</vcount><p>0 1 2 3</p></polylist>
    </mesh></geometry>
  </library_geometries>
  <library_nodes><node id="tile"><instance_geometry url="#square"/></node></library_nodes>
  <library_visual_scenes><visual_scene id="scene">
    <node><translate>0 0 200</translate><rotate>0 0 1 90</rotate>
      <node><scale>2 1 1</scale><instance_geometry url="#triangle"><bind_material><technique_common><instance_material symbol="paint" target="#red"/></technique_common></bind_material></instance_geometry></node>
    </node>
    <node><matrix>1 0 0 50 0 1 0 0 0 0 1 0 0 0 0 1</matrix><instance_node url="#tile"/></node>
    <node><instance_node url="#tile"/></node>
  </visual_scene></library_visual_scenes>
  <scene><instance_visual_scene url="#scene"/></scene>
</COLLADA>`;

/** The points of a square as floats, and its two triangles as shorts. */
function squareData() {
  const data = Buffer.alloc(4 * 12 + 2 * 6);
  [0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0].forEach((value, i) => data.writeFloatLE(value, 4 * i));
  [0, 1, 2, 0, 2, 3].forEach((value, i) => data.writeUInt16LE(value, 48 + 2 * i));
  return data;
}

/** A square that a node halves and another one turns about z and shifts; `uri`: of its data. */
const gltf = (uri) => ({
  asset: { version: '2.0' }, scene: 0, scenes: [{ nodes: [0] }],
  nodes: [{ children: [1], translation: [0, 0, 1], rotation: [0, 0, Math.SQRT1_2, Math.SQRT1_2] }, { mesh: 0, scale: [0.5, 0.5, 0.5] }],
  meshes: [{ primitives: [{ attributes: { POSITION: 0 }, indices: 1, material: 0 }] }],
  materials: [{ pbrMetallicRoughness: { baseColorFactor: [1, 0.2159, 0, 1] } }],
  accessors: [{ bufferView: 0, componentType: 5126, count: 4, type: 'VEC3' }, { bufferView: 1, componentType: 5123, count: 6, type: 'SCALAR' }],
  bufferViews: [{ buffer: 0, byteOffset: 0, byteLength: 48 }, { buffer: 0, byteOffset: 48, byteLength: 12 }],
  buffers: [{ byteLength: 60, ...(uri && { uri }) }],
});

/** A binary glTF file. */
function glb() {
  const text = Buffer.from(JSON.stringify(gltf()));
  const json = Buffer.concat([text, Buffer.alloc((4 - (text.length % 4)) % 4, ' ')]);
  const words = (...values) => Buffer.from(new Uint32Array(values).buffer);
  const data = squareData();
  const length = 12 + 8 + json.length + 8 + data.length;
  return Buffer.concat([words(0x46546c67, 2, length), words(json.length, 0x4e4f534a), json, words(data.length, 0x004e4942), data]);
}

test('Collada files have their units, transforms of nodes and colours', options, () => withPage(async (page) => {
  const [parts] = await read(page, [['part.dae', COLLADA]]);
  const tile = [0, 0, 0, 0.01, 0, 0, 0.01, 0.01, 0, 0, 0, 0, 0.01, 0.01, 0, 0, 0.01, 0];
  assert.deepEqual(parts, [
    { triangles: [0, 0, 0.2, 0, 0.2, 0.2, -0.1, 0, 0.2], colour: [255, 0, 0] },
    { triangles: [...tile.map((value, i) => (i % 3 === 0 ? value * 1000 + 50 : value * 1000) / 1000), ...tile], colour: [128, 128, 128] },
  ]);
}));

test('glTF files have embedded, dropped or binary data, transforms of nodes and colours', options, () => withPage(async (page) => {
  const data = squareData();
  const files = [
    ['embedded.gltf', JSON.stringify(gltf(`data:application/octet-stream;base64,${data.toString('base64')}`))],
    ['beside.gltf', JSON.stringify(gltf('square.bin'))], ['binary.glb', glb()], ['square.bin', data],
  ];
  const results = await read(page, files);
  for (const parts of results.slice(0, 3)) {
    assert.deepEqual(parts, [{ triangles: [0, 0, 1, 0, 0.5, 1, -0.5, 0.5, 1, 0, 0, 1, -0.5, 0.5, 1, -0.5, 0, 1], colour: [255, 128, 0] }]);
  }
}));

test('files that are not readable have a reason', options, () => withPage(async (page) => {
  const changed = (change) => JSON.stringify({ ...gltf(`data:;base64,${squareData().toString('base64')}`), ...change });
  const files = [
    ['text.dae', 'no xml', /not a Collada file/],
    ['open.dae', COLLADA.slice(0, 900), /not a Collada file/],
    ['empty.dae', '<COLLADA/>', /no triangles/],
    ['corner.dae', COLLADA.replace('<p>0 1 2 3</p>', '<p>0 1 2 7</p>'), /corner 7 of 4/],
    ['number.dae', COLLADA.replace('0 0 0 100', '0 x 0 100'), /not a number/],
    ['cycle.dae', COLLADA.replace('<node id="tile">', '<node id="tile"><instance_node url="#tile"/>'), /nested too deeply/],
    ['text.gltf', 'no json', /JSON/],
    ['null.gltf', 'null', /\w/],
    ['cut.glb', glb().subarray(0, -20), /ends too early/],
    ['short.glb', glb().subarray(0, 30), /\w/],
    ['old.glb', Buffer.concat([glb().subarray(0, 4), Buffer.from([1, 0, 0, 0]), glb().subarray(8)]), /version 2/],
    ['away.gltf', JSON.stringify(gltf('nowhere.bin')), /nowhere\.bin was not dropped/],
    ['count.gltf', changed({ accessors: [{ bufferView: 0, componentType: 5126, count: 400, type: 'VEC3' }] }), /ends too early/],
    ['cycle.gltf', changed({ nodes: [{ children: [0] }] }), /nested too deeply/],
    ['draco.gltf', changed({ extensionsRequired: ['KHR_draco_mesh_compression'] }), /compressed with KHR_draco/],
    ['photo.png', 'png', /format/],
  ];
  const results = await read(page, files.map(([name, content]) => [name, content]));
  files.forEach(([name, , pattern], i) => assert.match(String(results[i]), pattern, name));
}));

/** A robot with two links; each has a mesh. */
const URDF = `<robot name="painted"><material name="blue"><color rgba="0 0 1 1"/></material>
  <link name="base"><visual><geometry><mesh filename="package://painted/meshes/base.dae" scale="1.2 1.2 1.2"/></geometry></visual></link>
  <link name="arm"><visual><geometry><mesh filename="meshes/arm.glb" scale="0.3 0.3 0.3"/></geometry></visual></link>
  <link name="tool"><visual><geometry><sphere radius="0.05"/></geometry><material name="blue"/></visual></link>
  <joint name="turn" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/><limit lower="-2" upper="2" velocity="2" effort="9"/></joint>
  <joint name="bend" type="revolute"><parent link="arm"/><child link="tool"/><origin xyz="0.3 0 0.4"/><axis xyz="0 1 0"/><limit lower="-2" upper="2" velocity="2" effort="9"/></joint>
</robot>`;

test('meshes that are dropped with a URDF file are drawn in their colours, and a broken one is named', options, () => withPage(async (page) => {
  await drop(page, [['painted.urdf', URDF], ['base.dae', COLLADA], ['arm.glb', glb()]]);
  await waitForText(page, '#notice', /Robot my_painted.*2 joints and 3 shapes\. Chain/);
  await page.waitForFunction(() => {
    const canvas = document.getElementById('scene');
    const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
    const found = { red: 0, orange: 0, blue: 0 };
    for (let i = 0; i < data.length; i += 4) {
      const [r, g, b] = data.subarray(i, i + 3);
      if (r > 110 && g < 0.35 * r && b < 0.35 * r) found.red += 1;
      if (r > 110 && g > 0.4 * r && g < 0.7 * r && b < 0.35 * r) found.orange += 1;
      if (b > 110 && r < 0.35 * b && g < 0.35 * b) found.blue += 1;
    }
    return Object.values(found).every((count) => count > 30);
  });
  await drop(page, [['painted.urdf', URDF], ['base.dae', '<COLLADA/>']]);
  await waitForText(page, '#notice', /2 joints and 1 shapes\..*Not found: arm\.glb\. Drop their folder too\. Not readable: base\.dae \(it has no triangles\)/);
}));

/** A zip file; texts are deflated, other data is stored. */
function zip(files) {
  const numbers = (...pairs) => Buffer.concat(pairs.map(([value, length]) => {
    const bytes = Buffer.alloc(length);
    bytes.writeUIntLE(value, 0, length);
    return bytes;
  }));
  const [parts, directory] = [[], []];
  let at = 0;
  for (const [name, content] of files) {
    const data = Buffer.from(content);
    const isText = typeof content === 'string';
    const packed = isText ? deflateRawSync(data) : data;
    const about = numbers([20, 2], [0, 2], [isText ? 8 : 0, 2], [0, 4], [0, 4], [packed.length, 4], [data.length, 4], [name.length, 2], [0, 2]);
    const part = Buffer.concat([numbers([0x04034b50, 4]), about, Buffer.from(name), packed]);
    directory.push(numbers([0x02014b50, 4], [20, 2]), about, numbers([0, 2], [0, 2], [0, 2], [0, 4], [at, 4]), Buffer.from(name));
    parts.push(part);
    at += part.length;
  }
  const list = Buffer.concat(directory);
  return Buffer.concat([...parts, list, numbers([0x06054b50, 4], [0, 4], [files.length, 2], [files.length, 2], [list.length, 4], [at, 4], [0, 2])]);
}

test('a zip file of a robot and its meshes is dropped, and a broken one has a reason', options, () => withPage(async (page) => {
  const files = [['painted/package.xml', '<package/>'], ['painted/urdf/painted.urdf', URDF], ['painted/meshes/base.dae', COLLADA], ['painted/meshes/arm.glb', glb()]];
  await drop(page, [['painted.zip', zip(files)]]);
  await waitForText(page, '#notice', /Robot my_painted.*2 joints and 3 shapes\. Chain/);
  await drop(page, [['broken.zip', Buffer.from('PK no zip')]]);
  await waitForText(page, '#notice', /broken\.zip is not readable: it is not a zip file/);
  await drop(page, [['cut.zip', Buffer.concat([Buffer.alloc(40), zip(files).subarray(-22)])]]);
  await waitForText(page, '#notice', /cut\.zip is not readable/);
}));
