// The dashboard in a real browser, as sentences.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { readFileSync } from 'node:fs';
import { after, before, test } from 'node:test';

import { PATIENCE, cleanUp, launch, number, open, serve, spotOf, until } from './harness.mjs';

let browser;
before(async () => { browser = await launch(); }, { timeout: PATIENCE });
after(async () => {
  cleanUp();
  await browser?.close();
});

const within = { timeout: 2 * PATIENCE };

test('a scenario runs, its force settles at 30 N, and a changed method does not jump', within, async () => {
  const service = await serve();
  const { page, complaints, close } = await open(browser, `${service.url}/#scenario=stiff_wall`);
  await until(page, 'link', 'ready');
  await page.click('#go');
  await until(page, 'phase', 'running');
  await page.waitForFunction(() => Number.parseFloat(document.getElementById('clock').textContent) > 1.9, null, { timeout: PATIENCE });
  const before = await number(page, '#force-value');
  await page.selectOption('#method', 'damped_least_squares');
  await page.waitForFunction(() => document.getElementById('caption').textContent === 'Damped least squares');
  const during = await number(page, '#force-value');
  await until(page, 'phase', 'finished');
  assert.ok(Math.abs(before - 30) < 3 && Math.abs(during - 30) < 3, `${before} N, then ${during} N`);
  await page.waitForFunction(() => document.getElementById('force-value').textContent === '30.0');
  assert.match(await page.getAttribute('[data-plot="force"] canvas', 'aria-label'), /force 30\.0 N, desired 30\.0 N/);

  const [csv] = await Promise.all([page.waitForEvent('download'), page.click('#export-csv')]);
  assert.equal(csv.suggestedFilename(), 'stiff_wall-damped_least_squares-auto.csv');
  const [svg] = await Promise.all([page.waitForEvent('download'), page.click('#export-svg')]);
  assert.match(svg.suggestedFilename(), /\.svg$/);
  assert.deepEqual(complaints, []);
  await close();
  await service.stop();
});

test('a run waits for its steps, can be pushed, and takes a ghost along', within, async () => {
  const service = await serve();
  const { page, complaints, close } = await open(browser, `${service.url}/#scenario=stiff_wall_singular&ghost=damped_least_squares`);
  await until(page, 'link', 'ready');
  assert.equal(await page.inputValue('#scenario'), 'stiff_wall_singular');
  assert.equal(await page.inputValue('#ghost'), 'damped_least_squares');
  // By the keyboard alone.
  await page.focus('#scene');
  await page.keyboard.press('s');
  await until(page, 'phase', 'paused');
  await page.waitForFunction(() => document.getElementById('clock').textContent === '0.009 s');
  await page.keyboard.press('ArrowLeft');
  await page.keyboard.press(' ');
  await until(page, 'phase', 'running');
  assert.match(await page.textContent('#scene-legend'), /Damped least squares/);
  await page.focus('[data-push="0 1 0"]');
  await page.keyboard.down('Enter');
  await page.waitForFunction(() => document.querySelector('[data-push="0 1 0"]').classList.contains('held'));
  await page.keyboard.up('Enter');
  await page.focus('#scene');
  await page.keyboard.press('e');
  await until(page, 'phase', 'finished');
  await page.keyboard.press('r');
  await until(page, 'phase', 'none');
  assert.deepEqual(complaints, []);
  await close();
  await service.stop();
});

test('a hand pushes the arm, and what it did can be taken along', within, async () => {
  const service = await serve();
  const { page, complaints, close } = await open(browser, `${service.url}/#scenario=human_push`, { permissions: ['clipboard-read', 'clipboard-write'] });
  await until(page, 'link', 'ready');
  await page.click('#go');
  await until(page, 'phase', 'running');
  const tool = await spotOf(page, 'aims');
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

  await page.click('#end');
  await until(page, 'phase', 'finished');
  const [csv] = await Promise.all([page.waitForEvent('download'), page.click('#export-csv')]);
  const [header, ...rows] = readFileSync(await csv.path(), 'utf8').trim().split('\n').map((line) => line.split(','));
  const [x, z] = ['external_force_x_n', 'external_force_z_n'].map((name) => header.indexOf(name));
  // The scenario itself pushes along y alone.
  assert.ok(rows.some((row) => Math.hypot(row[x], row[z]) > 1));
  const [mcap] = await Promise.all([page.waitForEvent('download'), page.click('#export-mcap')]);
  assert.equal(readFileSync(await mcap.path()).subarray(1, 5).toString(), 'MCAP');
  assert.deepEqual(complaints, []);
  await close();
  await service.stop();
});

