// Tests of the playground: targets, task order, planes, robots, time and undo.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { after, before, test } from 'node:test';

import { TIMEOUT_MS, cleanUp, endRun, findInScene, launch, number, serve, waitForClock, waitForState, waitForText, withSetup } from './harness.mjs';

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

/** Runs until a simulated time, then ends the run. */
async function runUntil(page, time) {
  await page.click('#go');
  await waitForClock(page, time);
  await endRun(page);
}

const taskNames = (page) => page.locator('#tasks .task-name').allTextContents();

/** Waits until the tool is less, or more, than `distance` from a place, m. */
const waitForTool = (page, place, distance, isFar) => page.waitForFunction(([place, distance, isFar]) => {
  const words = /tool at (\S+), (\S+), (\S+) m/.exec(document.getElementById('scene').ariaLabel) ?? [];
  const away = Math.hypot(...words.slice(1).map((text, i) => Number(text.replace('−', '-')) - place[i]));
  return (away > distance) === isFar;
}, [place, distance, isFar]);

test('a dragged target leads the tool, and undo returns it', options, () => withPage('scenario=playground&robot=panda', async (page) => {
  await page.click('#go');
  // The camera needs a moment to come to rest.
  await waitForClock(page, 1.5);
  const words = /tool at (\S+), (\S+), (\S+) m/.exec(await page.getAttribute('#scene', 'aria-label'));
  const start = words.slice(1).map((text) => Number(text.replace('−', '-')));
  const target = await findInScene(page, 'movable');
  await page.mouse.down();
  await page.mouse.move(target.x - 50, target.y + 25, { steps: 10 });
  await page.mouse.up();
  await page.waitForFunction(() => !document.getElementById('undo').disabled);
  await waitForTool(page, start, 0.03, true);
  await waitForText(page, '#reason', /task “posture” (gives up [\d.]+ rad\/s|stays [\d.]+° from its target)/);
  await page.click('#undo');
  await waitForTool(page, start, 0.005, false);
  await page.waitForFunction(() => document.getElementById('undo').disabled);
}));

test('the keyboard moves the target, and a plane that the user adds holds the tool back', options, () => withPage('scenario=playground&robot=panda', async (page) => {
  await page.click('#go');
  await waitForClock(page, 0.2);
  await page.click('#planes-part summary');
  await page.selectOption('#plane-side', '−z');
  await page.click('#add-plane');
  await waitForState(page, 'phase', 'running');
  await page.focus('#scene');
  for (let i = 0; i < 12; i += 1) await page.keyboard.press('Shift+ArrowDown');
  await waitForText(page, '#reason', /nequality “plane 1” is at its bound; .*task “position” (gives up [\d.]+ m\/s|stays [\d.]+ mm from its target)/);
  await page.click('[aria-label="Remove plane 1"]');
  await waitForText(page, '#reason', /^(?!.*plane 1)/);
  await page.waitForFunction(() => Number.parseFloat(document.getElementById('force-value').textContent) < 3);
}));

test('tasks are reordered by drag and with the keyboard, and the run continues from its posture', options, () => withPage('scenario=playground&robot=panda', async (page) => {
  await page.click('#go');
  await waitForClock(page, 0.5);
  await page.locator('#tasks li').nth(2).dragTo(page.locator('#tasks li').nth(0));
  await waitForText(page, '#tasks', /1\. posture.*2\. position.*3\. orientation/);
  await waitForClock(page, 1);
  await waitForState(page, 'phase', 'running');
  await page.focus('[aria-label="Move “posture” down"]');
  await page.keyboard.press('Enter');
  await waitForText(page, '#tasks', /1\. position.*2\. posture/);
  assert.match(page.url(), /order=0%2C2%2C1/);
  await page.focus('#scene');
  await page.keyboard.press('Control+z');
  await page.keyboard.press('Control+z');
  await waitForText(page, '#tasks', /2\. orientation/);
  assert.match((await taskNames(page)).join(), /1\. position.*2\. orientation.*3\. posture/);
}));

