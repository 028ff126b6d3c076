// Tests of changes to the setup that the service refuses, that overtake each other, or that it has forgotten.

import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';

import { TIMEOUT_MS, cleanUp, launch, open, serve, waitForClock, waitForState, waitForText, withSetup } from './harness.mjs';

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
function withPage(fragment, body) {
  return withSetup(browser, `${service.url}/#${fragment}`, async (page) => {
    await page.evaluate(() => document.querySelectorAll('details').forEach((part) => { part.open = true; }));
    follow(page);
    await body(page);
  });
}

const count = (page, items) => page.locator(items).count();

/** Path of the latest run of a page. */
const runs = new WeakMap();

/** Notes the runs of a page. */
function follow(page) {
  page.on('request', (request) => {
    const run = /\/v1\/simulations\/[^/]+(?=\/live)/.exec(request.url());
    if (run) runs.set(page, run[0]);
  });
}

/** Returns the controller of the run from its latest control cycle. */
const controllerOf = (page) => page.evaluate(async (run) => (await (await fetch(`${run}/cycle`)).json()).controller, runs.get(page));

test('a change that the service refuses leaves the run and the lists as they were', options, () => withPage('scenario=playground&robot=panda&solver=closed_form', async (page) => {
  await page.click('#go');
  await waitForClock(page, 1);
  await page.click('#add-sphere');
  await waitForText(page, '#notice', /collisions/);
  await waitForState(page, 'phase', 'running');
  await waitForClock(page, 0);
  const time = await page.evaluate(() => Number.parseFloat(document.getElementById('clock').textContent));
  assert.ok(time > 1, `the run goes on from ${time} s`);
  assert.equal(await count(page, '#obstacles li'), 0);
  assert.equal(await page.isDisabled('#undo'), true);
  // The hidden sphere would forbid the solver now.
  await page.selectOption('#method', 'damped_least_squares');
  await waitForClock(page, time + 0.3);
  assert.equal((await controllerOf(page)).collisions, undefined);
}));

test('a solver that the service refuses is not chosen', options, () => withPage('scenario=playground&robot=panda', async (page) => {
  await page.click('#add-sphere');
  await page.waitForSelector('#obstacles li');
  await page.click('#go');
  await waitForClock(page, 0.1);
  await page.selectOption('#solver', 'closed_form');
  await waitForText(page, '#notice', /collisions/);
  await page.waitForFunction(() => document.getElementById('solver').value === 'auto');
  await waitForState(page, 'phase', 'running');
}));

test('changes that follow each other faster than the service answers are all made', options, () => withPage('scenario=playground&robot=panda', async (page) => {
  await page.click('#go');
  await waitForClock(page, 0.1);
  await page.route('**/v1/simulations*', async (route) => {
    await new Promise((resolve) => setTimeout(resolve, 300));
    await route.continue();
  });
  for (let k = 0; k < 3; k += 1) await page.click('#add-wall');
  await page.waitForFunction(() => document.querySelectorAll('#planes li').length === 3);
  const names = await page.locator('#planes label').allTextContents();
  // The rows stay until the first removal is answered; both clicks are on what the user sees.
  await page.evaluate(() => {
    const [first, second] = document.querySelectorAll('#planes button');
    first.click();
    second.click();
  });
  await page.waitForFunction(() => document.querySelectorAll('#planes li').length === 1);
  assert.deepEqual(await page.locator('#planes label').allTextContents(), [names[2]]);
}));

test('undo returns a gain that was set before the run', options, () => withPage('scenario=human_push', async (page) => {
  const field = page.locator('#gains input').nth(2);
  const before = await field.inputValue();
  await field.fill('900');
  await field.blur();
  await page.click('#go');
  await waitForClock(page, 0.1);
  const stiffness = async () => JSON.stringify((await controllerOf(page)).tasks.map(({ law }) => law?.stiffness));
  assert.match(await stiffness(), /900/);
  await page.click('#undo');
  await page.waitForFunction((text) => document.querySelectorAll('#gains input')[2].value === text, before);
  await waitForClock(page, 0.3);
  assert.doesNotMatch(await stiffness(), /900/);
}));

