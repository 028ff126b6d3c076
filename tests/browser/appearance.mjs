// Tests of the layout and of the accessibility of the dashboard.

import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';

import { TIMEOUT_MS, checkAccess, cleanUp, launch, open, prefer, serve, waitForClock, waitForState } from './harness.mjs';

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

/** Widths and heights of the screens, px. */
const SIZES = [[360, 740], [768, 1024], [1280, 800], [1920, 1080], [2560, 1440]];

for (const [width, height] of SIZES) {
  test(`nothing is cut off and axe finds nothing serious at ${width} x ${height}, light and dark`, options, async () => {
    const { page, pageErrors, close } = await open(browser, `${service.url}/#scenario=joint_limits`, { viewport: { width, height }, colorScheme: 'light' });
    await waitForState(page, 'connection', 'ready');
    await page.evaluate(() => document.querySelectorAll('details').forEach((part) => { part.open = true; }));
    await page.click('#add-plane');
    await page.click('#go');
    await waitForClock(page, 0.8);
    await page.fill('#time', '0.5');

    const wide = await page.evaluate(() => document.documentElement.scrollWidth);
    assert.ok(wide <= width, `${wide} px on ${width}`);
    const cut = await page.evaluate(() => Array.from(document.querySelectorAll('.readouts dt, .readouts dd, .transport button, .push button'))
      .filter((part) => part.scrollWidth > part.clientWidth + 1).map((part) => part.textContent));
    assert.deepEqual(cut, []);
    assert.doesNotMatch(await page.textContent('body'), /[−-]0\.0+(?![\d])/);

    await checkAccess(page);
    await prefer(page, 'dark');
    await checkAccess(page);
    assert.deepEqual(pageErrors, []);
    await page.goto('about:blank');
    await close();
  });
}

test('the scene fills the page, no panel covers its free part, and a phone has one row of header', options, async () => {
  for (const [width, height] of [...SIZES, [390, 844], [1440, 900]]) {
    const { page, close } = await open(browser, `${service.url}/#scenario=stiff_wall`, { viewport: { width, height } });
    await waitForState(page, 'connection', 'ready');
    const box = (part) => page.locator(part).boundingBox();
    const [top, scene, free, push, transport] = await Promise.all(['.top', '#scene', '#free', '.push', '.transport'].map(box));
    assert.equal(scene.width, width);
    if (width > 760) assert.equal(Math.round(scene.y + scene.height), height, `${width}: the scene ends at the end of the page`);
    assert.ok(top.height < 56, `${width}: the header is ${top.height} px high`);
    assert.ok(free.height > 0.4 * height, `${width}: ${free.height} px of ${height} are free`);
    assert.ok(push.y >= free.y + free.height && transport.y >= free.y + free.height, `${width}: buttons below the free part`);
    for (const part of ['#setup', '#plots']) {
      const panel = await box(part);
      const isBeside = panel.x + panel.width <= free.x || panel.x >= free.x + free.width || panel.y >= free.y + free.height;
      assert.ok(isBeside, `${width}: ${part} beside the free part`);
      const onTop = await page.evaluate(({ x, y }) => document.elementFromPoint(x + 20, Math.min(y + 20, innerHeight - 1))?.closest('.panel, .dock') !== null, panel);
      assert.ok(onTop, `${width}: ${part} in front of the scene`);
    }
    await close();
  }
});

