// Tests of the scene with WebGL 2, on a software renderer: shapes of arms, limits, paths, and the choice of the renderer.

import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';

import { TIMEOUT_MS, cleanUp, findInScene, launch, open, serve, share, waitForClock, waitForState } from './harness.mjs';

let browser;
let service;
before(async () => {
  browser = await launch({ webgl: true });
  service = await serve();
}, { timeout: TIMEOUT_MS });
after(async () => {
  cleanUp();
  await browser?.close();
});

const options = { timeout: 2 * TIMEOUT_MS };

/** Opens the page in a small window: the software renderer is slow. Afterwards the page must have had no errors. */
async function withPage(address, body, context = {}) {
  const { page, pageErrors, close } = await open(browser, `${service.url}/${address}`, { viewport: { width: 1000, height: 700 }, ...context });
  try {
    await waitForState(page, 'connection', 'ready');
    await body(page);
    assert.deepEqual(pageErrors, []);
  } finally {
    await page.goto('about:blank');
    await close();
  }
}

/** Waits until the page has drawn so many pictures. */
const drawn = (page, count) => page.evaluate(async (count) => {
  for (let i = 0; i < count; i += 1) await new Promise(requestAnimationFrame);
}, count);

test('the renderer is chosen by the address, and the canvas is used without a graphics card', options, async () => {
  for (const [query, renderer] of [['?renderer=webgl', 'webgl'], ['?renderer=canvas', 'canvas'], ['', 'canvas']]) {
    await withPage(`${query}#scenario=playground&robot=panda`, async (page) => {
      assert.equal(await page.getAttribute('#scene', 'data-renderer'), renderer, query);
      assert.equal(await page.isVisible('#solid'), renderer === 'webgl', query);
    });
  }
});

test('every built-in robot has a shape with light and shadow, without errors of WebGL', options, () => withPage('?renderer=webgl#scenario=playground&robot=panda', async (page) => {
  const robots = await page.locator('#robot option').allTextContents();
  await page.evaluate(() => { document.getElementById('setup').open = true; });
  for (const robot of robots) {
    await page.selectOption('#robot', robot);
    await page.waitForFunction((name) => document.getElementById('description').textContent.startsWith(name), robot);
    await drawn(page, 3);
    const shapes = await page.evaluate(async (name) => {
      const { Kinematics } = await import('/dashboard/kinematics.js');
      const { modelOf } = await import('/dashboard/any_model.js');
      const parts = modelOf(await Kinematics.learn(await (await fetch(`/v1/robots/${name}`)).json()));
      const numbers = parts.flatMap(({ mesh }) => [...mesh.places, ...mesh.normals]);
      const lengths = parts.flatMap(({ mesh }) => Array.from({ length: mesh.normals.length / 3 }, (_, i) => Math.hypot(...mesh.normals.subarray(3 * i, 3 * i + 3))));
      return { finite: numbers.every(Number.isFinite), triangles: lengths.length / 3, unit: lengths.every((length) => Math.abs(length - 1) < 1e-3) };
    }, robot);
    assert.ok(shapes.finite && shapes.unit, `${robot}: normals of length 1`);
    assert.ok(shapes.triangles > 1000 && shapes.triangles < 60_000, `${robot}: ${shapes.triangles} triangles`);
  }
  const error = await page.evaluate(() => document.getElementById('solid').getContext('webgl2').getError());
  assert.equal(error, 0);
  assert.equal(await page.getAttribute('#scene', 'data-renderer'), 'webgl');
}));

test('the shapes of arms fill their capsules and stay near them, in their own colours', options, () => withPage('?renderer=webgl#scenario=playground&robot=panda', async (page) => {
  for (const robot of ['panda', 'fr3', 'ur5e', 'sawyer', 'so101', 'xarm7', 'iiwa14', 'gen3']) {
    const { far, empty, colours } = await page.evaluate(async (name) => {
      const [{ Kinematics }, { modelOf }, { LinkPoses }, { ofLink }, { compose }, geometry] = await Promise.all(
        ['kinematics', 'any_model', 'link_poses', 'solids', 'urdf', 'geometry'].map((file) => import(`/dashboard/${file}.js`)));
      const robot = await (await fetch(`/v1/robots/${name}`)).json();
      const kinematics = await Kinematics.learn(robot);
      const list = robot.shapes.shape_list;
      const posture = robot.joints.map((_, i) => 0.3 - 0.1 * i);
      const poses = await LinkPoses.learn(robot, [...new Set(list.map(({ link }) => link))]);
      const capsules = list.map((shape) => ofLink(shape, poses.at(posture).get(shape.link)));
      const frames = kinematics.frames(posture);
      const still = { position: [0, 0, 0], orientation: { w: 1, x: 0, y: 0, z: 0 } };
      const parts = modelOf(kinematics);
      const corners = parts.flatMap(({ joint, mesh: { places } }) => Array.from({ length: places.length / 9 }, (_, i) =>
        compose(frames[joint] ?? still, { ...still, position: [...places.subarray(9 * i, 9 * i + 3)] }).position));
      const { add, dot, norm, scale, sub } = geometry;
      const from = (a, b, point) => {
        const along = sub(b, a);
        const s = Math.max(0, Math.min(1, dot(sub(point, a), along) / (dot(along, along) || 1)));
        return norm(sub(point, add(a, scale(along, s))));
      };
      const outside = corners.map((point) => Math.min(...capsules.map(({ a, b, radius }) => from(a, b, point) - radius))).sort((x, y) => x - y);
      const empty = capsules.map(({ a, b, radius }, i) => ({ link: list[i].link, count: corners.filter((point) => from(a, b, point) < radius).length }));
      return { far: outside[Math.floor(0.9 * outside.length)], empty: empty.filter(({ count }) => count < 20), colours: new Set(parts.map(({ finish }) => String(finish.rgb))).size };
    }, robot);
    // The screen of the Sawyer has no capsule, and those of the UR5e are thinner than its joints.
    assert.ok(far < 0.02, `${robot}: a tenth of the shape is ${far} m and more outside of its capsules`);
    assert.deepEqual(empty, [], `${robot}: capsules without a shape`);
    assert.ok(colours >= 3, `${robot}: ${colours} colours`);
  }
}));

