// Tests of the dashboard in a real browser.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { readFileSync, readdirSync } from 'node:fs';
import { after, before, test } from 'node:test';

import { TIMEOUT_MS, cleanUp, drop, endRun, launch, number, open, serve, findInScene, waitForState, waitForText } from './harness.mjs';

let browser;
before(async () => { browser = await launch(); }, { timeout: TIMEOUT_MS });
after(async () => {
  cleanUp();
  await browser?.close();
});

const options = { timeout: 2 * TIMEOUT_MS };

test('the program contains every file of the page', { ...options, skip: Boolean(process.env.REVPRIO_PAGE) }, async () => {
  const service = await serve();
  const files = readdirSync('src/dashboard/page').filter((name) => !name.endsWith('.d.ts'));
  assert.ok(files.length > 60);
  for (const name of files) {
    const text = await (await fetch(`${service.url}/dashboard/${name}`)).text();
    assert.equal(text, readFileSync(`src/dashboard/page/${name}`, 'utf8'), name);
  }
  await service.stop();
});

test('a scenario runs, its force settles at 30 N, and a change of method causes no jump', options, async () => {
  const service = await serve();
  const { page, pageErrors, close } = await open(browser, `${service.url}/#scenario=stiff_wall`);
  await waitForState(page, 'connection', 'ready');
  await page.click('#go');
  await waitForState(page, 'phase', 'running');
  await page.waitForFunction(() => Number.parseFloat(document.getElementById('clock').textContent) > 1.9, null, { timeout: TIMEOUT_MS });
  const before = await number(page, '#force-value');
  await page.selectOption('#method', 'damped_least_squares');
  await page.waitForFunction(() => document.getElementById('caption').textContent === 'Damped least squares');
  const during = await number(page, '#force-value');
  await waitForState(page, 'phase', 'finished');
  assert.ok(Math.abs(before - 30) < 3 && Math.abs(during - 30) < 3, `${before} N, then ${during} N`);
  await page.waitForFunction(() => document.getElementById('force-value').textContent === '30.0');
  assert.match(await page.getAttribute('[data-plot="force"] canvas', 'aria-label'), /force 30\.0 N, desired 30\.0 N/);

  const [csv] = await Promise.all([page.waitForEvent('download'), page.click('#export-csv')]);
  assert.equal(csv.suggestedFilename(), 'stiff_wall-damped_least_squares-auto.csv');
  const [svg] = await Promise.all([page.waitForEvent('download'), page.click('#export-svg')]);
  assert.match(svg.suggestedFilename(), /\.svg$/);
  assert.deepEqual(pageErrors, []);
  await close();
  await service.stop();
});

test('a run with a ghost can be stepped, pushed and ended with the keyboard', options, async () => {
  const service = await serve();
  const { page, pageErrors, close } = await open(browser, `${service.url}/#scenario=stiff_wall_singular&ghost=damped_least_squares`);
  await waitForState(page, 'connection', 'ready');
  assert.equal(await page.inputValue('#scenario'), 'stiff_wall_singular');
  await waitForText(page, '#ghosts', /^Damped least squares/);
  await page.focus('#scene');
  await page.keyboard.press('s');
  await waitForState(page, 'phase', 'paused');
  await page.waitForFunction(() => document.getElementById('clock').textContent === '0.009 s');
  await page.keyboard.press('ArrowLeft');
  await page.keyboard.press(' ');
  await waitForState(page, 'phase', 'running');
  assert.match(await page.textContent('#scene-legend'), /Damped least squares/);
  await page.focus('[data-push="0 1 0"]');
  await page.keyboard.down('Enter');
  await page.waitForFunction(() => document.querySelector('[data-push="0 1 0"]').classList.contains('held'));
  await page.keyboard.up('Enter');
  await page.focus('#scene');
  await page.keyboard.press('e');
  await waitForState(page, 'phase', 'finished');
  await page.keyboard.press('r');
  await waitForState(page, 'phase', 'none');
  assert.deepEqual(pageErrors, []);
  await close();
  await service.stop();
});