test('causes are counted once while their numbers change, and times are those of the page', options, () => withPage('scenario=stiff_wall', async (page) => {
  const text = await page.evaluate(async () => {
    const { reason } = await import('/dashboard/reason.js');
    const sample = (k) => ({
      time_s: k / 100, joint_velocity: [1], residual_norms: [], contacts: [],
      why: [`the smallest singular value is 0.0${60 + k}`, `inequality \`plane ${1 + (k % 2)}\` is at its bound`],
    });
    const samples = Array.from({ length: 10 }, (_, k) => sample(k));
    const history = { samples, columns: { time: samples.map(({ time_s }) => time_s) }, indexAt: () => 9 };
    return reason({ history, sample: samples[9], controller: { tasks: [] } }).text;
  });
  assert.match(text, /singular value is 0\.069/);
  assert.doesNotMatch(text, /0\.068|more limits/);
  for (const plane of ['plane 1', 'plane 2']) assert.match(text, new RegExp(plane));

  const why = await page.evaluate(async () => {
    const { History } = await import('/dashboard/history.js');
    const history = new History();
    history.offset = 9.5;
    history.push({
      time_s: 0.4, position: [0, 0, 0], orientation: [1, 0, 0, 0], force: [0, 0, 0], target_force: [], at_lower: [31], at_upper: [],
      residual_norms: [], joint_position: [0], why: ['task `a` has made no progress since t = 0.3640 s'],
    });
    return [history.last.why[0], history.columns.lower[0] >>> 0];
  });
  assert.deepEqual(why, ['task `a` has made no progress since t = 9.8640 s', 2 ** 31]);
}));

test('a continued run leaves round surfaces, holes, edges and doors where they are', options, () => withPage('scenario=stiff_wall', async (page) => {
  const contacts = await page.evaluate(async () => {
    const { continued } = await import('/dashboard/continuation.js');
    const given = [
      { kind: 'plane', normal: [0, 0, 1], offset_m: 0.02, hole: { center: [0.0028, 0, 0], clearance_m: 0.001 } },
      { kind: 'plane', normal: [0, 0, 1], offset_m: 0.02, edge: { direction: [1, 0, 0], distance_m: 0.01 } },
      { kind: 'cylinder', axis: 'y', normal: [0, 0, 1], radius_m: 0.2, offset_m: 0.02 },
      { kind: 'sphere', normal: [0, 0, 1], radius_m: 0.2, offset_m: 0.02 },
      { kind: 'door', axis: 'z', normal: [0, -1, 0], radius_m: 0.3 },
    ];
    const scenario = { duration_s: 5, controller: { tasks: [] }, contacts: given };
    const start = { position: [0, 0, 0], orientation: { w: 1, x: 0, y: 0, z: 0 } };
    return continued(scenario, { joints: [] }, start, { time_s: 1, position: [0.03, 0.04, -0.01], joint_position: [] }).contacts;
  });
  const [hole, edge, cylinder, sphere, door] = contacts;
  const near = (given, expected) => given.forEach((part, i) => assert.ok(Math.abs(part - expected[i]) < 1e-9, `${given}, not ${expected}`));
  near([...hole.hole.center, hole.offset_m], [0.0028 - 0.03, -0.04, 0.01, 0.01]);
  near([edge.edge.distance_m, edge.offset_m], [-0.02, 0.01]);
  const middle = ({ normal, offset_m: offset = 0, radius_m: radius }) => normal.map((part) => -part * (offset + radius));
  near(middle(cylinder), [-0.03, 0, -0.21]);
  near(middle(sphere), [-0.03, -0.04, -0.21]);
  near(middle(door), [-0.03, 0.26, 0]);
  assert.equal(door.offset_m, undefined);
}));

test('a continued run leaves moving walls in both directions where they are', options, () => withPage('scenario=stiff_wall', async (page) => {
  const walls = await page.evaluate(async () => {
    const { continued } = await import('/dashboard/continuation.js');
    const { valueAt } = await import('/dashboard/profile.js');
    const points = [{ time_s: 0, value: 0.01 }, { time_s: 3, value: [0.02] }];
    const motions = [
      { kind: 'constant', value: 0.01 },
      { kind: 'sine', offset: [0.01], amplitude: 0.005, angular_frequency_rad_s: 2, phase_rad: 0.3 },
      { kind: 'ramp', start: 0.01, end: [0.02], start_time_s: 0.5, duration_s: 4 },
      { kind: 'steps', points },
      { kind: 'waypoints', points },
    ];
    const given = [-0.05, 0.05].flatMap((offset_m) => motions.map((motion) => ({ kind: 'wall', axis: 'x', offset_m, motion })));
    const scenario = { duration_s: 5, controller: { tasks: [] }, contacts: given };
    const start = { position: [0, 0, 0], orientation: { w: 1, x: 0, y: 0, z: 0 } };
    const { contacts } = continued(scenario, { joints: [] }, start, { time_s: 1, position: [0.03, 0, 0], joint_position: [] });
    const away = ({ offset_m, motion }, time) => offset_m + valueAt(motion, 1, time)[0];
    return contacts.map((plane, i) => ({
      normal: plane.normal[0],
      before: [1, 2.5, 4.5].map((time) => away(given[i], time)),
      after: [1, 2.5, 4.5].map((time) => 0.03 - plane.normal[0] * away(plane, time - 1)),
    }));
  });
  assert.deepEqual(walls.map(({ normal }) => normal), [1, 1, 1, 1, 1, -1, -1, -1, -1, -1]);
  for (const { before, after } of walls) before.forEach((place, i) => assert.ok(Math.abs(after[i] - place) < 1e-9, `${after}, not ${before}`));
  assert.ok(Math.abs(walls[0].after[0] + 0.04) < 1e-9, 'a wall at −0.05 m that has moved by 0.01 m');
}));