test('a white arm is in the picture, its joint at a limit is orange, and arcs name the limit', options, async () => {
  await withPage('?renderer=webgl#scenario=playground&robot=panda', async (page) => {
    await page.waitForTimeout(1500);
    const [light, dark] = [await share(page, [[225, 227, 230], [200, 203, 206], [180, 183, 188]], 12), await share(page, [[40, 45, 52]], 30)];
    assert.ok(light > 0.02, `white ${light}`);
    assert.ok(dark > 0.0005, `rings ${dark}`);
  });
  await withPage('?renderer=webgl#scenario=joint_limits', async (page) => {
    const before = await share(page, [[226, 98, 12]], 40);
    await page.click('#go');
    await waitForState(page, 'phase', 'finished');
    await page.fill('#time', '1.2');
    await page.waitForTimeout(1200);
    const after = await share(page, [[226, 98, 12]], 40);
    assert.ok(after > before + 0.001, `orange ${before}, then ${after}`);
  });
});

test('the camera goes on turning after a quick movement and comes to rest, unless motion is reduced', options, async () => {
  for (const reducedMotion of ['no-preference', 'reduce']) {
    await withPage('?renderer=webgl#scenario=playground&robot=panda', async (page) => {
      const turned = await page.evaluate(async () => {
        const [{ Orbit }, { Camera }] = await Promise.all(['orbit', 'geometry'].map((name) => import(`/dashboard/${name}.js`)));
        const camera = new Camera();
        const orbit = new Orbit(camera);
        orbit.grab();
        for (let i = 1; i < 6; i += 1) orbit.move(12, 0, 16 * i);
        orbit.release(84);
        const released = camera.azimuth;
        for (let i = 0; i < 200; i += 1) orbit.glide(0.016);
        return { angle: Math.abs(camera.azimuth - released), isMoving: orbit.isMoving };
      });
      assert.equal(turned.isMoving, false);
      if (reducedMotion === 'reduce') assert.equal(turned.angle, 0);
      else assert.ok(turned.angle > 0.2, `${turned.angle} rad`);
    }, { reducedMotion });
  }
});

test('the page opens with a Panda that moves; a hand invites to drag the target until it is dragged', options, () => withPage('?renderer=webgl', async (page) => {
  await waitForState(page, 'phase', 'running');
  await waitForClock(page, 2);
  assert.equal(await page.inputValue('#robot'), 'panda');
  assert.equal(await page.inputValue('#motion'), 'eight');
  // A browser that draws slowly may show the target elsewhere when the mouse goes down.
  for (let drags = 0; drags < 3; drags++) {
    await page.waitForSelector('#invite:not([hidden])');
    await page.click('#go');
    await waitForState(page, 'phase', 'paused');
    await page.waitForTimeout(500);
    const target = await findInScene(page, 'movable');
    await page.mouse.down();
    await page.mouse.move(target.x - 40, target.y + 10, { steps: 6 });
    await page.mouse.up();
    await page.click('#go');
    await waitForState(page, 'phase', 'running');
    await page.waitForTimeout(2000);
    if (await page.isHidden('#invite')) return;
  }
  assert.fail('the hand stays after three drags');
}));

test('with reduced motion nothing moves by itself', options, () => withPage('?renderer=webgl', async (page) => {
  await page.waitForTimeout(1500);
  assert.equal(await page.getAttribute('#phase', 'data-phase'), 'none');
  assert.equal(await page.isVisible('#invite'), false);
}, { reducedMotion: 'reduce' }));