test('the pointer pushes the arm, and cycle, link and trace can be exported', options, async () => {
  const service = await serve();
  const { page, pageErrors, close } = await open(browser, `${service.url}/#scenario=human_push`, { permissions: ['clipboard-read', 'clipboard-write'] });
  await waitForState(page, 'connection', 'ready');
  await page.click('#go');
  await waitForState(page, 'phase', 'running');
  const tool = await findInScene(page, 'grabbable');
  await page.mouse.down();
  await page.mouse.move(tool.x + 60, tool.y - 60, { steps: 5 });
  await page.waitForFunction((time) => Number.parseFloat(document.getElementById('clock').textContent) > time + 0.3, Number.parseFloat(await page.textContent('#clock')));
  await page.mouse.up();

  for (const [button, program, option] of [['#copy-curl', 'sh', '-c'], ['#copy-python', 'python3', '-c']]) {
    await page.click(button);
    await page.waitForFunction((word) => document.getElementById('share-note').textContent.startsWith(word), button === '#copy-curl' ? 'curl' : 'Python');
    const text = await page.evaluate(() => navigator.clipboard.readText());
    const printed = execFileSync(program, [option, text], { encoding: 'utf8' });
    assert.equal((JSON.parse(printed).joint_velocity ?? JSON.parse(printed)).length, 7, printed);
  }
  await page.click('#copy-link');
  await page.waitForFunction(() => document.getElementById('share-note').textContent.startsWith('Link'));
  assert.match(await page.evaluate(() => navigator.clipboard.readText()), /#scenario=human_push/);

  await endRun(page);
  const [csv] = await Promise.all([page.waitForEvent('download'), page.click('#export-csv')]);
  const [header, ...rows] = readFileSync(await csv.path(), 'utf8').trim().split('\n').map((line) => line.split(','));
  const [x, z] = ['external_force_x_n', 'external_force_z_n'].map((name) => header.indexOf(name));
  // The scenario itself pushes only along y.
  assert.ok(rows.some((row) => Math.hypot(row[x], row[z]) > 1));
  const [mcap] = await Promise.all([page.waitForEvent('download'), page.click('#export-mcap')]);
  assert.equal(readFileSync(await mcap.path()).subarray(1, 5).toString(), 'MCAP');
  assert.deepEqual(pageErrors, []);
  await close();
  await service.stop();
});

test('the page shows that the server was killed and that it is available again', options, async () => {
  const service = await serve();
  const { page, pageErrors, close } = await open(browser, `${service.url}/#scenario=stiff_wall`);
  await waitForState(page, 'connection', 'ready');
  await page.click('#go');
  await waitForState(page, 'phase', 'running');
  await service.stop('SIGKILL');
  await waitForState(page, 'connection', 'unreachable');
  await waitForState(page, 'phase', 'lost');
  assert.match(await page.textContent('#connection'), /not reachable/);
  const next = await serve(service.port);
  await waitForState(page, 'connection', 'ready');
  assert.match(await page.textContent('#notice'), /available again/);
  await page.click('#go');
  await waitForState(page, 'phase', 'running', 'finished');
  assert.deepEqual(pageErrors, []);
  await close();
  await next.stop();
});

test('a service that does not answer stays unreachable until it does', options, async () => {
  const service = await serve();
  const { page, pageErrors, close } = await open(browser, `${service.url}/#scenario=stiff_wall`);
  await waitForState(page, 'connection', 'ready');
  service.signal('SIGSTOP');
  await waitForState(page, 'connection', 'unreachable');
  // A late answer more must not count as reachable: the page would load everything again. A check takes 2.7 s.
  const paths = [];
  page.on('request', (request) => paths.push(new URL(request.url()).pathname));
  while (paths.length < 2) await new Promise((done) => setTimeout(done, 200));
  assert.deepEqual(paths.filter((path) => path !== '/healthz'), []);
  service.signal('SIGCONT');
  await waitForState(page, 'connection', 'ready');
  assert.deepEqual(pageErrors, []);
  await close();
  await service.stop();
});

/** Lets the service refuse a file of the page: the first `times` requests. */
async function refuseFile(context, name, times) {
  await context.route(`**/dashboard/${name}`, (route) => {
    times -= 1;
    return times < 0 ? route.fallback() : route.fulfill({ status: 503, headers: { 'retry-after': '1' } });
  });
}

test('the page loads again when a file was refused, and says so when it gives up', options, async () => {
  const service = await serve();
  const context = await browser.newContext();
  await refuseFile(context, 'scene.js', 1);
  await refuseFile(context, 'style.css', 2);
  const page = await context.newPage();
  await page.goto(`${service.url}/#scenario=stiff_wall`);
  await waitForState(page, 'connection', 'ready');
  assert.equal(await page.inputValue('#scenario'), 'stiff_wall');
  assert.equal(await page.evaluate(() => [...document.styleSheets].length), 1);
  await refuseFile(context, 'scene.js', Infinity);
  await page.evaluate(() => sessionStorage.setItem('revprio-retries', '9'));
  await page.reload();
  await waitForText(page, '#connection', /^The page was not loaded; reload it$/);
  await context.close();
  await service.stop();
});

test('the page shows that the server is overloaded, and can try again', options, async () => {
  const service = await serve();
  const { page, pageErrors, close } = await open(browser, `${service.url}/#scenario=stiff_wall`);
  await waitForState(page, 'connection', 'ready');
  const problem = { type: '/problems/overloaded', title: 'The service has too much to do', status: 503, detail: 'send fewer requests' };
  await page.route('**/v1/simulations', (route) => route.fulfill({
    status: 503, headers: { 'retry-after': '1' }, contentType: 'application/problem+json', body: JSON.stringify(problem),
  }));
  await page.click('#go');
  await waitForState(page, 'connection', 'overloaded');
  assert.match(await page.textContent('#notice'), /too much to do/);
  await page.unroute('**/v1/simulations');
  await waitForState(page, 'connection', 'ready');
  await page.click('#go');
  await waitForState(page, 'phase', 'running', 'finished');
  assert.deepEqual(pageErrors, []);
  await close();
  await service.stop();
});

const HINGE = `<robot name="hinge"><link name="base"/><link name="arm"/><link name="tool"/>
  <joint name="turn" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/><limit lower="-3" upper="3" velocity="1.5" effort="1"/></joint>
  <joint name="hand" type="fixed"><parent link="arm"/><child link="tool"/><origin xyz="0.5 0 0"/></joint></robot>`;

test('the page asks for the token and watches a session of another client', options, async () => {
  const service = await serve(0, 's3cret-token');
  const { page, pageErrors, close } = await open(browser, service.url);
  await page.waitForSelector('#token-dialog[open]');
  await page.fill('#token', 'another');
  await page.keyboard.press('Enter');
  await page.waitForSelector('#token-wrong:not([hidden])');
  await page.fill('#token', 's3cret-token');
  await page.keyboard.press('Enter');
  await waitForState(page, 'connection', 'ready');

  const headers = { authorization: 'Bearer s3cret-token', 'content-type': 'application/json' };
  const call = async (path, body, method = body ? 'POST' : 'GET') =>
    (await fetch(service.url + path, { method, headers, body: body && JSON.stringify(body) })).json();
  const scenario = await call('/v1/scenarios/stiff_wall');
  const { id } = await call('/v1/controllers', scenario.controller);
  await page.click('text=Live session');
  await waitForState(page, 'phase', 'watching');
  assert.equal(await page.inputValue('#session'), id);
  assert.equal(await page.isVisible('#go'), false);
  const wrench = { force: [12.5, 0, 0], torque: [0, 0, 0] };
  const step = (sequence) => call(`/v1/controllers/${id}/step`, { sequence, time_s: sequence / 1000, joint_position: scenario.start_joint_position, wrench });
  for (let sequence = 0; sequence < 3; sequence += 1) await step(sequence);
  await page.waitForFunction(() => document.getElementById('force-value').textContent === '12.5');

  // The calls come later than the period of the session wants them.
  await page.waitForFunction(() => /Missed periods[1-9]/.test(document.getElementById('readouts').textContent));
  const [first, ...others] = scenario.controller.tasks;
  await call(`/v1/controllers/${id}`, { ...scenario.controller, tasks: [{ ...first, name: 'another task' }, ...others] }, 'PUT');
  await step(3);
  await page.waitForFunction(() => document.body.textContent.includes('another task'));
  await waitForState(page, 'phase', 'watching');

  await drop(page, [['hinge.urdf', HINGE]]);
  await waitForState(page, 'phase', 'none');
  await page.waitForFunction(() => document.getElementById('robot').value === 'my_hinge');
  assert.equal(await page.isVisible('#session'), false);
  assert.equal(await page.isVisible('#go'), true);
  assert.deepEqual(pageErrors, []);
  await close();
  await service.stop();
});

test('a narrow screen shows everything without scrolling sideways', options, async () => {
  const service = await serve();
  for (const [width, colorScheme] of [[390, 'dark'], [1920, 'light']]) {
    const { page, pageErrors, close } = await open(browser, service.url, { viewport: { width, height: 844 }, colorScheme, reducedMotion: 'reduce' });
    await waitForState(page, 'connection', 'ready');
    const [wide, theme] = await page.evaluate(() => [document.documentElement.scrollWidth, document.documentElement.dataset.theme]);
    assert.ok(wide <= width, `${wide} px on ${width}`);
    assert.equal(theme, colorScheme);
    assert.equal(await page.isVisible('#go'), true);
    assert.deepEqual(pageErrors, []);
    await close();
  }
  await service.stop();
});