test('scene, numbers and plots show an earlier time together', options, () => withPage('scenario=joint_limits', async (page) => {
  await runUntil(page, 2.5);
  // The last frames are still drawn after the end.
  await new Promise((done) => setTimeout(done, 1000));
  const atEnd = await page.getAttribute('#scene', 'aria-label');
  await page.fill('#time', '1.2');
  await waitForText(page, '#clock', /^1\.(19|20)\d s$/);
  await waitForText(page, '#reason', /^Joint “j6” is at its lower limit.*; task “hold orientation” gives up [\d.]+ rad\/s\.$/);
  assert.notEqual(await page.getAttribute('#scene', 'aria-label'), atEnd);
  assert.equal(await page.isVisible('#viewing'), true);
  await page.focus('[data-plot="pose"] canvas');
  await page.keyboard.press('ArrowRight');
  await waitForText(page, '#reading', /t = 1\.2\d\d s, 1\. raise: [\d.]+ (mm|µm), 2\. hold orientation: [\d.]+°/);
  await page.click('#live');
  await page.waitForFunction((text) => document.getElementById('scene').ariaLabel === text, atEnd);
}));

test('the pointer reads values with units, and changes of method and gains are marked', options, () => withPage('scenario=stiff_wall', async (page) => {
  // At full speed, the run of 5 s may end before a slow browser has made the changes.
  await page.fill('#speed', '-1.5');
  await page.click('#go');
  await waitForClock(page, 0.2);
  await page.selectOption('#method', 'damped_least_squares');
  await page.waitForFunction(() => document.getElementById('caption').textContent === 'Damped least squares');
  await page.click('text=Task gains');
  await page.fill('#gains input >> nth=0', '20');
  await page.keyboard.press('Tab');
  await page.fill('#speed', '0');
  await waitForClock(page, 2);
  await endRun(page);
  const plot = page.locator('[data-plot="force"] canvas');
  await plot.scrollIntoViewIfNeeded();
  const { x: left, y: top, width } = await plot.boundingBox();
  const texts = [];
  for (let x = left + 52; x < left + width; x += 5) {
    await page.mouse.move(x, top + 60);
    texts.push(await page.textContent('#tip'));
  }
  assert.match(texts[5], /t = \d\.\d{3} s.*force x [−\d.]+ N, desired 30\.00 N/);
  assert.ok(texts.some((text) => text.includes('◆ Damped least squares')), 'mark of the method');
  assert.ok(texts.some((text) => text.includes('M_d of “push x”: 20')), 'mark of the gain');
}));

test('scales are logarithmic where values span decades, and linear elsewhere', options, async () => {
  const labels = async (scenario) => {
    let texts = [];
    await withPage(`scenario=${scenario}`, async (page) => {
      await runUntil(page, 1.5);
      const [file] = await Promise.all([page.waitForEvent('download'), page.click('#export-svg')]);
      texts = [...readFileSync(await file.path(), 'utf8').matchAll(/<text[^>]*>([^<]*)</g)].map(([, text]) => text);
    });
    return texts.slice(texts.indexOf('Smallest singular value') + 1, texts.indexOf('Solver path and time')).join(' ');
  };
  // The smallest singular value stays above 0.2 in the first scenario, and falls below 10⁻⁶ in the second.
  assert.match(await labels('stiff_wall'), /^0 0\.1 0\.2 /);
  assert.match(await labels('stiff_wall_singular'), /^10⁻\S+ 10⁻\S+ /);
});

test('the force is shown along the normal of the polished plane, pose errors where there is no force', options, async () => {
  await withPage('scenario=polishing', async (page) => {
    await runUntil(page, 2);
    assert.match(await page.textContent('#force-target'), /along −z of “press”, desired 15\.0 N/);
    assert.ok(Math.abs(await number(page, '#force-value') - 15) < 1);
    assert.match(await page.textContent('[data-plot="force"]'), /measured −z of “press”/);
  });
  for (const scenario of ['task_conflict', 'stiff_wall_limits', 'joint_limits']) {
    await withPage(`scenario=${scenario}`, async (page) => {
      await runUntil(page, 0.7);
      assert.equal(await page.isVisible('[data-plot="pose"]'), true, scenario);
      assert.equal(await page.isVisible('[data-plot="force"]'), scenario === 'stiff_wall_limits', scenario);
      assert.match(await page.textContent('[data-plot="pose"] [data-legend]'), /\d\. /, scenario);
    });
  }
});

