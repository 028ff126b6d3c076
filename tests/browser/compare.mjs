// Tests of what is compared with the run: several methods, recordings of other programs, the divider and two scenes.

import assert from 'node:assert/strict';
import { existsSync, readFileSync } from 'node:fs';
import { after, before, test } from 'node:test';
import { deflateRawSync } from 'node:zlib';

import { TIMEOUT_MS, checkAccess, cleanUp, drop, endRun, launch, open, serve, share, waitForClock, waitForState, waitForText, withSetup } from './harness.mjs';

/** Browsers by the renderer that they are for: a browser with WebGL in software draws the canvas half as fast. */
let browsers;
let service;
before(async () => {
  const [canvas, webgl, served] = await Promise.all([launch(), launch({ webgl: true }), serve()]);
  browsers = { canvas, webgl };
  service = served;
}, { timeout: TIMEOUT_MS });
after(async () => {
  cleanUp();
  await Promise.all(Object.values(browsers ?? {}).map((browser) => browser.close()));
});

const options = { timeout: 3 * TIMEOUT_MS };
const small = { viewport: { width: 1000, height: 700 } };

/** Opens a setup; `body` gets the page. */
function withPage(fragment, body, context = {}, renderer = 'canvas') {
  return withSetup(browsers[renderer], `${service.url}/?renderer=${renderer}#${fragment}`, body, context);
}

const JOINTS = [1, 2, 3, 4, 5, 6, 7].map((i) => `panda_joint${i}`);
const HOME = [0, -0.785, 0, -2.356, 0, 1.571, 0.785];

/** Time at which the recording starts, as the clock of another program counts it, s. */
const START = 1000;

/** A recording of 4 s at 50 Hz whose first joint turns by up to `swing`, with a target that goes aside by 0.1 m. */
function csv({ swing = 0.6, separator = ',', hasTarget = true, names = JOINTS } = {}) {
  const lines = [['time_s', ...names, ...(hasTarget ? ['target_x_m', 'target_y_m', 'target_z_m'] : [])]];
  for (let k = 0; k <= 200; k += 1) {
    const phase = Math.sin((Math.PI * k) / 200) ** 2;
    const posture = [HOME[0] + swing * phase, ...HOME.slice(1)];
    lines.push([(START + k / 50).toFixed(2), ...posture.map((value) => value.toFixed(5)), ...(hasTarget ? [0.307, (0.1 * phase).toFixed(5), 0.59] : [])]);
  }
  return `# a comment\n${lines.map((line) => line.join(separator)).join('\n')}\n`;
}

/** Reads files in the page, texts or bytes: facts of each recording, or the message of the error. */
const read = (page, files) => page.evaluate(async (files) => {
  const { readRecording } = await import('/dashboard/recording.js');
  const { robots } = await (await fetch('/v1/robots')).json();
  const panda = robots.find(({ name }) => name === 'panda');
  return Promise.all(files.map(async ([name, content]) => {
    try {
      const { robot, times, duration, targets, suspicious, ...recording } = await readRecording(new File([Array.isArray(content) ? new Uint8Array(content) : content], name), [panda, ...robots]);
      return { name: recording.name, robot, rows: times.length, duration: Math.round(1e6 * duration) / 1e6, hasTarget: targets !== null, suspicious: suspicious.length, last: recording.positions.at(-1) };
    } catch (error) {
      return error.message;
    }
  }));
}, files);