test('a killed server is noticed, and its return too', within, async () => {
  const service = await serve();
  const { page, complaints, close } = await open(browser, service.url);
  await until(page, 'link', 'ready');
  await page.click('#go');
  await until(page, 'phase', 'running');
  await service.stop('SIGKILL');
  await until(page, 'link', 'gone');
  await until(page, 'phase', 'lost');
  assert.match(await page.textContent('#link'), /gone/);
  const next = await serve(service.port);
  await until(page, 'link', 'ready');
  assert.match(await page.textContent('#notice'), /is back/);
  await page.click('#go');
  await until(page, 'phase', 'running', 'finished');
  assert.deepEqual(complaints, []);
  await close();
  await next.stop();
});

test('an overloaded server is named, with what to do, and is tried again', within, async () => {
  const service = await serve();
  const { page, complaints, close } = await open(browser, service.url);
  await until(page, 'link', 'ready');
  const problem = { type: '/problems/overloaded', title: 'The service has too much to do', status: 503, detail: 'send fewer requests' };
  await page.route('**/v1/simulations', (route) => route.fulfill({
    status: 503, headers: { 'retry-after': '1' }, contentType: 'application/problem+json', body: JSON.stringify(problem),
  }));
  await page.click('#go');
  await until(page, 'link', 'overloaded');
  assert.match(await page.textContent('#notice'), /too much to do/);
  await page.unroute('**/v1/simulations');
  await until(page, 'link', 'ready');
  await page.click('#go');
  await until(page, 'phase', 'running', 'finished');
  assert.deepEqual(complaints, []);
  await close();
  await service.stop();
});

test('a session of another client is watched, with the token that the service needs', within, async () => {
  const service = await serve(0, 's3cret-word');
  const { page, complaints, close } = await open(browser, service.url);
  await page.waitForSelector('#token-dialog[open]');
  await page.fill('#token', 'another');
  await page.keyboard.press('Enter');
  await page.waitForSelector('#token-wrong:not([hidden])');
  await page.fill('#token', 's3cret-word');
  await page.keyboard.press('Enter');
  await until(page, 'link', 'ready');

  const headers = { authorization: 'Bearer s3cret-word', 'content-type': 'application/json' };
  const ask = async (path, body) => (await fetch(service.url + path, { method: body ? 'POST' : 'GET', headers, body: body && JSON.stringify(body) })).json();
  const scenario = await ask('/v1/scenarios/stiff_wall');
  const { id } = await ask('/v1/controllers', scenario.controller);
  await page.click('text=Live session');
  await until(page, 'phase', 'watching');
  assert.equal(await page.inputValue('#session'), id);
  assert.equal(await page.isVisible('#go'), false);
  for (let sequence = 0; sequence < 3; sequence += 1) {
    const wrench = { force: [12.5, 0, 0], torque: [0, 0, 0] };
    await ask(`/v1/controllers/${id}/step`, { sequence, time_s: sequence / 1000, joint_position: scenario.start_joint_position, wrench });
  }
  await page.waitForFunction(() => document.getElementById('force-value').textContent === '12.5');
  assert.deepEqual(complaints, []);
  await close();
  await service.stop();
});

test('a narrow screen shows everything without scrolling sideways', within, async () => {
  const service = await serve();
  for (const [width, colorScheme] of [[390, 'dark'], [1920, 'light']]) {
    const { page, complaints, close } = await open(browser, service.url, { viewport: { width, height: 844 }, colorScheme, reducedMotion: 'reduce' });
    await until(page, 'link', 'ready');
    const [wide, theme] = await page.evaluate(() => [document.documentElement.scrollWidth, document.documentElement.dataset.theme]);
    assert.ok(wide <= width, `${wide} px on ${width}`);
    assert.equal(theme, colorScheme);
    assert.equal(await page.isVisible('#go'), true);
    assert.deepEqual(complaints, []);
    await close();
  }
  await service.stop();
});
