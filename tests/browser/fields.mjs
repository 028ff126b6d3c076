// Tests of the fields of the setup, of the presets that press, and of messages.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { after, before, test } from 'node:test';

import { TIMEOUT_MS, cleanUp, launch, serve, waitForClock, waitForState, waitForText, withSetup } from './harness.mjs';

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

/** Opens a setup; `body` gets the page. */
function withPage(fragment, body, context = {}) {
  return withSetup(browser, `${service.url}/#${fragment}`, body, context);
}

/** Types a text into a field and leaves it. */
async function type(page, field, text) {
  await page.fill(field, text);
  await page.dispatchEvent(field, 'change');
}

test('a number out of its range is refused beside its field and does not reach the service', options, () => withPage('scenario=stiff_wall', async (page) => {
  await page.evaluate(() => document.querySelectorAll('details').forEach((part) => { part.open = true; }));
  await page.click('#add-plane');
  await page.waitForSelector('#planes input');
  // A tenth of real time: the run goes on until all fields are filled in, on a slow machine too.
  await page.fill('#speed', '-1');
  await page.click('#go');
  await waitForClock(page, 0.05);
  const sent = [];
  page.on('request', (request) => { if (request.method() === 'POST') sent.push(`${request.url()} ${request.postData()}`); });
  const cases = [
    ['#gains input >> nth=0', '0', '30', /^Give a number from 1e−6 to 1e9\.$/],
    ['#gains input >> nth=1', '−5', '90', /^Give a number from 0 to 1e9\.$/],
    ['#gains input >> nth=1', '1e10', '90', /^Give a number from 0 to 1e9\.$/],
    ['#gains input >> nth=1', '90 90', '90', /^Give a number from 0 to 1e9\.$/],
    ['#contacts input >> nth=0', 'stiff', '1e5', /^Give a number from 0 to 1e9\.$/],
    ['#lag', '-1', '10', /^Give a number from 0 to 1e9\.$/],
    ['#planes input', '101', '0.4', /^Give a number from −100 to 100\.$/],
  ];
  for (const [field, wrong, , message] of cases) {
    await type(page, field, wrong);
    assert.equal(await page.getAttribute(field, 'aria-invalid'), 'true', `${field} ${wrong}`);
    const note = await page.getAttribute(field, 'aria-describedby');
    assert.match(await page.textContent(`[id="${note}"]`), message);
  }
  await waitForClock(page, 0.3);
  assert.deepEqual(sent, []);
  const accepted = page.waitForRequest((request) => request.url().endsWith('/control'));
  for (const [field, , right] of cases) {
    await type(page, field, right);
    assert.notEqual(await page.getAttribute(field, 'aria-invalid'), 'true', `${field} ${right}`);
  }
  await page.waitForFunction(() => document.querySelector('.refusal') === null);
  await accepted;
  assert.equal(await page.isVisible('#notice'), false);
}));

test('the presets that press refuse numbers beside their fields, and say how fast the tool approaches', options, () => withPage('scenario=playground&robot=panda', async (page) => {
  await page.click('#press-part summary');
  for (const [newtons, speed, refused] of [['0', '10', 'newtons'], ['', '10', 'newtons'], ['-3', '', 'newtons'], ['15', '0', 'speed'], ['15', 'fast', 'speed'], ['1001', '', 'newtons'], ['15', '1001', 'speed']]) {
    await page.fill('#press-newtons', newtons);
    await page.fill('#press-speed', speed);
    await page.click('#press-push');
    await waitForText(page, '#press-part', /Give a number above 0 up to 1000\./);
    assert.deepEqual(await page.locator('#press-part [aria-invalid="true"]').evaluateAll((all) => all.map(({ id }) => id)), [`press-${refused}`]);
    await waitForState(page, 'phase', 'none');
  }
  await page.fill('#press-speed', '');
  await page.click('#press-push');
  await waitForText(page, '#description', /approaches at/);
  const [, speed, time] = /approaches at ([\d.]+) mm\/s.* about ([\d.]+) s/.exec(await page.textContent('#description'));
  assert.ok(Math.abs(speed * time - 10) < 0.6, `${speed} mm/s for ${time} s`);
  // The simulated tool is in contact when the description says.
  const touched = await page.waitForFunction(() => /“push” in contact/.test(document.getElementById('scene').ariaLabel) && Number.parseFloat(document.getElementById('clock').textContent));
  const at = await touched.jsonValue();
  assert.ok(at > 0.9 * time && at < 1.3 * time + 0.5, `in contact at ${at} s, said ${time} s`);
  await page.fill('#press-speed', '20');
  await page.click('#press-push');
  await waitForText(page, '#description', /It approaches at 20 mm\/s and needs about 0\.5 s to the wall\.$/);
}));

