// Tests of the past and of what is shared: earlier targets and planes, replay, films, links, commands; and of the sentence.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { after, before, test } from 'node:test';

import { TIMEOUT_MS, cleanUp, endRun, launch, number, open, serve, waitForClock, waitForState, waitForText, withSetup } from './harness.mjs';

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

const clock = async (page) => number(page, '#clock');
const clipboard = { permissions: ['clipboard-read', 'clipboard-write'] };

test('an earlier time has its own target, tasks and numbers', options, () => withPage('scenario=playground&robot=panda', async (page) => {
  await page.click('#go');
  await waitForClock(page, 0.8);
  await page.focus('#scene');
  for (let i = 0; i < 25; i += 1) await page.keyboard.press('Shift+ArrowUp');
  await page.locator('#tasks li').nth(2).dragTo(page.locator('#tasks li').nth(0));
  await waitForText(page, '#tasks', /1\. posture.*2\. position/);
  const changed = await clock(page);
  await waitForClock(page, changed + 0.6);
  await endRun(page);
  await waitForText(page, '#force-target', /posture|position/);
  const late = await page.textContent('#readouts div:first-child dd');
  assert.ok(Number.parseFloat(late) > 20, `the posture holds the tool ${late} from its target`);
  await page.fill('#time', '0.4');
  await waitForText(page, '#clock', /^0\.[34]\d\d s$/);
  await waitForText(page, '#readouts', /To the target ?0(\.\d+)? (mm|µm)/);
  assert.ok(await number(page, '#force-value') < 0.1);
  await waitForText(page, '[data-plot="pose"] [data-legend]', /1\. position/);
}));

test('a history knows the scenario of each of its parts', options, () => withPage('scenario=stiff_wall', async (page) => {
  const names = await page.evaluate(async () => {
    const { History } = await import('/dashboard/history.js');
    const history = new History();
    history.begin({ name: 'first' }, null, []);
    history.last = { time_s: 2, position: [0, 0, 0], orientation: [1, 0, 0, 0] };
    history.begin({ name: 'second' }, null, [1, 0]);
    return [0, 1.9, 2.1, null].map((time) => history.segmentAt(time).scenario.name);
  });
  assert.deepEqual(names, ['first', 'first', 'second', 'second']);
}));

/** Makes in the page a sample with the tool at a place, and a run control with a scenario and its changes; the functions are in `globalThis.made`. */
const makeRunControl = (page) => page.evaluate(async () => {
  const { History } = await import('/dashboard/history.js');
  const { RunControl } = await import('/dashboard/run_control.js');
  const { defaults } = await import('/dashboard/setup.js');
  const sample = (time_s, position, change) => ({
    time_s, position, orientation: [1, 0, 0, 0], force: [0, 0, 0], target_force: [null, null, null], wall_distance_m: null, residual_norms: [],
    task_residuals: [], at_lower: [], at_upper: [], active_inequalities: [], joint_position: [], joint_velocity: [], ...change,
  });
  const runControl = async (name, change) => {
    const scenario = await (await fetch(`/v1/scenarios/${name}`)).json();
    const setup = { ...defaults(scenario), ...change };
    const history = new History();
    return Object.assign(new RunControl(() => {}, () => {}), { scenario, setup, preview: null, run: { history, simulation: { method: setup.method } } });
  };
  globalThis.made = { sample, runControl };
});

test('a wall is drawn where it is, in the past of a continued run and while it moves', options, () => withPage('scenario=stiff_wall', async (page) => {
  await makeRunControl(page);
  const { walls, moving } = await page.evaluate(async () => {
    const { continued } = await import('/dashboard/continuation.js');
    const { world } = await import('/dashboard/world.js');
    const { sample, runControl } = globalThis.made;
    const start = [0.4, 0, 0.6];
    const of = async (name, change) => {
      const control = await runControl(name, change);
      const { applied, history } = control;
      history.begin(applied, null, []);
      history.push(sample(0, start));
      history.push(sample(2, [0.45, 0, 0.6]));
      history.begin(continued(applied, { joints: [] }, { position: start }, { ...history.last, joint_position: [] }), null, []);
      history.push(sample(1, [0.45, 0, 0.6], { wall_distance_m: 0.001 }));
      return [1, 2.5, null].map((cursor) => world(Object.assign(control, { cursor })).contacts[0].at[0]);
    };
    const plane = { name: 'wall 1', kind: 'wall', side: '+z', offset: 0.601 };
    return { walls: await of('stiff_wall', {}), moving: await of('moving_wall', { planes: [plane] }) };
  });
  const near = (given, expected) => given.forEach((place, i) => assert.ok(Math.abs(place - expected[i]) < 1e-9, `${given}, not ${expected}`));
  near(walls, [walls[0], walls[0], walls[0]]);
  // A sine of 1 cm and 2 rad/s, 2 cm from the start.
  near(moving, [1, 2.5, 3].map((time) => 0.42 + 0.01 * Math.sin(2 * time)));
}));