test('a continued run goes on with its programs and moving obstacles', options, () => withPage('scenario=stiff_wall', async (page) => {
  const [inserted, searching, door] = await page.evaluate(async () => {
    const { continued } = await import('/dashboard/continuation.js');
    const start = { position: [0.5, 0, 0.4], orientation: { w: 1, x: 0, y: 0, z: 0 } };
    const of = (program, change) => {
      const hole = { center: [0.002, 0, 0], clearance_m: 0.0005, depth_m: 0.02 };
      const scenario = {
        duration_s: 5, target_programs: [{ task: 'search', ...program }], contacts: [{ kind: 'plane', normal: [0, 0, 1], offset_m: 0.003, hole }],
        controller: { tasks: [{ name: 'search', axes: ['x', 'y'], law: { kind: 'pose', gain: 3 } }] },
        obstacle_motions: [{ name: 'ball', displacement: { kind: 'ramp', start: [0, 0, 0], end: [0, 1, 0], duration_s: 4 } }],
      };
      return continued(scenario, { joints: [] }, start, { time_s: 3, joint_position: [], orientation: [1, 0, 0, 0], target_force: [null, null, null], ...change });
    };
    const spiral = { kind: 'spiral_search', pitch_m: 0.001, speed: 0.01, inserted_m: 0.003 };
    const force = { kind: 'force_along_motion', force: -15, start_direction: [1, 0, 0], memory_m: 0.005 };
    return [
      of(spiral, { position: [0.502, 0, 0.38] }), of(spiral, { position: [0.501, 0, 0.397] }),
      of(force, { position: [0.5, 0, 0.4], target_force: [-9, -12, 0] }),
    ];
  });
  const place = ({ controller }) => controller.tasks[0].law.target_pose.position;
  assert.deepEqual([inserted.target_programs, place(inserted)], [[], [0.502, 0, 0.38]], 'the peg stays in its hole');
  assert.deepEqual([searching.target_programs.map(({ kind }) => kind), place(searching)], [['spiral_search'], [0.5, 0, 0.4]]);
  assert.deepEqual(door.target_programs[0].start_direction.map((part) => Number(part.toFixed(9)) + 0), [0.6, 0.8, 0]);
  assert.equal(door.obstacle_motions[0].displacement.start_time_s, -3);
}));

test('a change while a run starts is in the run', options, () => withPage('scenario=playground&robot=panda', async (page) => {
  let answer;
  const asked = new Promise((resolve) => { answer = resolve; });
  await page.route('**/v1/simulations', async (route) => {
    await asked;
    await route.continue();
  });
  await page.click('#go');
  await waitForState(page, 'phase', 'starting');
  await page.selectOption('#solver', 'qp');
  await page.focus('#scene');
  await page.keyboard.press('Shift+ArrowUp');
  const sent = ['"solver":"qp"', '"targets":'].map((part) => page.waitForResponse((response) => {
    const request = response.request();
    return request.url().endsWith('/control') && request.postData().includes(part);
  }));
  answer();
  for (const response of await Promise.all(sent)) assert.equal(response.status(), 200);
}));

test('undo of a moved target gives it the motion of its law again', options, () => withPage('scenario=playground&robot=panda&motion=eight', async (page) => {
  await waitForState(page, 'phase', 'running');
  await page.focus('#scene');
  await page.keyboard.press('Shift+ArrowUp');
  await page.waitForFunction(() => !document.getElementById('undo').disabled);
  await page.click('#undo');
  await page.waitForFunction(() => document.getElementById('undo').disabled);
  // The middle of the figure is at y = 0.15 m, and it is 0.22 m wide to both sides.
  for (const side of [1, -1, 1]) {
    await page.waitForFunction((side) => {
      const [, y] = /tool at \S+, (\S+), \S+ m/.exec(document.getElementById('scene').ariaLabel) ?? [];
      return side * (Number(y?.replace('−', '-')) - 0.15) > 0.1;
    }, side);
  }
}));

