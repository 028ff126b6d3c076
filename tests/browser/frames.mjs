// Measures how fast the dashboard draws an arm on its canvas, and how fast three.js draws the same arm with WebGL, both without
// a graphics card. docs/dashboard.md has the figures. Run it after tests/browser/run:
//     npm install --prefix target/browser --no-save three && REVPRIO=target/debug/revprio node target/browser/frames.mjs [FOLDER]

import { readFileSync, writeFileSync } from 'node:fs';
import { chromium } from 'playwright-core';

import { TIMEOUT_MS, cleanUp, serve } from './harness.mjs';

const FLAGS = ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'];

/** Numbers of triangles of all links together. */
const COUNTS = [6_000, 60_000];

const FRAMES = 40;
const LINKS = 8;
const [folder] = process.argv.slice(2);

/** A chain of eight links with a sphere each, as a dropped URDF file. */
const URDF = `<robot name="chain"><link name="l0"/>${Array.from({ length: LINKS }, (_, i) => `
  <link name="l${i + 1}"><visual><geometry><sphere radius="0.07"/></geometry></visual></link>
  <joint name="j${i}" type="revolute"><parent link="l${i}"/><child link="l${i + 1}"/><origin xyz="0 0 0.13"/><axis xyz="${i % 2} ${1 - (i % 2)} 0"/>
  <limit lower="-3" upper="3" velocity="2" effort="1"/></joint>`).join('')}</robot>`;