test('the past shows the bounds of a velocity only in their period, and a joint at a limit as the answer says', options, () => withPage('scenario=stiff_wall', async (page) => {
  await makeRunControl(page);
  const { bounds, marks } = await page.evaluate(async () => {
    const { velocities } = await import('/dashboard/bars.js');
    const { SvgSurface } = await import('/dashboard/svg.js');
    const { printPalette } = await import('/dashboard/theme.js');
    const { shownArm } = await import('/dashboard/view.js');
    const { sample, runControl } = globalThis.made;
    const control = await runControl('stiff_wall', {});
    const { history } = control;
    const joint = { origin: [0, 0, 0], axis: [0, 0, 1], lower: -0.1, upper: 0.1 };
    history.push(sample(0.1, [0, 0, 0]));
    history.push(sample(0.2, [0, 0, 0]));
    history.pushArm(0.2, { joints: [joint], tool: { position: [0, 0, 0], orientation: { w: 1, x: 0, y: 0, z: 0 } } });
    const bounds = [0.1, 0.15, 0.2].map((cursor) => shownArm(Object.assign(control, { cursor })).joints[0].upper);
    const colours = printPalette();
    const marks = [[], [0]].map((at_upper) => {
      const surface = new SvgSurface();
      const view = { robot: { joints: [{ name: 'a', velocity_limit: 1 }] }, labels: ['a'], velocity: [0.5], arm: { joints: [joint] }, sample: sample(0, [0, 0, 0], { at_upper }) };
      velocities(surface, 300, 60, view, colours);
      return surface.text.includes(colours.alarm);
    });
    return { bounds, marks };
  });
  assert.deepEqual(bounds, [null, null, 0.1]);
  assert.deepEqual(marks, [false, true]);
}));

test('the postures of a run are those of their samples, also while it receives commands', options, () => withPage('scenario=joint_limits', async (page) => {
  const postures = await page.evaluate(async () => {
    const { History } = await import('/dashboard/history.js');
    const { Run } = await import('/dashboard/run.js');
    const scenario = await (await fetch('/v1/scenarios/joint_limits')).json();
    const history = new History();
    const ended = new Promise((resolve) => {
      Run.start({ scenario: { ...scenario, duration_s: 0.6 }, interactive: { speed: 1, paused: false } }, async (run) => {
        // The service then sends the same posture again, with later samples.
        await new Promise((wake) => { setTimeout(wake, 25); });
        await run.control({ paused: false }).catch(() => {});
      }, resolve, history);
    });
    await (await ended).delete();
    const places = new Map(history.samples.map(({ time_s, position }) => [time_s, position]));
    return history.arms.map(({ time, arm }) => ({ place: arm.tool.position, expected: places.get(time) }));
  });
  assert.ok(postures.length > 3, `${postures.length} postures`);
  for (const { place, expected } of postures) {
    assert.ok(expected, 'a posture without a sample');
    assert.ok(place.every((part, i) => Math.abs(part - expected[i]) < 1e-6), `${place}, not ${expected}`);
  }
}));