test('push and wipe start at once, with the state of the contact at the tool', options, () => withPage('scenario=stiff_wall', async (page) => {
  await page.selectOption('#robot', 'panda');
  await page.click('#press-part summary');
  await page.fill('#press-newtons', 'much');
  await page.click('#press-push');
  assert.equal(await page.getAttribute('#press-newtons', 'aria-invalid'), 'true');
  await waitForState(page, 'phase', 'none');
  await page.fill('#press-newtons', '12');
  await page.fill('#press-speed', '40');
  await page.click('#press-push');
  await waitForText(page, '#tasks', /1\. push.*2\. hold/);
  await page.waitForFunction(() => /“push” in contact: 1[12]\.\d of 12\.0 N/.test(document.getElementById('scene').ariaLabel));
  assert.match(page.url(), /press=push%2C%E2%88%92z%2C12%2Cy%2C0\.04/);
  assert.equal(await page.getAttribute('#press-push', 'aria-pressed'), 'true');
  await page.click('#press-wipe');
  await waitForText(page, '#tasks', /1\. push.*2\. wipe.*3\. hold/);
  await waitForClock(page, 0.5);
  await page.click('#undo');
  await waitForText(page, '#tasks', /1\. push.*2\. hold/);
  const link = page.url();
  await page.goto('about:blank');
  await page.goto(link);
  await waitForText(page, '#tasks', /1\. push.*2\. hold/);
  await page.selectOption('#robot', 'planar_3r');
  await page.waitForFunction(() => document.getElementById('description').textContent.startsWith('planar_3r at rest'));
  assert.doesNotMatch(page.url(), /press=/);
  await page.evaluate(() => { document.getElementById('press-part').open = true; });
  await page.click('#press-push');
  await waitForText(page, '#notice', /the tool of planar_3r cannot move along z/);
}));

test('a push button pushes after another one had the focus, and none stays held', options, () => withPage('scenario=playground&robot=panda', async (page) => {
  await page.click('#go');
  await waitForClock(page, 0.2);
  for (const [button, text] of [['0 0 1', '+z'], ['0 0 -1', '−z']]) {
    const place = await page.locator(`[data-push="${button}"]`).boundingBox();
    await page.mouse.move(place.x + 9, place.y + 9);
    const frame = page.waitForRequest((request) => request.url().endsWith('/control') && request.postData().includes('external_force'));
    await page.mouse.down();
    assert.deepEqual(JSON.parse((await frame).postData()).external_force, button.split(' ').map((part) => 20 * part));
    assert.deepEqual(await page.locator('[data-push].held').allTextContents(), [text]);
    // It repeats the force until it is released.
    await page.waitForRequest((request) => request.url().endsWith('/control') && JSON.parse(request.postData()).external_force?.[2] === 20 * Number(button.split(' ')[2]));
    await page.mouse.up();
    assert.deepEqual(await page.locator('[data-push].held').allTextContents(), []);
  }
}));

test('each state of a contact has its words and a colour of its own', options, () => withPage('scenario=playground&robot=panda', async (page) => {
  const { texts, colours } = await page.evaluate(async () => {
    const { contactSigns, contactColour } = await import('/dashboard/contact_signs.js');
    const { palette } = await import('/dashboard/theme.js');
    const contact = (state, change) => ({ task: 0, row: 0, state, force: 9.96, target_force: 15, ...change });
    const controller = { tasks: [{ name: 'press', axes: ['z'] }, { name: 'two', axes: ['x', 'rx'] }] };
    const states = ['approach', 'contact', 'loss', 'fault'];
    const contacts = [...states.map((state) => contact(state, {})), contact('fault', { fault: 'force_limit' }), contact('contact', { task: 1, row: 1 })];
    return { texts: contactSigns(controller, { contacts }).map(({ text }) => text), colours: states.map((state) => contactColour(state, palette())) };
  });
  assert.deepEqual(texts, [
    '“press” approaches the surface: 10.0 of 15.0 N', '“press” in contact: 10.0 of 15.0 N', '“press” lost the surface, goes back: 10.0 of 15.0 N',
    '“press” gave up and retreated', '“press” gave up and retreated: the force limit', '“two” rx in contact: 10.0 of 15.0 N·m',
  ]);
  assert.equal(new Set(colours).size, 4);
}));

test('every built-in robot can be chosen', options, () => withPage('scenario=stiff_wall', async (page) => {
  const robots = await page.locator('#robot option').allTextContents();
  assert.ok(robots.length >= 4, robots.join());
  for (const robot of robots) {
    await page.selectOption('#robot', robot);
    await page.waitForFunction((name) => document.getElementById('description').textContent.startsWith(`${name} at rest`), robot);
    await page.click('#go');
    await waitForClock(page, 0.1);
    await waitForText(page, '#reason', /[Ee]very task (above )?is achieved/);
    await page.click('#reset');
    await waitForState(page, 'phase', 'none');
    assert.equal(await page.isVisible('#notice'), false, robot);
  }
}));

