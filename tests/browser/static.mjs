// The page as static files: it runs without a service, and its module answers as the service.

import assert from 'node:assert/strict';
import { existsSync, readFileSync, readdirSync } from 'node:fs';
import { createServer } from 'node:http';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { deflateRawSync } from 'node:zlib';

import { cleanUp, drop, launch, open, serve, waitForClock, waitForState, waitForText } from './harness.mjs';

/** What `tools/site/playground` wrote, and the folder of the server in which it lies. */
const FOLDER = process.env.REVPRIO_PLAYGROUND ?? 'target/site/playground';
const PLACE = '/some/where/';

const EXAMPLES = 'api/examples';
const TYPES = { html: 'text/html', js: 'text/javascript', css: 'text/css', wasm: 'application/wasm' };

/** Allowed difference of two numbers, relative to their size: the sines of WebAssembly come from another library. */
const TOLERANCE = 1e-12;

/** Fields that differ between two services. */
const OWN = new Set(['id', 'elapsed_us', 'idle_timeout_s', 'request_id']);

/** Routes of the examples, by the first word of their names; a number is the session that must be open. */
const ROUTES = {
  batch: '/v1/resolve/batch', controller: '/v1/controllers', kinematics: '/v1/kinematics', resolve: '/v1/resolve',
  robot: '/v1/robots', stability: '/v1/stability', step: '/v1/step',
};

let browser;
let files;
let url;
let service;

before(async () => {
  files = createServer((request, response) => {
    const name = request.url.replace(PLACE, '').split('?')[0] || 'index.html';
    const file = join(FOLDER, name);
    if (!request.url.startsWith(PLACE) || !existsSync(file)) return response.writeHead(404).end();
    response.writeHead(200, { 'content-type': TYPES[name.split('.').pop()] }).end(readFileSync(file));
  });
  await new Promise((resolve) => files.listen(0, '127.0.0.1', resolve));
  url = `http://127.0.0.1:${files.address().port}${PLACE}`;
  [browser, service] = await Promise.all([launch(), serve()]);
});

after(async () => {
  files.close();
  await browser?.close();
  cleanUp();
});

/** Opens the static page; afterwards it must have had no errors. */
async function withPage(body) {
  const { page, pageErrors, close } = await open(browser, url);
  await waitForState(page, 'connection', 'ready');
  await body(page);
  assert.deepEqual(pageErrors, []);
  await close();
}

/** Answers requests one after the other by the module; each is [method, path, body]. */
function byModule(page, requests) {
  return page.evaluate(async (requests) => {
    const { BrowserService } = await import('./dashboard/browser_service.js');
    const module = await BrowserService.start();
    const answers = [];
    for (const [method, path, body] of requests) {
      const response = await module.fetch(path, { method, body });
      answers.push({ status: response.status, body: response.status === 204 ? null : await response.json() });
    }
    module.worker.terminate();
    return answers;
  }, requests);
}

async function byService(requests) {
  const answers = [];
  for (const [method, path, body] of requests) {
    const headers = { 'content-type': 'application/json' };
    const response = await fetch(`${service.url}${path}`, { method, headers, body: body ?? undefined });
    answers.push({ status: response.status, body: response.status === 204 ? null : await response.json() });
  }
  return answers;
}

/** Asserts that two values are equal but for rounding. */
function assertSame(got, wanted, place) {
  if (typeof wanted === 'number' && typeof got === 'number') {
    const size = Math.max(1, Math.abs(wanted));
    assert.ok(Math.abs(got - wanted) <= TOLERANCE * size, `${place}: ${got}, not ${wanted}`);
  } else if (wanted !== null && typeof wanted === 'object') {
    const keys = (value) => Object.keys(value ?? {}).filter((key) => !OWN.has(key));
    assert.deepEqual(keys(got), keys(wanted), place);
    for (const key of keys(wanted)) assertSame(got[key], wanted[key], `${place}/${key}`);
  } else assert.equal(got, wanted, place);
}

test('the playground runs without a service, and says so', async () => {
  await withPage(async (page) => {
    await waitForText(page, '#connection', /^In this browser$/);
    await waitForClock(page, 1);
    assert.equal(await page.locator('.sources').isVisible(), false);
    assert.equal(await page.locator('#export-csv').isVisible(), false);
    const before = Number.parseFloat(await page.textContent('#clock'));
    await page.click('#go');
    await waitForState(page, 'phase', 'paused');
    await page.click('#go');
    await waitForClock(page, before + 0.5);
  });
});

test('scenarios with a wall run in the browser until their end', async () => {
  await withPage(async (page) => {
    await page.selectOption('#scenario', 'stiff_wall');
    await page.click('#go');
    await waitForState(page, 'phase', 'running');
    await waitForState(page, 'phase', 'finished');
  });
});