/** Arguments of `revprio push` and `revprio wipe`, and the same as the page has them. */
const PRESSES = [
  ['panda', { kind: 'push', side: '−z', newtons: 15, along: 'y', speed: null }],
  ['panda', { kind: 'push', side: '+x', newtons: 42.5, along: 'y', speed: 0.01 }],
  ['panda', { kind: 'wipe', side: '−z', newtons: 5, along: 'x', speed: 0.02 }],
  ['ur5e', { kind: 'wipe', side: '+y', newtons: 30, along: 'z', speed: null }],
  ['so101', { kind: 'push', side: '−z', newtons: 2, along: 'y', speed: null }],
  ['planar_3r', { kind: 'push', side: '−y', newtons: 8, along: 'x', speed: null }, ['x', 'rz']],
  ['planar_3r', { kind: 'wipe', side: '+x', newtons: 8, along: 'y', speed: 0.005 }, ['rz']],
];

test('push and wipe have the tasks of the program', options, () => withPage('scenario=stiff_wall', async (page) => {
  for (const [robot, press, hold] of PRESSES) {
    const made = await page.evaluate(async ([name, press]) => {
      const { playground } = await import('/dashboard/playground.js');
      return playground(await (await fetch(`/v1/robots/${name}`)).json(), press);
    }, [robot, press]);
    const { kind, side, newtons, along, speed } = press;
    const { period_s: period, drive, tasks } = made.controller;
    const line = [
      kind, '--robot', robot, '--axis', side[1], '--newtons', String(side[0] === '−' ? -newtons : newtons),
      ...(kind === 'wipe' ? ['--along', along] : []), '--period-s', String(period), '--lag-s', String(drive.lag_s),
      '--delay-periods', String(drive.delay_periods), ...(speed ? ['--approach-speed', String(speed)] : []), ...(hold ? ['--hold', hold.join()] : []),
    ];
    const wanted = JSON.parse(execFileSync(process.env.REVPRIO, line, { encoding: 'utf8' }));
    assert.deepEqual(tasks.map(explicit), wanted.tasks, line.join(' '));
    assert.deepEqual([made.controller.robot, drive], [robot, wanted.drive]);
  }
}));

/** Returns a task with the defaults that the program writes. */
function explicit(task) {
  const law = task.law.kind === 'pose' ? { target_pose: 'initial', ...task.law } : task.law;
  return { frame: 'base', ...task, law };
}

test('a target is drawn next to the tool along directions that its task leaves free', options, () => withPage('scenario=stiff_wall', async (page) => {
  const { place, far } = await page.evaluate(async () => {
    const { distanceTo, handle } = await import('/dashboard/target.js');
    const pose = (position) => ({ position, orientation: { w: 1, x: 0, y: 0, z: 0 } });
    const last = { time_s: 1, position: [0.11, 0.2, 0.9], orientation: [1, 0, 0, 0] };
    const history = { last, length: 0, measures: null, segmentAt: () => null };
    const controller = { tasks: [{ name: 'push', axes: ['z'], law: { kind: 'contact' } }, { name: 'hold', axes: ['x', 'y'], law: { kind: 'pose' } }] };
    const goal = handle({ watch: null, history, cursor: null, dragged: null, preview: { tool: pose([0.1, 0.2, 0.3]) }, applied: { controller } });
    return { place: goal.pose.position, far: distanceTo(goal, last.position) };
  });
  assert.deepEqual(place.map((part) => Number(part.toFixed(9))), [0.1, 0.2, 0.9]);
  assert.ok(Math.abs(far - 0.01) < 1e-9, `${far} m`);
}));

test('several messages stay, one of each matter, and each closes by itself', options, () => withPage('scenario=stiff_wall', async (page) => {
  await page.evaluate(async () => {
    const { notify, showError } = await import('/dashboard/notices.js');
    notify('First', 'an old one');
    notify('First', 'a newer one');
    showError(new Error('one error'));
    showError(new Error('another error'));
    showError(new Error('one error'));
    notify('Told', 'in passing', { info: true });
  });
  const shown = () => page.locator('#notice p').allTextContents();
  assert.deepEqual(await shown(), ['in passing', 'one error', 'another error', 'a newer one']);
  const boxes = await page.locator('.notice').evaluateAll((all) => all.map((one) => one.getBoundingClientRect().toJSON()));
  boxes.slice(1).forEach(({ top }, i) => assert.ok(top >= boxes[i].bottom, `message ${i + 1} below the one before`));
  await page.click('[aria-label="Close the message “First”"]');
  assert.deepEqual(await shown(), ['in passing', 'one error', 'another error']);
  await page.waitForFunction(() => document.querySelectorAll('.notice').length === 2, null, { timeout: 12_000 });
  assert.deepEqual(await shown(), ['one error', 'another error']);
  await page.evaluate(async () => {
    const { notify } = await import('/dashboard/notices.js');
    for (let i = 0; i < 9; i += 1) notify(`Number ${i}`, 'text');
  });
  assert.deepEqual(await page.locator('.notice strong').allTextContents(), ['Number 8', 'Number 7', 'Number 6', 'Number 5']);
}));