test('the elbow swings while the tool stays, and an arm without spare motion has no ghost', options, () => withPage('?renderer=webgl#scenario=playground&robot=panda', async (page) => {
  const found = await page.evaluate(async () => {
    const [{ Kinematics }, { swing }] = await Promise.all(['kinematics', 'swing'].map((name) => import(`/dashboard/${name}.js`)));
    const result = {};
    for (const [name, q] of [['panda', [0, 0.1, 0, -1.8, 0, 2, 0.3]], ['ur5e', [0.3, -1.2, 1.4, -0.9, 1.2, 0.2]]]) {
      const robot = await (await fetch(`/v1/robots/${name}`)).json();
      const kinematics = await Kinematics.learn(robot);
      const postures = swing(kinematics, robot, q);
      const tool = (posture) => kinematics.tool(kinematics.frames(posture)).position;
      const away = Math.max(...postures.map((posture) => Math.hypot(...tool(posture).map((value, i) => value - tool(q)[i]))));
      const moved = Math.max(...postures.map((posture) => Math.max(...posture.map((value, i) => Math.abs(value - q[i])))));
      result[name] = { count: postures.length, away, moved };
    }
    return result;
  });
  assert.ok(found.panda.count > 20 && found.panda.away < 2e-3 && found.panda.moved > 0.2, JSON.stringify(found.panda));
  assert.equal(found.ur5e.count, 1);
  await page.click('#swing');
  await page.waitForTimeout(1500);
  assert.equal(await page.getAttribute('#swing', 'aria-pressed'), 'true');
}));

test('the scene is parted between two methods', options, () => withPage('?renderer=webgl#scenario=stiff_wall_singular&ghost=damped_least_squares', async (page) => {
  assert.equal(await page.isVisible('#compare'), false);
  await page.click('#go');
  await waitForState(page, 'phase', 'finished');
  await page.waitForSelector('#compare:not([hidden])');
  const pink = [[181, 120, 160], [150, 70, 110], [120, 60, 90]];
  const before = await share(page, pink, 24);
  await page.click('[data-compare="divider"]');
  await page.waitForTimeout(1200);
  const after = await share(page, pink, 24);
  assert.ok(before > 1.3 * after, `the ghost is pink in ${before}, then in ${after} of the picture`);
}));

/** A chain of four joints whose links have a length, m. */
const chainOf = (length) => `<robot name="chain"><link name="l0"/>${[0, 1, 2, 3].map((i) => `<link name="l${i + 1}"/>
  <joint name="j${i}" type="revolute"><parent link="l${i}"/><child link="l${i + 1}"/><origin xyz="0 0 ${length}"/><axis xyz="${i % 2} ${1 - (i % 2)} 0"/>
  <limit lower="-1.5" upper="1.5" velocity="2" effort="1"/></joint>`).join('')}</robot>`;

test('small and large arms fill the same part of the picture', options, () => withPage('?renderer=webgl#scenario=playground&robot=panda', async (page) => {
  const sizes = await page.evaluate(async (texts) => {
    const [{ Kinematics }, { Framing }, { Camera }] = await Promise.all(['kinematics', 'framing', 'geometry'].map((name) => import(`/dashboard/${name}.js`)));
    const post = async (path, body) => (await fetch(path, { method: 'POST', headers: { 'content-type': 'application/json' }, body: JSON.stringify(body) })).json();
    const found = [];
    for (const [i, urdf] of texts.entries()) {
      const robot = await post('/v1/robots', { name: `chain_${i}`, urdf });
      const kinematics = await Kinematics.learn(robot);
      const position = [0.3, 0.6, 0.4, 0.8];
      const frames = kinematics.frames(position);
      const arm = { joints: frames.map(({ position: origin }) => ({ origin, axis: [0, 0, 1] })), tool: kinematics.tool(frames) };
      const camera = new Camera();
      Object.assign(camera, { width: 800, height: 600, free: { left: 100, top: 50, width: 600, height: 500 } });
      const framing = new Framing(camera);
      for (let k = 0; k < 60; k += 1) framing.follow({ arm, kinematics, contacts: [], goal: null, ghosts: [], room: null }, String(i));
      camera.update();
      const spots = [[0, 0, 0], ...arm.joints.map(({ origin }) => origin), arm.tool.position].map((point) => camera.project(point));
      const extent = (part) => Math.max(...spots.map((spot) => spot[part])) - Math.min(...spots.map((spot) => spot[part]));
      found.push(Math.hypot(extent('x'), extent('y')));
    }
    return found;
  }, [0.03, 0.3, 3].map(chainOf));
  assert.ok(Math.min(...sizes) > 200, `${sizes} px`);
  assert.ok(Math.max(...sizes) < 1.05 * Math.min(...sizes), `${sizes} px`);
}));

test('when the graphics card is lost, the canvas goes on', options, () => withPage('?renderer=webgl#scenario=playground&robot=panda', async (page) => {
  assert.equal(await page.getAttribute('#scene', 'data-renderer'), 'webgl');
  await page.evaluate(() => document.getElementById('solid').getContext('webgl2').getExtension('WEBGL_lose_context').loseContext());
  await page.waitForSelector('#scene[data-renderer="canvas"]');
  await page.click('#go');
  await waitForClock(page, 0.3);
  const painted = await page.evaluate(() => {
    const canvas = document.getElementById('scene');
    const { data } = canvas.getContext('2d').getImageData(canvas.width / 2, canvas.height / 2, 1, 1);
    return data[3];
  });
  assert.equal(painted, 255, 'the canvas paints the background');
}));
