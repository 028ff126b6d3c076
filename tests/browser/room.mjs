// Tests of the overlay: shapes of the robot, obstacles and distances, in a session, in the setup and in a run.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { after, before, test } from 'node:test';

import { TIMEOUT_MS, cleanUp, findInScene, launch, open, serve, waitForClock, waitForState, waitForText } from './harness.mjs';

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
const example = (name) => JSON.parse(readFileSync(`api/examples/${name}.json`, 'utf8'));

/** Sends a request to the service. */
async function call(path, body) {
  const init = body && { method: 'POST', headers: { 'content-type': 'application/json' }, body: JSON.stringify(body) };
  const answer = await (await fetch(service.url + path, init)).json();
  assert.equal(answer.detail, undefined);
  return answer;
}

/** Opens the page at a fragment; afterwards it must have had no errors. */
async function withPage(fragment, body) {
  const { page, pageErrors, close } = await open(browser, `${service.url}/#${fragment}`);
  try {
    await waitForState(page, 'connection', 'ready');
    await body(page);
    assert.deepEqual(pageErrors, []);
  } finally {
    await page.goto('about:blank');
    await close();
  }
}

/** Waits until the description of the scene matches. */
const waitForScene = (page, pattern) => page.waitForFunction((source) => new RegExp(source).test(document.getElementById('scene').ariaLabel), pattern.source, { timeout: TIMEOUT_MS });

/** Returns how many pixels of the scene have about one colour. */
const pixels = (page, colour) => page.evaluate((colour) => {
  const canvas = document.getElementById('scene');
  const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
  let count = 0;
  for (let i = 0; i < data.length; i += 4) count += Number(colour.every((part, k) => Math.abs(data[i + k] - part) < 6));
  return count;
}, colour);

/** Colours of the lines between pairs, light theme. */
const NEAR = [138, 90, 0];
const BELOW = [192, 16, 48];

test('a session shows the distances of each answer, and a ball where its state says', options, () => withPage('', async (page) => {
  const { id } = await call('/v1/controllers', example('controller_room'));
  const { state } = example('step_room');
  let sequence = 0;
  const step = (position) => {
    sequence += 1;
    const obstacles = [{ name: 'ball', position }];
    return call(`/v1/controllers/${id}/step`, { ...state, sequence, time_s: sequence * 0.004, obstacles });
  };
  await page.click('text=Live session');
  await waitForState(page, 'phase', 'watching');
  await step([0.2, 0.6, 0.3]);
  await waitForScene(page, /nearest panda_link5 – panda_link3: 26 mm\./);
  await waitForText(page, '#scene-legend', /shapes of the links ?obstacles ?panda_link5 – panda_link3: 26 mm$/);
  await page.waitForTimeout(500);
  const [near, below] = [await pixels(page, NEAR), await pixels(page, BELOW)];
  assert.ok(near > 10 && below === 0, `${near} and ${below} pixels`);
  // The ball is nearer to the end of the arm than the 20 mm to keep.
  await step([0.364, 0, 0.5]);
  await waitForScene(page, /nearest panda_link\d – ball: [−\d.]+ mm, too near/);
  await page.waitForTimeout(300);
  assert.ok(await pixels(page, BELOW) > 10);
  // The switch hides everything, and the page remembers it.
  assert.equal(await page.getAttribute('#shapes', 'aria-pressed'), 'true');
  await page.click('#shapes');
  await waitForScene(page, /^(?!.*nearest)/);
  await page.reload();
  await waitForState(page, 'connection', 'ready');
  await page.click('text=Live session');
  await waitForState(page, 'phase', 'watching');
  await step([0.2, 0.6, 0.3]);
  await page.waitForFunction(() => document.getElementById('shapes').ariaPressed === 'false');
  assert.doesNotMatch(await page.getAttribute('#scene', 'aria-label'), /nearest/);
  await page.click('#shapes');
  await waitForScene(page, /nearest panda_link5/);
}));

test('the page computes the same frames of the links as the service', options, () => withPage('', async (page) => {
  await call('/v1/robots', example('robot_two_arms'));
  const worst = await page.evaluate(async () => {
    const { LinkPoses } = await import('/dashboard/link_poses.js');
    const ask = async (path, body) => (await fetch(path, body && { method: 'POST', headers: { 'content-type': 'application/json' }, body: JSON.stringify(body) })).json();
    let difference = 0;
    for (const name of ['panda', 'ur5e', 'sawyer', 'planar_3r', 'two-arms']) {
      const robot = await ask(`/v1/robots/${name}`);
      const poses = await LinkPoses.learn(robot, robot.links);
      if (poses.unknown.length > 0) return `${name}: ${poses.unknown}`;
      const joint_position = robot.joints.map((joint, i) => 0.3 * Math.sin(1 + i) + ((joint.position_limit?.[0] ?? -1) + (joint.position_limit?.[1] ?? 1)) / 2);
      const frames = poses.at(joint_position);
      for (const link of robot.links) {
        const { pose } = await ask('/v1/kinematics', { robot: name, joint_position, link });
        const { position, orientation } = frames.get(link);
        const turn = ['w', 'x', 'y', 'z'].reduce((sum, part) => sum + orientation[part] * pose.orientation[part], 0);
        difference = Math.max(difference, Math.abs(Math.abs(turn) - 1), ...position.map((value, k) => Math.abs(value - pose.position[k])));
      }
    }
    return difference;
  });
  assert.ok(worst < 1e-9, String(worst));
}));