test('a scenario that is chosen after the playground has its own method, unless the user chose one', options, () => withPage('scenario=playground&robot=panda', async (page) => {
  assert.equal(await page.inputValue('#method'), 'strict_reverse_priority');
  await page.selectOption('#scenario', 'stiff_wall');
  await waitForText(page, '#description', /wall/);
  assert.equal(await page.inputValue('#method'), 'reverse_priority');
  await page.selectOption('#method', 'damped_least_squares');
  await page.selectOption('#scenario', 'joint_limits');
  await waitForText(page, '#description', /^(?!.*wall)/);
  assert.equal(await page.inputValue('#method'), 'damped_least_squares');
}));

test('the smallest singular value of the playground is that of the tool', options, () => withPage('scenario=playground&robot=panda', async (page) => {
  const differences = await page.evaluate(async () => {
    const { Kinematics } = await import('/dashboard/kinematics.js');
    const { playground } = await import('/dashboard/playground.js');
    const ask = async (path, body) => (await fetch(path, body && { method: 'POST', headers: { 'content-type': 'application/json' }, body: JSON.stringify(body) })).json();
    const found = {};
    for (const name of ['panda', 'ur5e', 'sawyer']) {
      const robot = await ask(`/v1/robots/${name}`);
      const kinematics = await Kinematics.learn(robot);
      const { controller } = await playground(robot);
      for (const shift of [0.2, 0.7, 1.1]) {
        const joint_position = robot.joints.map(({ position_limit: range }, i) => ((range?.[0] ?? -1) + (range?.[1] ?? 1)) / 2 + shift * Math.sin(i + shift));
        const { singular_values } = await ask('/v1/kinematics', { robot: name, joint_position });
        found[`${name} ${shift}`] = Math.abs(kinematics.smallestSingularValue(controller, joint_position) - singular_values.at(-1));
      }
    }
    return found;
  });
  for (const [posture, difference] of Object.entries(differences)) assert.ok(difference < 1e-8, `${posture}: ${difference}`);
  const shown = await number(page, '#readouts div:nth-child(2) dd');
  assert.ok(shown > 0.05 && shown < 0.5, `σ min ${shown}`);
}));

test('joints come to rest when the target of the playground is out of reach', options, () => withPage('scenario=playground&robot=panda', async (page) => {
  const speeds = await page.evaluate(async () => {
    const { playground } = await import('/dashboard/playground.js');
    const ask = async (path, body) => (await fetch(path, body && { method: 'POST', headers: { 'content-type': 'application/json' }, body: JSON.stringify(body) })).json();
    const scenario = await playground(await ask('/v1/robots/panda'));
    Object.assign(scenario, { duration_s: 6 });
    scenario.controller.tasks[0].law.target_displacement = { kind: 'constant', value: [1.5, 0.8, 0.2] };
    const { id } = await ask('/v1/simulations', { scenario });
    for (let state = ''; state !== 'finished';) {
      ({ state } = await ask(`/v1/simulations/${id}`));
      if (state === 'failed') throw new Error('the run failed');
      await new Promise((done) => setTimeout(done, 200));
    }
    const text = await (await fetch(`/v1/simulations/${id}/trace`, { headers: { accept: 'text/csv' } })).text();
    const [head, ...rows] = text.trim().split('\n').map((line) => line.split(','));
    const columns = head.flatMap((name, i) => (name.startsWith('velocity_') ? [i] : []));
    return { stated: Object.keys(scenario.controller), head: head.join(), rows: rows.slice(-250).map((row) => columns.map((i) => Number(row[i]))) };
  });
  // Without `limits`, `drive` and `damping` the service uses its defaults, as on a real arm.
  assert.deepEqual(speeds.stated, ['robot', 'period_s', 'method', 'solver', 'tasks']);
  assert.equal(speeds.rows[0].length, 7, speeds.head);
  const reversals = speeds.rows.slice(1).filter((row, i) => row.some((value, joint) => Math.abs(value) > 0.2 && value * speeds.rows[i][joint] < 0));
  assert.ok(reversals.length < 5, `${reversals.length} of 250 periods reverse a joint at more than 0.2 rad/s`);
}));