/** Runs in the page: draws with both, and returns the times per frame, ms. */
async function measure({ urdfText, counts, frames, links }) {
  const load = (name) => import(`/dashboard/${name}.js`);
  const [urdfs, visualsFile, { Camera }, { palette }, { bodies }, { drawBodies }] =
    await Promise.all(['urdf', 'visuals', 'geometry', 'theme', 'arm', 'shading'].map(load));
  const THREE = await import('/three/three.module.js');
  const [width, height] = [900, 560];
  const position = (frame) => Array.from({ length: links }, (_, i) => 0.4 * Math.sin(0.1 * frame + i));
  const names = Array.from({ length: links }, (_, i) => `j${i}`);
  const urdf = urdfs.parseUrdf(urdfText);
  const { visuals } = await visualsFile.loadVisuals(urdf, new Map());

  /** Returns the triangles of a long sphere, nine numbers each, and their number. */
  const body = (count) => {
    const rows = Math.round(Math.sqrt(count / 4));
    const geometry = new THREE.SphereGeometry(0.07, 2 * rows, rows).toNonIndexed();
    geometry.scale(1, 1, 1.4);
    return geometry;
  };
  const canvasOf = () => {
    const canvas = document.createElement('canvas');
    Object.assign(canvas, { width, height });
    document.body.replaceChildren(canvas);
    return canvas;
  };
  const timed = (draw) => {
    for (let i = 0; i < 3; i += 1) draw(i);
    const start = performance.now();
    for (let i = 0; i < frames; i += 1) draw(i);
    return (performance.now() - start) / frames;
  };

  const results = [];
  const camera = new Camera();
  Object.assign(camera, { width, height, azimuth: -0.9, target: [0, 0, 0.5] });
  const onCanvas = (draw) => {
    const canvas = canvasOf();
    const context = canvas.getContext('2d');
    const time = timed((frame) => {
      camera.azimuth = -0.9 + 0.02 * frame;
      camera.update();
      context.fillStyle = '#eef2f6';
      context.fillRect(0, 0, width, height);
      draw(context, frame);
      // Waits until the frame is drawn.
      context.getImageData(0, 0, 1, 1);
    });
    return { time, picture: canvas.toDataURL() };
  };
  const withThree = (geometry) => {
    const canvas = canvasOf();
    const renderer = new THREE.WebGLRenderer({ canvas, antialias: true, preserveDrawingBuffer: true });
    renderer.setSize(width, height, false);
    const scene = new THREE.Scene();
    scene.background = new THREE.Color('#eef2f6');
    scene.add(new THREE.HemisphereLight('#ffffff', '#8899aa', 1.6));
    const light = new THREE.DirectionalLight('#ffffff', 2);
    light.position.set(-1, -2, 3);
    scene.add(light);
    geometry.computeVertexNormals();
    const material = new THREE.MeshStandardMaterial({ color: '#c9d2dc', roughness: 0.6 });
    const meshes = visuals.shapes.map(() => new THREE.Mesh(geometry, material));
    meshes.forEach((mesh) => scene.add(mesh));
    const eye = new THREE.PerspectiveCamera(36, width / height, 0.05, 20);
    eye.up.set(0, 0, 1);
    const pixel = new Uint8Array(4);
    const gl = renderer.getContext();
    const time = timed((frame) => {
      camera.azimuth = -0.9 + 0.02 * frame;
      camera.update();
      eye.position.set(...camera.eye);
      eye.lookAt(...camera.target);
      const q = position(frame);
      const poses = urdfs.linkFrames(urdf, new Map(names.map((name, i) => [name, q[i]])));
      visuals.shapes.forEach(({ shape }, i) => {
        const { position: [x, y, z], orientation: turn } = urdfs.compose(poses.get(shape.link), shape.origin);
        meshes[i].position.set(x, y, z);
        meshes[i].quaternion.set(turn.x, turn.y, turn.z, turn.w);
      });
      renderer.render(scene, eye);
      gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
    });
    const details = gl.getExtension('WEBGL_debug_renderer_info');
    const name = details ? gl.getParameter(details.UNMASKED_RENDERER_WEBGL) : '';
    const picture = canvas.toDataURL();
    renderer.dispose();
    return { time, picture, name };
  };

  const joints = Array.from({ length: links }, (_, i) => ({ origin: [0.02 * i, 0, 0.13 * (i + 1)], axis: [i % 2, 1 - (i % 2), 0] }));
  const arm = { joints, tool: { position: [0.2, 0, 1.15] } };
  const colours = palette();
  const plain = onCanvas((context) => drawBodies(context, camera, bodies(arm, []), ({ material }) => colours.materials[material]));
  results.push({ what: 'canvas, rods and drums', ...plain });
  for (const count of counts) {
    const geometry = body(count / links);
    const triangles = new Float32Array(geometry.attributes.position.array);
    const total = (visuals.shapes.length * triangles.length) / 9;
    visuals.shapes.forEach((entry) => { entry.parts = [{ triangles, colour: null }]; });
    const robot = { joints: names.map((name) => ({ name })) };
    const canvas = onCanvas((context, frame) => visualsFile.drawVisuals(context, camera, visuals, robot, position(frame), [], colours));
    results.push({ what: `canvas, ${total} triangles`, ...canvas });
    results.push({ what: `three.js, ${total} triangles`, ...withThree(geometry) });
  }
  return results;
}

const executablePath = '/usr/bin/chromium';
const browser = await chromium.launch({ executablePath, headless: true, timeout: TIMEOUT_MS, args: FLAGS });
const service = await serve();
const context = await browser.newContext({ bypassCSP: true });
const page = await context.newPage();
await page.route('**/three/*', (route) => {
  const name = new URL(route.request().url()).pathname.replace('/three/', '');
  const text = readFileSync(new URL(`node_modules/three/build/${name}`, import.meta.url));
  return route.fulfill({ contentType: 'text/javascript', body: text });
});
await page.goto(`${service.url}/docs/`);
const results = await page.evaluate(measure, { urdfText: URDF, counts: COUNTS, frames: FRAMES, links: LINKS });
for (const [i, { what, time, picture, name }] of results.entries()) {
  console.log(`${what}: ${time.toFixed(1)} ms per frame, ${(1000 / time).toFixed(0)} frames/s ${name ?? ''}`);
  if (folder) writeFileSync(`${folder}/frames-${i}.png`, Buffer.from(picture.split(',')[1], 'base64'));
}
await context.close();
await service.stop();
cleanUp();
await browser.close();