/** A joint that copies another one: the page cannot compute the frame of the link behind it. */
const MIMIC = `<robot name="copy"><link name="base"/><link name="upper"/><link name="slide"/><link name="copied"/>
  <joint name="turn" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 0 1"/><limit lower="-2" upper="2" velocity="1" effort="1"/></joint>
  <joint name="push" type="prismatic"><parent link="upper"/><child link="slide"/><origin xyz="0.3 0 0" rpy="0.3 0.2 0.1"/><axis xyz="1 1 0"/><limit lower="0" upper="0.4" velocity="1" effort="1"/></joint>
  <joint name="copy" type="revolute"><parent link="slide"/><child link="copied"/><origin xyz="0.1 0 0.2"/><axis xyz="0 1 0"/><mimic joint="turn" multiplier="2"/><limit lower="-4" upper="4" velocity="4" effort="1"/></joint>
</robot>`;

test('a link whose place is not known is named and not drawn', options, () => withPage('', async (page) => {
  const shape_list = ['upper', 'slide', 'copied'].map((link) => ({ link, sphere: { radius: 0.05 } }));
  await call('/v1/robots', { name: 'copy', urdf: MIMIC, tips: [{ name: 'copied', link: 'copied' }], shape_list });
  await page.reload();
  await waitForState(page, 'connection', 'ready');
  await page.selectOption('#robot', 'copy');
  await page.click('#shapes');
  await waitForText(page, '#scene-legend', /shapes of the links.*not drawn: copied/);
}));

/** The place that the form shows for an obstacle. */
const placeOf = async (page, i) => (await page.inputValue(`#obstacles input >> nth=${i}`)).split(' ').map(Number);

test('obstacles are added, typed, dragged and removed, and the arm keeps clear of them', options, () => withPage('scenario=playground&robot=panda', async (page) => {
  // Without obstacles the controller keeps clear of nothing; the switch shows the shapes all the same.
  assert.equal(await page.getAttribute('#shapes', 'aria-pressed'), 'false');
  await page.click('#obstacles-part summary');
  await page.click('#add-sphere');
  await waitForScene(page, /nearest panda_link\d – panda_link\d: \d+ mm/);
  assert.equal(await page.getAttribute('#shapes', 'aria-pressed'), 'true');
  await waitForText(page, '#obstacles', /sphere 1/);
  const start = await placeOf(page, 0);
  await page.waitForTimeout(800);
  const found = await findInScene(page, 'liftable');
  await page.mouse.down();
  await page.mouse.move(found.x - 30, found.y + 40, { steps: 8 });
  await page.mouse.up();
  await page.waitForFunction((text) => document.querySelector('#obstacles input').value !== text, start.join(' '));
  const dragged = await placeOf(page, 0);
  assert.ok(dragged[2] < start[2] - 0.02, `${start} to ${dragged}`);
  await page.click('#undo');
  await page.waitForFunction((text) => document.querySelector('#obstacles input').value === text, start.join(' '));

  // A run goes on from its posture when an obstacle is added. Its target is inside the sphere.
  await page.click('#go');
  await waitForClock(page, 0.2);
  const words = /tool at (\S+), (\S+), (\S+) m/.exec(await page.getAttribute('#scene', 'aria-label'));
  const tool = words.slice(1).map((text) => Number(text.replace('−', '-')));
  await page.fill('#obstacles input', [tool[0] + 0.17, tool[1], tool[2]].map((value) => value.toFixed(3)).join(' '));
  await page.keyboard.press('Tab');
  // The field drops zeros at the end: 0.510 is shown as 0.51.
  await page.waitForFunction((x) => Number(document.querySelector('#obstacles input').value.split(' ')[0]) === x, Number((tool[0] + 0.17).toFixed(3)));
  await waitForState(page, 'phase', 'running');
  await page.focus('#scene');
  for (let i = 0; i < 12; i += 1) await page.keyboard.press('Shift+ArrowRight');
  await waitForText(page, '#reason', /“panda_link\d” keeps clear of “sphere 1”.*(gives up [\d.]+ m\/s|stays [\d.]+ mm from its target)/);
  await waitForScene(page, /nearest panda_link\d – sphere 1: 2\d mm/);
  assert.doesNotMatch(await page.getAttribute('#scene', 'aria-label'), /too near/);
  await page.fill('#obstacles input', 'here');
  await page.keyboard.press('Tab');
  assert.equal(await page.getAttribute('#obstacles input', 'aria-invalid'), 'true');
  await page.click('[aria-label="Remove sphere 1"]');
  await page.waitForFunction(() => document.querySelectorAll('#obstacles li').length === 0);
  await waitForScene(page, /^(?!.*nearest)/);
}));

test('a run shows the distances of its answers, and a ball that moves where it is', options, () => withPage('', async (page) => {
  await page.route('**/v1/scenarios', async (route) => {
    const list = await (await route.fetch()).json();
    const { scenario } = list.scenarios.find((entry) => entry.scenario.name === 'stiff_wall');
    const ball = { name: 'ball', sphere: { center: [-0.145, 0.1, 0.69], radius: 0.05 }, moves: true };
    const displacement = { kind: 'ramp', start: [0, 0, 0], end: [0, -0.5, 0], start_time_s: 0, duration_s: 4 };
    Object.assign(scenario.controller, { robot: 'sawyer', collisions: { obstacles: [ball] } });
    scenario.obstacle_motions = [{ name: 'ball', displacement }];
    await route.fulfill({ json: list });
  });
  await page.goto('about:blank');
  await page.goto(`${service.url}/#scenario=stiff_wall`);
  await waitForState(page, 'connection', 'ready');
  await page.click('#go');
  await waitForClock(page, 0.1);
  await waitForScene(page, /nearest \S+ – right_l4: \d+ mm/);
  // It was half a metre away from all links.
  await waitForScene(page, /nearest \S+ – ball: \d+ mm/);
}));