test('a recording is followed side by side, and a link with a time and a robot opens, without a service', async () => {
  await withPage(async (page) => {
    await drop(page, [['pink.csv', readFileSync('docs/behaviour/out_of_reach-pink.csv', 'utf8')]]);
    await page.click('text=Follow its target');
    await waitForText(page, '#description', /follows the target of pink/);
    await page.click('[data-compare="two"]');
    await waitForClock(page, 1);
    await waitForText(page, '#scene-legend', /Strict reverse priority: [\d.]+ (mm|µm) to the target.*pink: [\d.]+ (mm|µm)/);
  });
  const urdf = `<robot name="r"><link name="a"/><link name="b"/><link name="c"/>${['a b', 'b c'].map((pair, i) => {
    const [parent, child] = pair.split(' ');
    return `<joint name="j${i}" type="revolute"><parent link="${parent}"/><child link="${child}"/><origin xyz="0.3 0 0.1"/><axis xyz="0 ${i} ${1 - i}"/><limit lower="-1" upper="1" velocity="1" effort="1"/></joint>`;
  }).join('')}</robot>`;
  const robot = deflateRawSync(Buffer.from(JSON.stringify({ urdf }))).toString('base64url');
  const { page, pageErrors, close } = await open(browser, `${url}#scenario=playground&robot=my_r&time=0.4&urdf=${robot}`);
  await waitForText(page, '#description', /^my_r_[0-9a-f]{10} at rest/);
  await waitForText(page, '#clock', /^0\.400 s$/);
  assert.deepEqual(pageErrors, []);
  await close();
});

test('the module answers every example as the service does', async () => {
  const requests = readdirSync(EXAMPLES).filter((name) => name.endsWith('.json')).flatMap((name) => {
    const path = ROUTES[/^[a-z]+/.exec(name)[0]];
    return path ? [[name, 'POST', path, readFileSync(join(EXAMPLES, name), 'utf8')]] : [];
  });
  const first = requests.find(([name]) => name === 'robot.json');
  const ordered = [first, ...requests.filter((request) => request !== first)];
  const robots = ['GET', '/v1/robots', null];
  const sent = [robots, ['GET', '/v1/scenarios', null], ['GET', '/v1/scenarios/none', null], ...ordered.map(([, ...request]) => request), robots];
  const names = ['robots', 'scenarios', 'unknown scenario', ...ordered.map(([name]) => name), 'robots with the registered'];
  assert.ok(ordered.length >= 25, `${ordered.length} examples`);
  await withPage(async (page) => {
    const [got, wanted] = await Promise.all([byModule(page, sent), byService(sent)]);
    let refused = 0;
    got.forEach((answer, i) => {
      if (answer.body?.pointer?.endsWith('/solver') && wanted[i].status === 200) refused += 1;
      else assertSame(answer, wanted[i], names[i]);
    });
    console.log(`${got.length - refused} answers are those of the service to ${TOLERANCE}; ${refused} need the solver qp`);
    assert.ok(refused <= 2);
  });
});

test('sessions of the module answer as those of the service', async () => {
  const text = (name) => readFileSync(join(EXAMPLES, `${name}.json`), 'utf8');
  const state = JSON.parse(text('state'));
  const states = Array.from({ length: 50 }, (_, k) => JSON.stringify({ ...state, sequence: state.sequence + k, time_s: state.time_s + 0.001 * k }));
  const of = (id) => [...states.map((body) => ['POST', `/v1/controllers/${id}/step`, body]), ['POST', `/v1/controllers/${id}/step`, states[0]], ['DELETE', `/v1/controllers/${id}`, null]];
  const [{ body: created }] = await byService([['POST', '/v1/controllers', text('controller')]]);
  const wanted = await byService(of(created.id));
  await withPage(async (page) => {
    const got = await byModule(page, [['POST', '/v1/controllers', text('controller')], ...of('1')]);
    assertSame(got.slice(1), wanted, 'session');
  });
});

test('the module refuses what it cannot do in words', async () => {
  const simulation = JSON.parse(readFileSync(join(EXAMPLES, 'simulation.json'), 'utf8'));
  await withPage(async (page) => {
    const [broken, unknown, batch] = await byModule(page, [
      ['POST', '/v1/resolve', '{'.concat('"tasks": 1}')], ['GET', '/v1/nothing', null],
      ['POST', '/v1/simulations', JSON.stringify(simulation)],
    ]);
    assert.deepEqual([broken.status, broken.body.pointer], [422, '/tasks']);
    assert.equal(unknown.status, 404);
    assert.deepEqual([batch.status, batch.body.pointer], [422, '/interactive']);
    assert.match(batch.body.detail, /revprio serve/);
  });
});