test('a posture that comes with later samples keeps its time', options, () => withPage('scenario=stiff_wall', async (page) => {
  // Numbers of finished periods, and periods of the samples. The third frame repeats the posture of the second one.
  const frames = [[0, [0, 1]], [10, [5, 9]], [10, [10, 12]], [20, [16, 19, 21]], [20, []]];
  await makeRunControl(page);
  const times = await page.evaluate(async (given) => {
    const { History } = await import('/dashboard/history.js');
    const { Run } = await import('/dashboard/run.js');
    const period = 0.001;
    const events = given.map(([done, periods]) => {
      const samples = periods.map((k) => globalThis.made.sample(k * period, [0, 0, 0]));
      // As the service computes it: after the tenth period later than its next sample, by rounding.
      const time_s = done > 0 ? (done - 1) * period + period : 0;
      return `event: frame\ndata: ${JSON.stringify({ done, time_s, samples, arm: {} })}\n\n`;
    });
    const history = new History();
    const { fetch } = globalThis;
    globalThis.fetch = async (path, init) => (path === '/v1/simulations/made/live' ? new Response(events.join('')) : fetch(path, init));
    await new Promise((resolve) => { new Run({ id: 'made' }, () => {}, resolve, history); });
    globalThis.fetch = fetch;
    return history.arms.map(({ time }) => time / period);
  }, frames);
  assert.deepEqual(times.map(Math.round), [9, 19]);
}));

test('a joint without limits is drawn on its circle, and is not at a limit', options, () => withPage('scenario=stiff_wall', async (page) => {
  const [limited, free] = await page.evaluate(async () => {
    const { positions } = await import('/dashboard/bars.js');
    const { SvgSurface } = await import('/dashboard/svg.js');
    const { printPalette } = await import('/dashboard/theme.js');
    const colours = printPalette();
    const of = (position_limit, q) => {
      const surface = new SvgSurface();
      positions(surface, 300, 60, { robot: { joints: [{ name: 'a', unit: 'rad', position_limit }] }, labels: ['a'], position: [q] }, colours);
      const { text } = surface;
      return { isNear: text.includes(colours.alarm), hasRange: text.includes(colours.allowed), circle: /d="(M[^"]*a[^"]*)"/.exec(text)?.[1] };
    };
    return [[of([-3.2, 3.2], 3.1)], [3.1, 3.1 + 2 * Math.PI, 3.1 - 4 * Math.PI].map((q) => of(null, q))];
  });
  assert.deepEqual([limited[0].isNear, limited[0].hasRange], [true, true]);
  for (const { isNear, hasRange, circle } of free) assert.deepEqual([isNear, hasRange, circle], [false, false, free[0].circle]);
}));

test('the ticks of a time on the clock of Unix have different labels', options, () => withPage('scenario=stiff_wall', async (page) => {
  const labels = await page.evaluate(async () => {
    const { tickLabel, ticks } = await import('/dashboard/plot.js');
    return [[1761234547.25, 1761234567.25, 5], [0, 0.31, 3], [-1e4, 1e4, 2]].map(([low, high, max]) => ticks({ low, high }, max).map((tick) => tickLabel(tick, false)).join(' '));
  });
  assert.deepEqual(labels, ['1761234550 1761234555 1761234560 1761234565', '0 0.2', '−10000 0 10000']);
}));

test('the past is replayed, once or round and round', options, () => withPage('scenario=joint_limits', async (page) => {
  assert.equal(await page.isDisabled('#replay'), true);
  await page.click('#go');
  await waitForState(page, 'phase', 'finished');
  // The page draws some time after a click: only `Stop` tells that it replays.
  const startsReplay = () => Promise.all([page.waitForSelector('#replay:text("Stop")'), page.click('#replay')]);
  await page.fill('#time', '3.2');
  await startsReplay();
  await page.waitForFunction(() => Number.parseFloat(document.getElementById('clock').textContent) > 3.4);
  await page.waitForFunction(() => document.getElementById('live').hidden && document.getElementById('replay').textContent === 'Replay');
  await page.click('#loop');
  await page.waitForSelector('#loop[aria-pressed="true"]');
  await page.fill('#time', '3.6');
  await startsReplay();
  await page.waitForFunction(() => Number.parseFloat(document.getElementById('clock').textContent) < 1.5);
  await page.click('#replay');
  assert.equal(await page.isVisible('#viewing'), true);
}));