const URDF = `<robot name="lift">
  <link name="base"><visual><geometry><box size="0.3 0.3 0.1"/></geometry></visual></link>
  <link name="arm"><visual><origin xyz="0 0 0.2"/><geometry><cylinder radius="0.05" length="0.4"/></geometry></visual></link>
  <link name="hand"><visual><geometry><mesh filename="package://lift/meshes/hand.stl" scale="0.001 0.001 0.001"/></geometry></visual></link>
  <link name="finger"/><link name="camera"/>
  <joint name="turn" type="revolute"><parent link="base"/><child link="arm"/><origin xyz="0 0 0.1"/><axis xyz="0 1 0"/><limit lower="-2" upper="2" velocity="2" effort="9"/></joint>
  <joint name="slide" type="prismatic"><parent link="arm"/><child link="hand"/><origin xyz="0 0 0.4"/><axis xyz="0 0 1"/><limit lower="0" upper="0.3" velocity="1" effort="9"/></joint>
  <joint name="tip" type="fixed"><parent link="hand"/><child link="finger"/><origin xyz="0 0 0.2"/></joint>
  <joint name="eye" type="fixed"><parent link="base"/><child link="camera"/></joint>
</robot>`;

/** A binary STL file of a tetrahedron, mm. */
function stl() {
  const corners = [[-60, -60, 0], [60, -60, 0], [0, 80, 0], [0, 0, 200]];
  const faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
  const file = Buffer.alloc(84 + 50 * faces.length);
  file.writeUInt32LE(faces.length, 80);
  faces.forEach((face, i) => face.forEach((corner, k) => corners[corner].forEach((value, axis) =>
    file.writeFloatLE(value, 84 + 50 * i + 12 + 12 * k + 4 * axis))));
  return file;
}

/** Drops files onto the page. */
function drop(page, files) {
  return page.evaluate((list) => {
    const data = new DataTransfer();
    for (const { name, bytes } of list) data.items.add(new File([new Uint8Array(bytes)], name));
    dispatchEvent(new DragEvent('drop', { dataTransfer: data, bubbles: true, cancelable: true }));
  }, files.map(([name, bytes]) => ({ name, bytes: [...bytes] })));
}

/** Two arms of two joints. */
const TWINS = `<robot name="twins"><link name="base"/>${['left', 'right'].map((side) => `
  <link name="${side}_upper"/><link name="${side}_hand"/>
  <joint name="${side}_shoulder" type="revolute"><parent link="base"/><child link="${side}_upper"/><axis xyz="0 1 0"/><limit lower="-2" upper="2" velocity="0"/></joint>
  <joint name="${side}_elbow" type="revolute"><parent link="${side}_upper"/><child link="${side}_hand"/><origin xyz="0 0 0.4"/><axis xyz="0 1 0"/><limit lower="-2" upper="2" velocity="2"/></joint>`).join('')}
</robot>`;

test('a URDF file that is dropped onto the page with its mesh becomes a robot', options, () => withPage('scenario=stiff_wall', async (page) => {
  await drop(page, [['lift.urdf', Buffer.from(URDF)], ['hand.stl', stl()]]);
  await waitForText(page, '#notice', /Robot my_lift.*2 joints and 3 shapes\. Chain from base to hand \(tool name\)\./);
  assert.equal(await page.inputValue('#robot'), 'my_lift');
  await page.click('#go');
  await waitForClock(page, 0.2);
  await waitForText(page, '#reason', /\w/);
  await endRun(page);
  await drop(page, [['broken.urdf', Buffer.from('<html/>')]]);
  await waitForText(page, '#notice', /not a URDF/);
  // A refusal offers the tips of the arms. The file beside the URDF file states what it lacks.
  await drop(page, [['twins.urdf', Buffer.from(TWINS)]]);
  await page.waitForSelector('#tip-dialog[open]');
  await waitForText(page, '#tip-detail', /the robot has 2 arms/);
  assert.deepEqual(await page.locator('#tip-link option').allTextContents(), ['left_hand', 'right_hand']);
  await page.selectOption('#tip-link', 'right_hand');
  await page.click('#tip-dialog [value="ok"]');
  await waitForText(page, '#notice', /velocity limit 0 is not positive; state it in `limits`: \{"right_shoulder"/);
  const limits = JSON.stringify({ limits: { right_shoulder: { velocity: 1.5 } }, joint_names: { right_elbow: 'elbow' } });
  await drop(page, [['twins.urdf', Buffer.from(TWINS)], ['twins.json', Buffer.from(limits)]]);
  await page.waitForSelector('#tip-dialog[open]');
  await page.selectOption('#tip-link', 'right_hand');
  await page.click('#tip-dialog [value="ok"]');
  await waitForText(page, '#notice', /2 joints.*Chain from base to right_hand \(request\)\. Left out: left_shoulder \(other branch\), left_elbow/);
  await drop(page, [['photo.png', Buffer.from('png')]]);
  await waitForText(page, '#notice', /No URDF file/);
}));