test('recordings are read as CSV, JSON and JSON lines, with the robot whose joints they have', options, () => withPage('scenario=playground&robot=panda', async (page) => {
  const positions = [HOME, HOME.map((value) => value + 0.1)];
  const named = JSON.stringify({ time_s: [0, 0.5], joint_names: JOINTS, joint_position: positions, target_position: [[0.3, 0, 0.6], [0.3, 0.1, 0.6]] });
  const lines = positions.map((joint_position, i) => JSON.stringify({ time_s: i / 2, joint_position, status: 'optimal' })).join('\n');
  const scenario = await (await fetch(`${service.url}/v1/scenarios/joint_limits`)).json();
  const own = await trace(scenario);
  const german = csv({ separator: ';' }).replaceAll('.', ',');
  const found = await read(page, [
    ['a.csv', csv()], ['b.txt', csv({ separator: ';', hasTarget: false }).replaceAll('\n', '\r\n')], ['c.csv', `\uFEFF${csv({ separator: '\t' })}`],
    ['d.json', named], ['e.jsonl', lines], ['f.csv', csv({ names: JOINTS.map((name) => `position_${name}_rad`) })], ['g.csv', own],
    ['h.csv', `time,${JOINTS}\n0,${HOME.map((value) => (value * 180) / Math.PI)}\n1,${HOME.map((value) => (value * 180) / Math.PI)}`],
    ['i.csv', german], ['j.csv', [...Buffer.from(`\uFEFF${german}`, 'utf16le')]], ['k.csv', [...Buffer.from(`\uFEFF${german}`, 'utf16le').swap16()]],
    ['l.csv', csv().replace(/[^,#\n]+(?=[,\n])/g, '"$&"')], ['m.csv', german.replace(/[^;#\n]+(?=[;\n])/g, '"$&"')],
  ]);
  const common = { robot: 'panda', rows: 201, duration: 4, hasTarget: true, suspicious: 0, last: HOME };
  assert.deepEqual(found[0], { ...common, name: 'a' });
  assert.deepEqual(found[1], { ...common, name: 'b', hasTarget: false });
  assert.deepEqual(found[2], { ...common, name: 'c' });
  assert.deepEqual(found[3], { ...common, name: 'd', rows: 2, duration: 0.5, last: positions[1] });
  assert.deepEqual(found[4], { ...common, name: 'e', rows: 2, duration: 0.5, hasTarget: false, last: positions[1] });
  assert.deepEqual(found[5], { ...common, name: 'f' });
  assert.equal(found[6].robot, 'sawyer_dh', 'a trace of the service');
  assert.ok(found[6].rows > 500, `${found[6].rows} rows`);
  assert.ok(found[7].suspicious > 3, 'degrees are suspicious');
  ['i', 'j', 'k'].forEach((name, i) => assert.deepEqual(found[8 + i], { ...common, name }, 'a decimal comma'));
  ['l', 'm'].forEach((name, i) => assert.deepEqual(found[11 + i], { ...common, name }, 'quoted cells'));
}));

/** Simulates the start of a scenario and returns its trace as CSV. */
async function trace(scenario) {
  const headers = { 'content-type': 'application/json' };
  const made = await (await fetch(`${service.url}/v1/simulations`, { method: 'POST', headers, body: JSON.stringify({ scenario: { ...scenario, duration_s: 1 } }) })).json();
  for (;;) {
    const answer = await fetch(`${service.url}/v1/simulations/${made.id}/trace`, { headers: { accept: 'text/csv' } });
    if (answer.ok) return answer.text();
    await new Promise((resolve) => { setTimeout(resolve, 100); });
  }
}

test('a recording that is no recording is refused with its file, line and remedy', options, () => withPage('scenario=playground&robot=panda', async (page) => {
  const header = `time_s,${JOINTS}`;
  const row = (time, first = 0) => `${time},${[first, ...HOME.slice(1)]}`;
  const wide = '['.repeat(100_000);
  const cases = [
    ['empty.csv', '', /has no column time_s/],
    ['head.csv', header, /head\.csv has 0 rows; a recording needs two/],
    ['times.csv', `${header}\n${row(0)}\n${row(0)}`, /line 3: the time must be a number of seconds that grows/],
    ['backwards.csv', `${header}\n${row(1)}\n\n${row(0.5)}`, /line 4: the time must/],
    ['nan.csv', `${header}\n${row('NaN')}\n${row(1)}`, /line 2: the time must/],
    ['word.csv', `${header}\n${row(0)}\n${row(1, 'abc')}`, /line 3: joint panda_joint1 is at “abc”, which is no position/],
    ['short.csv', `${header}\n${row(0)}\n1,0.5`, /line 3: joint panda_joint2 is at “”/],
    ['huge.csv', `${header}\n${row(0)}\n${row(1, '1e15')}`, /is at “1e15”/],
    ['infinite.csv', `${header}\n${row(0)}\n${row(1, 'Infinity')}`, /is at “Infinity”/],
    ['other.csv', `time_s,a,b,c\n0,1,2,3\n1,1,2,3`, /no robot has joints with the names of its columns time_s, a, b, c\. panda needs panda_joint1/],
    ['broken.json', '{"time_s": [', /is neither JSON nor JSON lines/],
    ['deep.json', wide, /is neither JSON nor JSON lines|needs the lists/],
    ['fields.json', '{"time_s": 3}', /needs the lists time_s and joint_position/],
    ['null.json', '[null, null]', /a number of seconds that grows/],
    ['count.json', '{"time_s": [0, 1], "joint_position": [[1, 2], [1, 2]]}', /names no joints, and has 2 of them; panda has 7/],
    ['holes.json', JSON.stringify({ time_s: [0, 1], joint_names: JOINTS, joint_position: [HOME, null] }), /row 2: joint panda_joint1 is at “”/],
  ];
  const found = await read(page, cases.map(([name, content]) => [name, content]));
  cases.forEach(([name, , message], i) => assert.match(String(found[i]?.message ?? found[i]), message, name));
}));

test('a dropped recording is a ghost with its name, colour and numbers, plays with the time of the run, and is removed', options, () => withPage('scenario=playground&robot=ur5e', async (page) => {
  await drop(page, [['other program.csv', csv()]]);
  await waitForText(page, '#notice', /other program: 201 postures of panda in 4 s\./);
  await waitForText(page, '#description', /^panda at rest/);
  await waitForText(page, '#ghosts', /^other program/);
  await hideNotice(page);
  await page.click('#go');
  await waitForClock(page, 2.5);
  await endRun(page);
  await page.fill('#time', '2');
  await page.waitForFunction(() => document.getElementById('live').hidden === false);
  const tool = [0.307 * Math.cos(0.6) - 0, 0.307 * Math.sin(0.6)];
  const away = Math.hypot(tool[0] - 0.307, tool[1] - 0.1);
  await waitForText(page, '#scene-legend', /other program: [\d.]+ mm/);
  const shown = /other program: ([\d.]+) mm/.exec(await page.textContent('#scene-legend'))[1];
  assert.ok(Math.abs(Number(shown) - 1e3 * away) < 2, `${shown} mm, not ${1e3 * away}`);
  assert.match(await page.textContent('#scene-legend'), /Strict reverse priority: [\d.]+ (mm|µm) to the target/);
  assert.match(await page.textContent('[data-plot="pose"] [data-legend]'), /other program/);
  await page.click('#setup > summary');
  await page.selectOption('#robot', 'ur5e');
  await waitForText(page, '#ghosts', /of panda/);
  await page.waitForFunction(() => document.getElementById('scene-legend').textContent === '');
  await page.click('[aria-label="Remove ghost other program"]');
  await page.waitForFunction(() => document.querySelectorAll('#ghosts li').length === 0);
  await drop(page, [['bad.csv', 'a,b\n1,2']]);
  await waitForText(page, '#notice', /bad\.csv has no column time_s/);
}, small));

test('the run follows the target of a recording from its first posture, and undo returns', options, () => withPage('scenario=playground&robot=panda', async (page) => {
  await drop(page, [['aside.csv', csv()]]);
  await page.click('text=Follow its target');
  await waitForState(page, 'phase', 'running');
  await waitForText(page, '#description', /follows the target of aside/);
  await waitForState(page, 'phase', 'finished');
  await page.fill('#time', '2');
  await page.waitForFunction(() => document.getElementById('live').hidden === false);
  await waitForText(page, '#scene-legend', /priority: [\d.]+ (mm|µm) to the target/);
  const [, own, unit] = /priority: ([\d.]+) (mm|µm)/.exec(await page.textContent('#scene-legend'));
  assert.ok(unit === 'µm' || Number(own) < 3, `${own} ${unit} from the target of the recording`);
  const tool = /tool at (\S+), (\S+), (\S+) m/.exec(await page.getAttribute('#scene', 'aria-label')).slice(1).map((text) => Number(text.replace('−', '-')));
  assert.ok(Math.hypot(tool[0] - 0.307, tool[1] - 0.1, tool[2] - 0.59) < 5e-3, `${tool}`);
  await page.click('#undo');
  await waitForText(page, '#description', /^panda at rest/);
  await page.click('[aria-label="Let the run follow the target of aside"]');
  await waitForText(page, '#description', /follows the target of aside/);
}));

test('several ghosts have their own colours, and each is added and removed', options, () => withPage('scenario=playground&robot=panda&motion=eight&ghost=damped_least_squares,pseudoinverse,none,damped_least_squares', async (page) => {
  await waitForState(page, 'phase', 'running');
  await drop(page, [['third.csv', csv({ hasTarget: false })]]);
  await hideNotice(page);
  await waitForText(page, '#scene-legend', /Strict reverse priority.*Damped least squares: .*Pseudo-inverse: .*third: [\d.]+ mm/);
  const colours = await page.evaluate(() => Array.from(document.querySelectorAll('#ghosts .key'), (key) => key.style.borderTopColor));
  assert.equal(colours.length, 3);
  assert.equal(new Set(colours).size, 3, `${colours}`);
  await page.click('[aria-label="Remove ghost Damped least squares"]');
  await waitForText(page, '#scene-legend', /priority: [^D]*Pseudo-inverse/);
  assert.equal(await page.isVisible('#pending'), false, 'a removed ghost needs no new run');
  await waitForState(page, 'phase', 'running');
  assert.match(page.url(), /ghost=pseudoinverse(&|$)/);
  await page.selectOption('#ghost', 'task_priority');
  await waitForText(page, '#ghosts', /Task priority ?next run/);
  await page.click('#apply');
  await waitForText(page, '#scene-legend', /Pseudo-inverse.*Task priority: .*third/);
  await page.selectOption('#ghost', 'singularity_robust');
  assert.equal(await page.isDisabled('#ghost'), true, 'the service runs four simulations');
  await page.click('#apply');
  await waitForText(page, '#scene-legend', /Singularity robust/);
  await page.click('#undo');
  await waitForText(page, '#ghosts', /^(?!.*Singularity robust)/);
}));

test('a new start ends one that still waits for the service, and leaves no run behind', options, () => withPage('scenario=playground&robot=panda&motion=eight&ghost=pseudoinverse', async (page) => {
  await waitForText(page, '#scene-legend', /Pseudo-inverse/);
  const [made, deleted] = [[], []];
  page.on('response', async (response) => {
    const { pathname } = new URL(response.url());
    if (response.request().method() === 'DELETE') deleted.push(pathname);
    else if (response.status() === 202 && pathname === '/v1/simulations') made.push((await response.json()).id);
  });
  // The first start is still to tell its runs to begin when the second one comes.
  await page.route('**/control', async (route) => {
    await new Promise((resolve) => { setTimeout(resolve, 1000); });
    await route.continue().catch(() => {});
  });
  await page.evaluate(() => {
    const pill = document.getElementById('phase');
    globalThis.phases = [];
    new MutationObserver(() => globalThis.phases.push(pill.dataset.phase)).observe(pill, { attributes: true });
  });
  const restart = () => page.evaluate(() => document.getElementById('apply').click());
  await Promise.all([page.waitForRequest('**/control'), restart()]);
  await restart();
  await restart();
  await waitForState(page, 'phase', 'running');
  await page.waitForTimeout(1500);
  assert.equal(await page.getAttribute('#phase', 'data-phase'), 'running');
  const phases = await page.evaluate(() => globalThis.phases);
  assert.ok(phases.includes('starting') && !phases.includes('paused'), `a start is no pause: ${phases}`);
  assert.match(await page.textContent('#scene-legend'), /Pseudo-inverse/);
  const left = () => made.filter((id) => !deleted.some((path) => path.endsWith(id)));
  for (let tries = 0; left().length !== 2 && tries < 100; tries += 1) await page.waitForTimeout(100);
  assert.equal(left().length, 2, `of the runs ${made}, ${left()} are left`);
}));

/** Magenta of the first ghost, and blue of the run, as paths are drawn. */
const [GHOST, OWN] = [[[181, 86, 143]], [[0, 114, 178]]];

for (const renderer of ['canvas', 'webgl']) {
  test(`two scenes side by side, and a divider between two arms, with ${renderer}`, options, () => withPage('scenario=playground&robot=panda&motion=', async (page) => {
    await drop(page, [['aside.csv', csv()]]);
    await page.click('text=Follow its target');
    await waitForState(page, 'phase', 'finished');
    assert.equal(await page.getAttribute('#scene', 'data-renderer'), renderer);
    await page.fill('#time', '3.9');
    await page.click('[data-compare="two"]');
    // The legend has the colours, too.
    await page.evaluate(() => { document.querySelector('.corner.left').hidden = true; });
    await page.waitForTimeout(2500);
    const shares = async () => Promise.all([[GHOST, [0, 0.49]], [GHOST, [0.51, 1]], [OWN, [0, 0.49]], [OWN, [0.51, 1]]].map(([colour, span]) => share(page, colour, 30, span)));
    const [left, right] = await shares();
    assert.ok(right > 20 * left && right > 2e-4, `the path of the ghost is in ${left} of the left and ${right} of the right picture`);
    await page.click('[data-compare="divider"]');
    // The next drawing shows it; a hidden element takes no focus.
    await page.waitForFunction(() => !document.getElementById('divider').hidden);
    await page.focus('#divider');
    await page.keyboard.press('Home');
    await page.waitForFunction(() => document.getElementById('divider').ariaValueNow === '4');
    await page.waitForTimeout(2500);
    const [atLeft] = await Promise.all([share(page, GHOST, 30)]);
    await page.keyboard.press('End');
    await page.waitForFunction(() => document.getElementById('divider').ariaValueNow === '96');
    await page.waitForTimeout(2500);
    const atRight = await share(page, GHOST, 30);
    // The name of the ghost has its colour, too.
    assert.ok(atLeft > 2 * atRight && atLeft > 2e-4, `the path of the ghost: ${atLeft}, then ${atRight}`);
    await page.keyboard.press('ArrowLeft');
    await page.waitForFunction(() => document.getElementById('divider').ariaValueNow === '94');
    const [{ x, y, width, height }, free] = [await page.locator('#divider').boundingBox(), await page.locator('#free').boundingBox()];
    await page.mouse.move(x + width / 2, y + height / 2);
    await page.mouse.down();
    await page.mouse.move(free.x + 0.3 * free.width, y + height / 2, { steps: 5 });
    await page.mouse.up();
    await page.waitForFunction(() => document.getElementById('divider').ariaValueNow === '30');
    await page.click('[data-compare="ghosts"]');
    await page.waitForFunction(() => document.getElementById('divider').hidden);
  }, { ...small, colorScheme: 'light' }, renderer));
}

test('the right part has the arm, the path and the target of the chosen ghost, and the same view', options, () => withPage('scenario=stiff_wall', async (page) => {
  const found = await page.evaluate(async () => {
    const [compare, { Camera }] = await Promise.all(['compare', 'geometry'].map((name) => import(`/dashboard/${name}.js`)));
    const camera = Object.assign(new Camera(), { width: 1000, height: 500, azimuth: 1.2 });
    const free = { left: 100, top: 20, width: 800, height: 400 };
    const ghosts = ['one', 'two'].map((name, i) => ({ id: `method:${name}`, name, colour: i, arm: name, history: `path of ${name}`, until: i, position: [i], target: [i, 0, 0], away: 0 }));
    const world = { arm: 'own', name: 'own', position: [9], history: 'own path', ghosts, atLimit: [true], signs: {}, swung: [1], room: null, goal: { pose: { position: [5, 5, 5] } } };
    const of = (mode) => {
      compare.fromText(`${mode},0.25,method:two`);
      Object.assign(camera, { free: compare.firstArea(free, compare.modeOf(world)) });
      camera.update();
      return compare.panes(camera, world, free).map(({ camera: { free: area, eye }, world: { name, arm, position, history, goal, ghosts: others, signs }, from, to }) =>
        ({ area, isSameEye: String(eye) === String(camera.eye), name, arm, position, history, goal: goal.pose.position, others: others.length, hasSigns: signs !== null, from, to }));
    };
    return { two: of('two'), divider: of('divider'), ghosts: of('ghosts') };
  });
  const own = { isSameEye: true, name: 'own', arm: 'own', position: [9], history: 'own path', goal: [5, 5, 5], others: 0, hasSigns: true, from: 0 };
  const ghost = { isSameEye: true, name: 'two', arm: 'two', position: [1], history: 'path of two', goal: [1, 0, 0], others: 0, hasSigns: false, to: 1000 };
  const area = { left: 100, top: 20, width: 800, height: 400 };
  assert.deepEqual(found.two, [{ ...own, area: { ...area, width: 400 }, to: 500 }, { ...ghost, area: { ...area, left: 500, width: 400 }, from: 500 }]);
  assert.deepEqual(found.divider, [{ ...own, area, to: 300 }, { ...ghost, area, from: 300 }]);
  assert.deepEqual(found.ghosts, [{ ...own, area, to: 1000, others: 2 }]);
}));

test('on a phone the divider and the two scenes can be used by touch', options, async () => {
  const phone = { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true };
  await withPage('scenario=stiff_wall_singular&ghost=damped_least_squares,pseudoinverse', async (page) => {
    await page.tap('#go');
    await waitForClock(page, 0.3);
    await page.tap('[data-compare="divider"]');
    const boxes = await Promise.all(['#compare', '#swing', '#shapes', '#divider'].map(async (part) => (await page.locator(part).boundingBox()) ?? { x: 0, y: 0, width: 0, height: 0 }));
    const [bar, ...others] = boxes;
    for (const other of others.slice(0, 2)) assert.ok(bar.y + bar.height <= other.y || bar.x + bar.width <= other.x || other.width === 0, JSON.stringify([bar, other]));
    assert.ok(bar.x + bar.width <= 390);
    const divider = boxes[3];
    await page.touchscreen.tap(divider.x + divider.width / 2, divider.y + 100);
    await page.selectOption('#compare-other', 'method:pseudoinverse');
    await waitForText(page, '#divider', /^$/);
    await page.waitForFunction(() => document.getElementById('divider').ariaLabel === 'Divider between the arm of the run and Pseudo-inverse');
  }, phone);
});

test('a GIF film holds its pictures, their times and colours', options, () => withPage('scenario=stiff_wall', async (page) => {
  const found = await page.evaluate(async () => {
    const { DEPTH, TRAILER, encoded, header, paletteOf, toPixels } = await import('/dashboard/gif.js');
    const [width, height] = [61, 47];
    // Smooth colours, noise that fills the table of codes many times, a rectangle that moves, and a picture without a change.
    let seed = 7;
    const random = () => (seed = (seed * 16_807) % 2_147_483_647) / 2_147_483_647;
    const pictures = [0, 1, 2, 3, 3, 4].map((k) => {
      const data = new Uint8ClampedArray(4 * width * height);
      for (let y = 0; y < height; y += 1) {
        for (let x = 0; x < width; x += 1) {
          const at3 = (x, y) => (x >= 24 && x < 36 && y > 20 && y < 30 ? [230, 100, 10] : [4 * x, 5 * y, 120]);
          const isMoving = k !== 2 && x >= 8 * k && x < 8 * k + 12 && y > 20 && y < 30;
          const colour = k === 2 ? [255 * Math.round(random()), 255 * Math.round(random()), 255 * Math.round(random())] : isMoving ? [230, 100, 10] : [4 * x, 5 * y, 120];
          const isCorner = k === 4 && (x === 0 || x === width - 1) && (y === 0 || y === height - 1);
          data.set([...(isCorner ? [255, 255, 255] : k === 4 ? at3(x, y) : colour), 255], 4 * (y * width + x));
        }
      }
      return data;
    });
    const pixels = pictures.map(toPixels);
    const counts = new Uint32Array(DEPTH);
    for (const picture of pixels) for (const pixel of picture) counts[pixel] += 1;
    const palette = paletteOf(counts);
    const delays = [10, 20, 7, 100, 3, 4];
    const parts = [header(width, height, palette), ...pixels.map((picture, i) => encoded(width, { pixels: picture, delay: delays[i] }, pixels[i - 1] ?? null, palette)), TRAILER];
    const decoder = new ImageDecoder({ data: await new Blob(parts).arrayBuffer(), type: 'image/gif' });
    await decoder.tracks.ready;
    const results = [];
    for (let i = 0; i < decoder.tracks.selectedTrack.frameCount; i += 1) {
      const { image } = await decoder.decode({ frameIndex: i });
      const canvas = new OffscreenCanvas(width, height);
      const context = canvas.getContext('2d');
      context.drawImage(image, 0, 0);
      const { data } = context.getImageData(0, 0, width, height);
      const differences = Array.from(data, (value, at) => Math.abs(value - pictures[i][at]));
      results.push({ worst: Math.max(...differences), mean: differences.reduce((sum, value) => sum + value) / differences.length, delay: image.duration / 1e4, size: parts[i + 1].length });
    }
    return { results, repetitions: decoder.tracks.selectedTrack.repetitionCount };
  });
  assert.equal(found.results.length, 6);
  assert.equal(found.repetitions, Infinity);
  assert.deepEqual(found.results.map(({ delay }) => delay), [10, 20, 7, 100, 3, 4]);
  for (const { worst, mean } of found.results) assert.ok(worst <= 40 && mean < 6, JSON.stringify(found.results));
  assert.ok(found.results[4].size < 40, 'a picture without a change is small');
  assert.ok(found.results[5].size < 300 && found.results[0].size > 600, `a picture of which only the corners change is small: ${found.results.map(({ size }) => size)}`);
}));

test('the scene is recorded as a GIF film with at most ten pictures per second', options, () => withPage('scenario=stiff_wall_singular&ghost=damped_least_squares', async (page) => {
  await page.click('#setup > summary');
  await page.click('#record-gif');
  assert.equal(await page.getAttribute('#record-gif', 'aria-pressed'), 'true');
  await page.click('#go');
  await waitForClock(page, 1.5);
  const [film] = await Promise.all([page.waitForEvent('download'), page.click('#record-gif')]);
  assert.match(film.suggestedFilename(), /^stiff_wall_singular-.*\.gif$/);
  await waitForText(page, '#share-note', /\.gif saved: \d+ pictures, [\d.]+ MB\./);
  const data = readFileSync(await film.path());
  assert.equal(data.subarray(0, 6).toString('latin1'), 'GIF89a');
  const decoded = await page.evaluate(async (bytes) => {
    const decoder = new ImageDecoder({ data: new Uint8Array(bytes), type: 'image/gif' });
    await decoder.tracks.ready;
    await decoder.completed;
    const count = decoder.tracks.selectedTrack.frameCount;
    const { image } = await decoder.decode({ frameIndex: count - 1 });
    return { count, width: image.displayWidth, height: image.displayHeight };
  }, [...data]);
  assert.ok(decoded.count >= 2 && decoded.width > 100 && Math.max(decoded.width, decoded.height) <= 560, JSON.stringify(decoded));
  assert.equal(await page.textContent('#record-gif'), 'GIF');
}, small));

const clipboard = { permissions: ['clipboard-read', 'clipboard-write'] };

/** Hides a message, which may disappear by itself at any moment. */
const hideNotice = (page) => page.evaluate(() => { document.getElementById('notice').replaceChildren(); });

/** Copies the link of a page. */
async function linkOf(page) {
  await page.click('#copy-link');
  await page.waitForFunction(() => document.getElementById('share-note').textContent.startsWith('Link'));
  return page.evaluate(() => navigator.clipboard.readText());
}

/** Opens a link in another window; `body` gets its page. */
async function withLink(link, body) {
  const other = await open(browsers.canvas, link, clipboard);
  try {
    await waitForState(other.page, 'connection', 'ready');
    await body(other.page);
    assert.deepEqual(other.pageErrors, []);
  } finally {
    await other.page.goto('about:blank');
    await other.close();
  }
}

test('a link restores the shown time, the ghosts and the divider, and says what it does not have', options, () => withPage('scenario=joint_limits&ghost=damped_least_squares', async (page) => {
  await page.click('#go');
  await waitForState(page, 'phase', 'finished');
  await page.fill('#time', '1.2');
  await page.click('[data-compare="divider"]');
  const toolOf = async (from) => /tool at (\S+), (\S+), (\S+) m/.exec(await from.getAttribute('#scene', 'aria-label')).slice(1).map((text) => Number(text.replace('−', '-')));
  await waitForText(page, '#clock', /^1\.(19|20)\d s$/);
  const [shown, time] = [await toolOf(page), await page.textContent('#clock')];
  const link = await linkOf(page);
  assert.match(link, /ghost=damped_least_squares.*time=1\.(19|2)\d*.*compare=divider/);
  assert.doesNotMatch(link, /lost=/);
  await page.click('#reset');
  await withLink(link, async (other) => {
    await other.waitForFunction((text) => document.getElementById('clock').textContent === text, time);
    const tool = await toolOf(other);
    assert.ok(Math.hypot(...tool.map((value, axis) => value - shown[axis])) < 2e-3, `${tool}, not ${shown}`);
    await waitForState(other, 'phase', 'paused');
    await waitForText(other, '#scene-legend', /Damped least squares: /);
    assert.equal(await other.isVisible('#divider'), true);
    assert.equal(await other.isVisible('#notice'), false);
  });
}, clipboard));

test('a link names the pushes, changes and recordings that it does not have', options, () => withPage('scenario=playground&robot=panda', async (page) => {
  await drop(page, [['other.csv', csv({ hasTarget: false })]]);
  await hideNotice(page);
  await page.click('#go');
  await waitForClock(page, 0.3);
  await page.dispatchEvent('[data-push="0 1 0"]', 'pointerdown', { pointerId: 1 }).catch(() => {});
  await page.focus('[data-push="0 1 0"]');
  await page.keyboard.down('Enter');
  await page.waitForTimeout(300);
  await page.keyboard.up('Enter');
  await page.selectOption('#method', 'damped_least_squares');
  await waitForClock(page, 1);
  await page.click('#go');
  await waitForState(page, 'phase', 'paused');
  const link = await linkOf(page);
  assert.match(await page.textContent('#share-note'), /It does not have: changes during the run .*; pushes; recordings/);
  await page.click('#reset');
  await withLink(link, async (other) => {
    await waitForText(other, '#notice', /Opened from a link.*run again up to [\d.]+ s\. The link does not have: changes during the run.*pushes; recordings \(send the files, too\)/);
  });
}, clipboard));

test('a link shows a time of a few periods, and says when its time is beyond its reach', options, async () => {
  await withLink(`${service.url}/?renderer=canvas#scenario=joint_limits&time=0.003`, async (other) => {
    await waitForText(other, '#clock', /^0\.003 s$/);
    assert.equal(await other.isVisible('#notice'), false, await other.textContent('#notice'));
  });
  await withLink(`${service.url}/?renderer=canvas#scenario=joint_limits&time=900`, async (other) => {
    await waitForText(other, '#notice', /The link shows 900\.000 s, which is beyond the end of the scenario or 60 s/);
  });
});

const ROBOT = `<robot name="shared"><link name="l0"><visual><geometry><mesh filename="base.stl"/></geometry></visual></link>${[0, 1, 2, 3].map((i) => `<link name="l${i + 1}"><visual><origin xyz="0 0 0.15"/><geometry><box size="0.06 0.06 0.3"/></geometry></visual></link>
  <joint name="j${i}" type="revolute"><parent link="l${i}"/><child link="l${i + 1}"/><origin xyz="0 0 0.3"/><axis xyz="${i % 2} ${1 - (i % 2)} 0"/>
  <limit lower="-1.5" upper="1.5" velocity="2" effort="1"/></joint>`).join('')}</robot>`;

test('a link has a dropped robot without its meshes, and replaces no robot of the service', options, () => withPage('scenario=playground&robot=panda', async (page) => {
  await drop(page, [['shared.urdf', ROBOT], ['base.stl', 'solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 0.1 0 0\nvertex 0 0.1 0\nendloop\nendfacet\nendsolid']]);
  await waitForText(page, '#notice', /Robot my_shared/);
  await hideNotice(page);
  await waitForText(page, '#description', /^my_shared at rest/);
  const link = await linkOf(page);
  assert.match(await page.textContent('#share-note'), /It does not have: the meshes of the robot\./);
  assert.ok(link.length < 3000, `${link.length} characters`);
  await withLink(link, async (other) => {
    await waitForText(other, '#description', /^my_shared_[0-9a-f]{10} at rest/);
    await waitForText(other, '#notice', /The link does not have: the meshes of the robot/);
    const shapes = await other.evaluate(async () => (await (await fetch('/v1/robots')).json()).robots.map(({ name }) => name).filter((name) => name.startsWith('my_')));
    assert.equal(shapes.length, 2, `${shapes}`);
    await other.click('#go');
    await waitForClock(other, 0.2);
    await other.click('#go');
    await other.click('#reset');
    const again = await linkOf(other);
    await withLink(again, async (third) => {
      await waitForText(third, '#description', /^my_shared_[0-9a-f]{10} at rest/);
      const names = await third.evaluate(async () => (await (await fetch('/v1/robots')).json()).robots.map(({ name }) => name).filter((name) => name.startsWith('my_')));
      assert.deepEqual(names, shapes, 'the same robot has the same name');
    });
  });
}, clipboard));

test('a robot that is too long for a link is named', options, () => withPage('scenario=playground&robot=panda', async (page) => {
  let seed = 1;
  const noise = Array.from({ length: 90_000 }, () => String.fromCharCode(97 + ((seed = (seed * 16_807) % 2_147_483_647) % 26))).join('');
  await drop(page, [['long.urdf', ROBOT.replace('<link', `<!-- ${noise} --><link`)]]);
  await waitForText(page, '#description', /^my_shared at rest/);
  await hideNotice(page);
  const link = await linkOf(page);
  assert.ok(link.length < 1000, `${link.length} characters`);
  assert.match(await page.textContent('#share-note'), /the robot, whose URDF file is too long/);
}, clipboard));

test('a hostile link does no harm and says what is wrong', options, async () => {
  const pack = (text) => deflateRawSync(Buffer.from(text), { level: 9 }).toString('base64url');
  const robots = async () => (await (await fetch(`${service.url}/v1/robots`)).json()).robots.map(({ name }) => name);
  const before = await robots();
  const entities = `<!DOCTYPE r [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;">]>${ROBOT}`;
  const cases = [
    ['urdf=%3Cscript%3E', /damaged/],
    [`urdf=${'A'.repeat(60_001)}`, /more than 60000 characters/],
    [`urdf=${pack('0'.repeat(30_000_000)).slice(0, 59_999)}`, /more than 2 MB/],
    [`urdf=${pack('{"urdf": 3}')}`, /no URDF file/],
    [`urdf=${pack('null')}`, /no URDF file/],
    [`urdf=${pack('[1')}`, /damaged/],
    [`urdf=${pack(JSON.stringify({ urdf: ROBOT })).slice(0, 200)}`, /damaged/],
    [`urdf=${pack(JSON.stringify({ urdf: '<robot><img src=x onerror=alert(1)>' }))}`, /./],
    [`urdf=${pack(JSON.stringify({ urdf: entities }))}`, /no URDF file/],
    [`urdf=${pack(JSON.stringify({ urdf: ROBOT, limits: { j0: { velocity: -1 } } }))}`, /./],
  ];
  for (const [part, message] of cases) {
    await withPage(`scenario=playground&robot=panda&${part}`, async (page) => {
      await waitForText(page, '#notice', /The robot of the link was not loaded/);
      assert.match(await page.textContent('#notice p'), message, part.slice(0, 60));
      await waitForText(page, '#description', /^panda at rest/);
      assert.equal(await page.isEnabled('#go'), true);
    }, small);
  }
  assert.deepEqual(await robots(), before);
  const odd = ['time=1e308', 'time=-1', 'time=NaN', 'time=abc', 'compare=two,9,<b>', 'compare=x', `compare=${'two,'.repeat(1000)}`, 'lost=constructor,__proto__,toString,<b>', 'ghost=__proto__,constructor,x', `ghost=${'pseudoinverse,'.repeat(9000)}`];
  for (const part of odd) {
    await withPage(`scenario=joint_limits&${part}`, async (page) => {
      assert.equal(await page.locator('#notice b, #ghosts b').count(), 0);
      assert.doesNotMatch(await page.textContent('#notice'), /native code|undefined/);
      assert.ok((await page.locator('#ghosts li').count()) <= 1);
    }, small);
  }
});

for (const [width, height, colorScheme] of [[390, 844, 'light'], [768, 1024, 'dark'], [1920, 1080, 'light']]) {
  test(`with ghosts nothing is cut off and axe finds nothing serious at ${width} x ${height}, ${colorScheme}`, options, () => withPage('scenario=stiff_wall_singular&ghost=damped_least_squares,pseudoinverse&compare=divider,0.3', async (page) => {
    await page.evaluate(() => document.querySelectorAll('details').forEach((part) => { part.open = true; }));
    await page.click('#go');
    await waitForText(page, '#scene-legend', /Pseudo-inverse/);
    await page.waitForFunction(() => document.getElementById('divider').ariaValueNow === '30');
    const wide = await page.evaluate(() => document.documentElement.scrollWidth);
    assert.ok(wide <= width, `${wide} px on ${width}`);
    const cut = await page.evaluate(() => Array.from(document.querySelectorAll('#ghosts .task-name, #compare button')).filter((part) => part.scrollWidth > part.clientWidth + 1).map((part) => part.textContent));
    assert.deepEqual(cut, []);
    await checkAccess(page);
  }, { viewport: { width, height }, colorScheme }));
}

/** Distances of the recorded tools from their target at 5.5 s, mm, by the kinematics of tools/bench/behaviour/arm.py. */
const AWAY = { revprio: 331.3, pink: 313.5, mink: 313.5 };

test('the recordings of docs/behaviour are shown together, and the run follows their target', options, () => withPage('scenario=playground&robot=panda', async (page) => {
  const folder = ['docs/behaviour', '../../docs/behaviour'].find(existsSync);
  const files = ['revprio', 'pink', 'mink'].map((name) => [`out_of_reach-${name}.csv`, readFileSync(`${folder}/out_of_reach-${name}.csv`, 'utf8')]);
  await drop(page, files);
  await waitForText(page, '#notice', /3 recordings added as ghosts ?out_of_reach-revprio: 240 postures of panda in 11\.9 s\./);
  await page.click('text=Follow its target');
  await waitForState(page, 'phase', 'finished');
  await page.fill('#time', '5.5');
  await waitForText(page, '#clock', /^5\.[45]\d\d s$/);
  await waitForText(page, '#scene-legend', /Strict reverse priority: [\d.]+ mm.*out_of_reach-revprio: [\d.]+ mm.*out_of_reach-pink: [\d.]+ mm.*out_of_reach-mink: [\d.]+ mm/);
  const away = [...(await page.textContent('#scene-legend')).matchAll(/: ([\d.]+) mm/g)].map(([, value]) => Number(value));
  // The run tilts its tool to come nearer; the recordings give position and orientation the same priority.
  assert.ok(away[0] > 200 && away[0] < 300, `${away}`);
  ['revprio', 'pink', 'mink'].forEach((name, i) => assert.ok(Math.abs(away[i + 1] - AWAY[name]) < 2, `${name}: ${away[i + 1]} mm, not ${AWAY[name]}`));
}, small));