test('the scene is recorded as a WebM film', options, () => withPage('scenario=stiff_wall', async (page) => {
  await page.click('#record');
  assert.equal(await page.getAttribute('#record', 'aria-pressed'), 'true');
  await page.click('#go');
  await waitForClock(page, 1.5);
  const [film] = await Promise.all([page.waitForEvent('download'), page.click('#record')]);
  assert.match(film.suggestedFilename(), /^stiff_wall-.*\.webm$/);
  const data = readFileSync(await film.path());
  assert.equal(data.subarray(0, 4).toString('hex'), '1a45dfa3');
  assert.ok(data.length > 10_000, `${data.length} bytes`);
}));

test('a link restores planes, moved targets and the view', options, () => withPage('scenario=playground&robot=panda', async (page) => {
  await page.click('#planes-part summary');
  await page.selectOption('#plane-side', '−z');
  await page.click('#add-plane');
  await page.focus('#scene');
  for (let i = 0; i < 5; i += 1) await page.keyboard.press('Shift+ArrowUp');
  for (let i = 0; i < 4; i += 1) await page.keyboard.press('ArrowLeft');
  await page.waitForTimeout(800);
  const linkOf = async (from) => {
    await from.click('#copy-link');
    await from.waitForFunction(() => document.getElementById('share-note').textContent.startsWith('Link'));
    return from.evaluate(() => navigator.clipboard.readText());
  };
  const link = await linkOf(page);
  assert.match(link, /state=.*plane.*targets.*view=/);
  const other = await open(browser, link, clipboard);
  await waitForState(other.page, 'connection', 'ready');
  await other.page.waitForTimeout(800);
  assert.match(await other.page.textContent('#planes'), /plane 1/);
  assert.equal(await linkOf(other.page), link);
  assert.deepEqual(other.pageErrors, []);
  await other.close();
}, clipboard));

test('a link with a broken state opens without it', options, async () => {
  const broken = encodeURIComponent('{"planes":[{"name":3}],"targets":{"position":{"position":[1,2]}},"obstacles":[{}]}');
  for (const [state, isDamaged] of [[broken, true], ['%7B', true], ['null', true], ['%5B%5D', false]]) {
    await withPage(`scenario=playground&robot=panda&state=${state}&view=1,2,x`, async (page) => {
      assert.equal(await page.locator('#planes li').count(), 0);
      assert.equal(await page.isVisible('#notice'), isDamaged, state);
    });
  }
});

test('the controller is copied as commands for ROS 2', options, () => withPage('scenario=playground&robot=panda', async (page) => {
  await page.click('#copy-ros2');
  await page.waitForFunction(() => document.getElementById('share-note').textContent.startsWith('ROS 2'));
  const text = await page.evaluate(() => navigator.clipboard.readText());
  const [, body] = /<<'END'\n(.*)\nEND\n/s.exec(text);
  assert.equal(JSON.parse(body).robot, 'panda');
  assert.match(text, /python3 -m revprio_ros\.controller --ros-args -p controller:=controller\.json -p url:=http/);
}, clipboard));