test('the keyboard reaches every part, and each shows that it has the focus', options, async () => {
  const { page, close } = await open(browser, `${service.url}/#scenario=playground&robot=panda&ghost=task_priority`, { reducedMotion: 'reduce' });
  await waitForState(page, 'connection', 'ready');
  const reached = [];
  for (let i = 0; i < 80; i += 1) {
    await page.keyboard.press('Tab');
    const at = await page.evaluate(() => {
      const { activeElement: part } = document;
      // Panels cover the edges of the scene, so its free part shows the focus; the text of a radio button shows its own.
      const shown = part.id === 'scene' ? document.getElementById('free') : part.type === 'radio' ? part.nextElementSibling : part;
      const { left, right, top, bottom } = shown.getBoundingClientRect();
      const { outlineStyle, outlineWidth } = getComputedStyle(shown);
      const isSeen = outlineStyle === 'solid' && Number.parseFloat(outlineWidth) >= 2 && left >= 0 && right <= innerWidth && bottom > 0 && top < innerHeight;
      return { name: part.id || part.ariaLabel || part.textContent.trim(), isBody: part === document.body, isSeen };
    });
    if (at.isBody) break;
    reached.push(at);
  }
  assert.deepEqual(reached.filter(({ isSeen }) => !isSeen), []);
  for (const part of ['scenario', 'scene', 'go', 'speed', 'loop']) assert.ok(reached.some(({ name }) => name === part), `${part} is not among ${reached.map(({ name }) => name)}`);
  await close();
});

test('the keys of the scene do not cover the bar of comparing', options, async () => {
  const { page, close } = await open(browser, `${service.url}/#scenario=playground&robot=panda&ghost=task_priority`);
  await waitForState(page, 'connection', 'ready');
  await page.focus('#scene');
  assert.equal(await page.isVisible('#scene-keys'), true);
  await page.click('#go');
  await page.waitForSelector('#compare:not([hidden])');
  await page.focus('#scene');
  assert.equal(await page.isVisible('#scene-keys'), false);
  await page.goto('about:blank');
  await close();
});

test('joints keep distinct names, and no number is a negative zero', options, async () => {
  const { page, close } = await open(browser, service.url);
  await waitForState(page, 'connection', 'ready');
  const [ur5e, panda, texts] = await page.evaluate(async () => {
    const { jointLabels } = await import('/dashboard/labels.js');
    const { fixed } = await import('/dashboard/number.js');
    const robot = async (name) => (await (await fetch(`/v1/robots/${name}`)).json()).joints.map((joint) => joint.name);
    return [jointLabels(await robot('ur5e')), jointLabels(await robot('panda')), [fixed(-1e-9, 3), fixed(-0.25, 2), fixed(null, 1)]];
  });
  assert.deepEqual(ur5e, ['shoulder_pan', 'shoulder_lift', 'elbow', 'wrist_1', 'wrist_2', 'wrist_3']);
  assert.equal(panda[0], 'joint1');
  assert.deepEqual(texts, ['0.000', '−0.25', '–']);
  await close();
});

test('the camera contains the arm and its target after every change of scenario and size', options, async () => {
  const { page, close } = await open(browser, service.url);
  await waitForState(page, 'connection', 'ready');
  const outside = await page.evaluate(async () => {
    const { Camera } = await import('/dashboard/geometry.js');
    const { Framing } = await import('/dashboard/framing.js');
    const camera = new Camera();
    const framing = new Framing(camera);
    const found = [];
    for (const { scenario } of (await (await fetch('/v1/scenarios')).json()).scenarios) {
      const body = JSON.stringify({ robot: scenario.controller.robot, joint_position: scenario.start_joint_position });
      const answer = await (await fetch('/v1/kinematics', { method: 'POST', headers: { 'content-type': 'application/json' }, body })).json();
      const joints = answer.links.map(({ pose }) => ({ origin: pose.position, axis: [0, 0, 1], lower: null, upper: null }));
      const world = { arm: { joints, tool: answer.pose }, contacts: [], ghosts: [], goal: null };
      for (const [width, height] of [[360, 250], [530, 350], [900, 480]]) {
        Object.assign(camera, { width, height, free: { left: 40, top: 20, width: width - 60, height: height - 40 } });
        for (let i = 0; i < 40; i += 1) framing.follow(world, scenario.name);
        camera.update();
        for (const point of [[0, 0, 0], ...joints.map(({ origin }) => origin), answer.pose.position]) {
          const { x, y } = camera.project(point);
          if (!(x > 40 && x < width - 20 && y > 20 && y < height - 20)) found.push(`${scenario.name} ${width}: ${x} ${y}`);
        }
      }
    }
    return found;
  });
  assert.deepEqual(outside, []);
  await close();
});