test('a refresh of the sessions that is answered late does not leave the simulation', options, () => withPage('scenario=stiff_wall', async (page) => {
  const { controller } = await (await fetch(`${service.url}/v1/scenarios/stiff_wall`)).json();
  const headers = { 'content-type': 'application/json' };
  const { id } = await (await fetch(`${service.url}/v1/controllers`, { method: 'POST', headers, body: JSON.stringify(controller) })).json();
  let answer;
  const asked = new Promise((resolve) => { answer = resolve; });
  await page.route('**/v1/controllers', async (route) => {
    await asked;
    await route.continue();
  });
  const paths = [];
  page.on('request', (request) => paths.push(new URL(request.url()).pathname));
  await Promise.all([page.waitForRequest('**/v1/controllers'), page.click('text=Live session')]);
  await page.click('text=Simulation');
  await page.click('#go');
  await waitForState(page, 'phase', 'running');
  await Promise.all([page.waitForResponse('**/v1/controllers'), answer()]);
  // A later answer: the page has read the one before.
  await page.evaluate(() => fetch('/v1/robots'));
  assert.deepEqual(paths.filter((path) => path.includes(id)), []);
  await waitForState(page, 'phase', 'running', 'finished');
  await fetch(`${service.url}/v1/controllers/${id}`, { method: 'DELETE' });
}));

test('a watched session has the force on the environment, and no distance that its samples do not tell', options, () => withPage('scenario=stiff_wall', async (page) => {
  const [force, unknown, errors, first] = await page.evaluate(async () => {
    const { Watch } = await import('/dashboard/watch.js');
    const law = { kind: 'pose', gain: 2 };
    const upright = { w: 1, x: 0, y: 0, z: 0 };
    const tasks = [
      { name: 'hand', axes: ['x', 'y', 'z'], law },
      { name: 'right', link: 'right', axes: ['x', 'y', 'z'], law: { ...law, target_pose: { position: [0.5, 0, 0], orientation: upright } } },
      { name: 'led', axes: ['x', 'y', 'z'], law: { ...law, target_pose: { position: [0.5, 0, 0], orientation: upright } } },
      { name: 'fixed', axes: ['x', 'y', 'z'], law: { ...law, target_pose: { position: [0.5, 0, 0.1], orientation: upright } } },
    ];
    const controller = { robot: 'a', period_s: 0.01, wrench_frame: 'tool', wrench_convention: 'on_tool', tasks };
    const watch = new Watch({ id: 's', controller }, { name: 'a', joints: [] }, null);
    const arm = { tool: { position: [0.5, 0, 0], orientation: { w: 0, x: 1, y: 0, z: 0 } }, links: [] };
    const answers = tasks.map(({ name }) => ({ achieved: [0, 0, 0], requested: [0, 0, 0], residual_norm: 0, ...(name === 'led' && { target_state: 'following' }) }));
    const step = {
      state: { time_s: 600, joint_position: [], wrench: { force: [0, 0, -15], torque: [0, 0, 0] } },
      answer: {
        tasks: answers, joint_velocity: [], active_limits: [], violated_limits: [], elapsed_us: 1,
        singularity: { smallest_singular_value: 1 }, solver: { path: 'active_set', status: 'optimal', kkt_residual: 0 },
      },
      arm,
    };
    watch.addStep(step);
    const { columns } = watch.history;
    return [watch.sample(step).force, watch.sample({ ...step, arm: undefined }).force.map(Number.isNaN), [0, 1, 2, 3].map((k) => columns[`linear${k}`][0]), watch.history.first];
  });
  // The tool looks down: what pulls it along its z presses on the table below.
  assert.deepEqual(force.map(Math.round), [0, 0, -15]);
  assert.deepEqual(unknown, [true, true, true]);
  assert.deepEqual(errors.slice(0, 3).map(Number.isNaN), [true, true, true]);
  assert.ok(Math.abs(errors[3] - 0.1) < 1e-6, `${errors}`);
  assert.equal(first, 600);
}));