test('a session whose answers say why shows their sentences', options, () => withPage('scenario=stiff_wall', async (page) => {
  const post = async (path, body) => (await fetch(service.url + path, { method: 'POST', headers: { 'content-type': 'application/json' }, body: JSON.stringify(body) })).json();
  const scenario = await (await fetch(`${service.url}/v1/scenarios/joint_limits`)).json();
  const { id } = await post('/v1/controllers', { ...scenario.controller, why: true });
  await page.click('text=Live session');
  await waitForState(page, 'phase', 'watching');
  const answer = await post(`/v1/controllers/${id}/step`, { sequence: 0, time_s: 0, joint_position: scenario.start_joint_position });
  assert.ok(answer.why.length > 0, JSON.stringify(answer));
  const sentence = answer.why.join('; ').replace(/`([^`]*)`/g, '“$1”');
  await page.waitForFunction((text) => document.getElementById('reason').textContent === text, `${sentence[0].toUpperCase()}${sentence.slice(1)}.`);
}));

test('the sentence names each joint once, calls redundancy no conflict, and is not absurd at rest', options, () => withPage('scenario=playground&robot=panda', async (page) => {
  const reasons = await page.evaluate(async () => {
    const { reason } = await import('/dashboard/reason.js');
    const { History } = await import('/dashboard/history.js');
    const robot = await (await fetch('/v1/robots/panda')).json();
    const labels = robot.joints.map((_, i) => `joint${i + 1}`);
    const position = { name: 'position', axes: ['x', 'y', 'z'], law: { kind: 'pose', gain: 4 } };
    const posture = { name: 'posture', law: { kind: 'posture', gain: 1 } };
    const q = [0, 0, 0, -1.5, 0, 1.8, 0];
    const of = (tasks, residuals, change, before = []) => {
      const sample = {
        time_s: 1, position: [0.4, 0, 0.6], joint_position: q, joint_velocity: q.map(() => 0.3), at_lower: [], at_upper: [], active_inequalities: [],
        residual_norms: residuals.map((rows) => Math.hypot(...rows)), task_residuals: residuals, ...change,
      };
      const history = new History();
      [...before.map((why, i) => ({ ...sample, time_s: 0.9 + 0.01 * i, why })), sample].forEach((each, i) => {
        history.columns.time[i] = each.time_s;
        history.columns.linear0[i] = 0.822;
        history.columns.angular0[i] = NaN;
        history.samples[i] = each;
        history.length = i + 1;
      });
      const plane = { kind: 'plane', name: 'plane 1', normal: [0, 0, -1], offset_m: -0.3 };
      return reason({ history, sample, controller: { tasks, inequalities: [plane] }, robot, labels, order: [], threshold: 0.15, sigma: 0.3 });
    };
    return {
      ordinary: of([position, posture], [[0, 0, 0], [0.5, 0, 0, 1, 0, 0, 0]], { why: ['every task above is achieved', 'task `posture` gives up 1.1 rad/s, since it has the motion that is left'] }),
      twice: of([position, posture], [[0.1, 0, 0], [0, 0, 0, 0, 0, 0, 0]], { why: ['joint `joint4` is at its jerk limit', 'task `position` gives up 0.10 m/s'] }, [
        ['joint `joint4` brakes before its upper limit, at 1.2 rad/s', 'task `position` gives up 0.30 m/s'], ['the tasks are in conflict', 'no limit is active; every task is achieved'],
      ]),
      held: of([position], [[0, 0, 0]], { why: ['no limit is active; every task is achieved'] }, [['joint `joint4` is at its jerk limit', 'task `position` gives up 0.30 m/s']]),
      rest: of([position, posture], [[7.3, 0, 0], [0, 0, 0, 0, 0, 0, 0]], { joint_velocity: q.map(() => 0), why: ['the tasks are in conflict', 'task `position` gives up 7.3 m/s'] }),
      plane: of([position, posture], [[0.2, 0, 0], [0, 0, 0, 0, 0, 0, 0]], { joint_velocity: q.map(() => 0), position: [0.4, 0, 0.302], why: ['no limit is active; every task is achieved'] }),
      conflict: of([position, posture], [[0.2, 0, 0], [0.5, 0, 0, 1, 0, 0, 0]], { why: ['the tasks are in conflict', 'task `position` gives up 0.20 m/s'] }),
      silent: of([position], [[0.2, 0, 0]], {}),
    };
  });
  assert.equal(reasons.ordinary.kind, 'ok');
  assert.match(reasons.ordinary.text, /^Every task above is achieved; task “posture” gives up 1\.1 rad\/s, since it has the motion that is left\.$/);
  assert.equal(reasons.twice.text.match(/joint4/gi).length, 1, reasons.twice.text);
  assert.equal(reasons.twice.text, 'Joint “joint4” is at its jerk limit; task “position” gives up 0.10 m/s.');
  assert.equal(reasons.held.text, 'Joint “joint4” is at its jerk limit; every task is achieved.');
  assert.equal(reasons.rest.text, 'The arm rests; task “position” stays 822 mm from its target.');
  assert.doesNotMatch(reasons.rest.text, /m\/s/);
  assert.equal(reasons.plane.text, 'Inequality “plane 1” is at its bound; task “position” stays 822 mm from its target.');
  assert.equal(reasons.conflict.kind, 'limited');
  assert.equal(reasons.conflict.text, 'The tasks are in conflict; task “position” gives up 0.20 m/s.');
  assert.equal(reasons.silent.text, 'Task “position” gives up 0.2 m/s; the controller says no more without “why”.');
}));