test('a link cannot put code into the copied program, and says which part is damaged', options, () => withPage('scenario=stiff_wall', async (page) => {
  const [program, damaged] = await page.evaluate(async () => {
    const { asPython } = await import('/dashboard/snippets.js');
    const { isDamaged } = await import('/dashboard/shared_state.js');
    const state = (obstacle) => JSON.stringify({ obstacles: [obstacle] });
    const texts = [state({ name: 'a', capsule: {} }), state({ name: 'a', sphere: { radius: 0.1 } }), '{', '', null];
    return [asPython({ controller: { name: "a'''+print('run')+r'''" } }), texts.map(isDamaged)];
  });
  assert.equal(program.match(/'/g).length, 6, program);
  assert.match(program, /\\u0027\\u0027\\u0027/);
  assert.deepEqual(damaged, [true, false, true, false, false]);
}));

test('a service that is busy when the page opens is asked again', options, async () => {
  const { page, pageErrors, close } = await open(browser, 'about:blank');
  let refused = 0;
  await page.route('**/v1/robots', (route) => {
    refused += 1;
    return refused > 1 ? route.continue() : route.fulfill({ status: 503, headers: { 'retry-after': '1' }, contentType: 'application/problem+json', body: '{"title":"Busy","detail":"busy","status":503}' });
  });
  await page.goto(`${service.url}/#scenario=playground&robot=panda`);
  await page.waitForFunction(() => document.getElementById('robot').options.length > 5);
  await waitForState(page, 'connection', 'ready');
  assert.deepEqual(pageErrors, []);
  await close();
});

test('without a token, or with a character that cannot be sent, the dialog comes back', options, async () => {
  const guarded = await serve(0, 's3cret-token');
  const { page, pageErrors, close } = await open(browser, guarded.url);
  await page.waitForSelector('#token-dialog[open]');
  await page.keyboard.press('Escape');
  await page.click('text=Give the token');
  await page.waitForSelector('#token-dialog[open]');
  await page.fill('#token', 's3cret–token');
  await page.keyboard.press('Enter');
  await page.click('text=Give the token');
  await page.waitForSelector('#token-dialog[open]');
  await page.fill('#token', 's3cret-token');
  await page.keyboard.press('Enter');
  await waitForState(page, 'connection', 'ready');
  assert.deepEqual(pageErrors, []);
  await close();
  await guarded.stop();
});

const CRANK = `<robot name="crank"><link name="base"/><link name="arm"/><link name="tool"/>
  <joint name="turn" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/><limit lower="-3" upper="3" velocity="1.5" effort="1"/></joint>
  <joint name="hand" type="fixed"><parent link="arm"/><child link="tool"/><origin xyz="0.5 0 0"/></joint></robot>`;

test('a changed robot replaces the one before only if the service accepts it', options, () => withPage('scenario=stiff_wall', async (page) => {
  const take = (text) => page.setInputFiles('#urdf', { name: 'crank.urdf', mimeType: 'text/xml', buffer: Buffer.from(text) });
  const limits = async () => (await (await fetch(`${service.url}/v1/robots/my_crank`)).json()).joints?.map(({ velocity_limit: limit }) => limit);
  await take(CRANK);
  await page.waitForFunction(() => document.getElementById('robot').value === 'my_crank');
  await take(CRANK.replace('xyz="0 0 1"', 'xyz="0 0 0"'));
  await page.waitForSelector('.notice:not(.info)');
  assert.deepEqual(await limits(), [1.5]);
  await take(CRANK.replace('</robot>', '<link name="other"/><joint name="side" type="fixed"><parent link="arm"/><child link="other"/></joint></robot>'));
  await page.waitForSelector('#tip-dialog[open]');
  await page.keyboard.press('Escape');
  await page.waitForSelector('#tip-dialog:not([open])', { state: 'attached' });
  assert.deepEqual(await limits(), [1.5]);
  const replaced = page.waitForResponse((response) => response.url().endsWith('/v1/robots') && response.status() === 201);
  await take(CRANK.replace('velocity="1.5"', 'velocity="2.5"'));
  await replaced;
  assert.deepEqual(await limits(), [2.5]);
}));

test('a robot that was dropped onto the page is there again when the service was started again', options, async () => {
  const first = await serve();
  const { page, pageErrors, close } = await open(browser, `${first.url}/#scenario=stiff_wall`);
  follow(page);
  await waitForState(page, 'connection', 'ready');
  await page.setInputFiles('#urdf', { name: 'crank.urdf', mimeType: 'text/xml', buffer: Buffer.from(CRANK) });
  await page.waitForFunction(() => document.getElementById('robot').value === 'my_crank');
  await first.stop('SIGKILL');
  await waitForState(page, 'connection', 'unreachable');
  const second = await serve(first.port);
  await waitForState(page, 'connection', 'ready');
  await page.waitForFunction(() => [...document.getElementById('robot').options].some(({ value }) => value === 'my_crank'));
  await page.click('#go');
  await waitForClock(page, 0.05);
  assert.equal((await controllerOf(page)).robot, 'my_crank');
  assert.deepEqual(pageErrors, []);
  await close();
  await second.stop();
});
