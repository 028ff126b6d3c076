// Helpers of the dashboard tests: start the service and the browser, open the page, collect its errors.

import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { existsSync, mkdtempSync, readFileSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { chromium } from 'playwright-core';

/** Time limit of every wait, long enough for a slow machine, ms. */
export const TIMEOUT_MS = 120_000;

/** Every page passes more rules of axe than these; fewer mean that axe has not looked. */
const MIN_RULES = 15;

const FLAGS = [
  '--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run', '--disable-background-networking',
  '--disable-component-update', '--disable-sync',
];

/** Draws WebGL without a graphics card. The watchdog would end a renderer that gets no processor for some seconds. */
const SOFTWARE_WEBGL = ['--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--disable-gpu-watchdog'];

/** The first one has no window to draw besides the page, which takes a fifth of a core. */
const BROWSERS = ['/usr/bin/chromium-headless-shell', '/usr/bin/chromium', '/usr/bin/chromium-browser'];

/** Starts a headless browser; with `webgl` it has WebGL 2 on a software renderer, or on the graphics card with `card`; else none. */
export function launch({ webgl = false, card = false } = {}) {
  const executablePath = BROWSERS.find(existsSync);
  const args = webgl ? [...FLAGS.filter((flag) => flag !== '--disable-gpu'), ...(card ? [] : SOFTWARE_WEBGL)] : FLAGS;
  return chromium.launch({ executablePath, headless: true, timeout: TIMEOUT_MS, args });
}

/** Folder of the page's files that replaces those in the program: no build is needed after a change of the page. */
const PAGE_FOLDER = process.env.REVPRIO_PAGE;

/** Serves the page from `PAGE_FOLDER`, with the policy of the program. */
async function servePageFolder(context) {
  const types = { css: 'text/css', js: 'text/javascript', html: 'text/html' };
  await context.route((url) => url.pathname === '/' || url.pathname.startsWith('/dashboard/'), async (route) => {
    const { pathname, origin } = new URL(route.request().url());
    const name = pathname === '/' ? 'index.html' : pathname.replace('/dashboard/', '');
    const policy = (await fetch(`${origin}/`)).headers.get('content-security-policy');
    const headers = { 'content-security-policy': policy, 'content-type': types[name.split('.').pop()] };
    if (!existsSync(join(PAGE_FOLDER, name))) await route.fulfill({ status: 404 });
    else await route.fulfill({ headers, body: readFileSync(join(PAGE_FOLDER, name)) });
  });
}

/** Running services. After a failed test, its service is still in this set. */
const running = new Set();

/** Kills the services of failed tests. */
export function cleanUp() {
  for (const child of running) child.kill('SIGKILL');
}

/** Starts the service; `port` 0 selects a free port. */
export async function serve(port = 0, token = '') {
  const options = ['serve', '--listen', `127.0.0.1:${port}`];
  if (token) {
    const file = join(mkdtempSync(join(tmpdir(), 'revprio-')), 'token');
    writeFileSync(file, token, { mode: 0o600 });
    options.push('--token-file', file);
  }
  const child = spawn(process.env.REVPRIO, options, { stdio: ['ignore', 'pipe', 'inherit'] });
  running.add(child);
  const url = await new Promise((resolve, reject) => {
    child.once('exit', (code) => reject(new Error(`the service ended with ${code}`)));
    child.stdout.on('data', (text) => {
      const found = /http:\/\/\S+/.exec(String(text));
      if (found) resolve(found[0]);
    });
  });
  const stop = (signal = 'SIGTERM') =>
    new Promise((resolve) => {
      child.removeAllListeners('exit');
      child.once('exit', resolve);
      running.delete(child);
      child.kill(signal);
    });
  return { url, port: Number(new URL(url).port), stop, signal: (kind) => child.kill(kind) };
}

/** Time after which a page without a frame counts as one that the browser has put aside, ms. */
const FRAME_MS = 10_000;

/** Brings a page to the front if the browser draws no frames of it. A browser without a window seldom does that to a page; then even changes of the theme do not arrive. */
function watchFrames(page) {
  const frame = () => page.evaluate((limit) => new Promise((resolve) => {
    requestAnimationFrame(() => resolve(true));
    setTimeout(() => resolve(false), limit);
  }), FRAME_MS);
  const check = async () => {
    if (await frame()) return;
    console.error(`${page.url()}: no frame in ${FRAME_MS} ms; the page is brought to the front`);
    await page.bringToFront();
    if (await frame()) return;
    console.error(`${page.url()}: still no frame; a picture is taken, which draws one`);
    await page.screenshot();
  };
  // A page that is left or closed has no frames, and nobody waits for it.
  return setInterval(() => check().catch(() => {}), 2 * FRAME_MS).unref();
}

/** Opens the page; its exceptions and console errors are added to `pageErrors`. */
export async function open(browser, url, options = {}) {
  const context = await browser.newContext({ viewport: { width: 1440, height: 900 }, ...options });
  if (PAGE_FOLDER) await servePageFolder(context);
  const page = await context.newPage();
  page.setDefaultTimeout(TIMEOUT_MS);
  page.setDefaultNavigationTimeout(TIMEOUT_MS);
  const pageErrors = [];
  page.on('pageerror', (error) => pageErrors.push(String(error.stack)));
  // The browser itself logs failed requests. The page handles and shows them, so they are ignored here.
  page.on('console', (message) => {
    if (message.type() === 'error' && !message.text().startsWith('Failed to load resource')) pageErrors.push(message.text());
  });
  const watch = watchFrames(page);
  const runs = madeRuns(page);
  await page.goto(url);
  const close = async () => {
    clearInterval(watch);
    await context.close();
    // A page deletes its runs when it is left. One that is closed at once may be cut short, and the service accepts only a few.
    await Promise.all(runs.map((run) => fetch(run, { method: 'DELETE' }).catch(() => {})));
  };
  return { page, pageErrors, close };
}

/** Returns the list of the addresses of the runs that a page makes. */
function madeRuns(page) {
  const runs = [];
  page.on('response', (response) => {
    const location = response.status() === 202 && response.headers().location;
    if (location) runs.push(new URL(location, response.url()).href);
  });
  return runs;
}

/** Opens a setup of a service; `body` gets the page. Afterwards the page must have had no errors. */
export async function withSetup(browser, url, body, context = {}) {
  const { page, pageErrors, close } = await open(browser, url, context);
  try {
    await waitForState(page, 'connection', 'ready');
    await body(page);
    assert.deepEqual(pageErrors, []);
  } catch (error) {
    error.message += `; ${await shown(page, pageErrors).catch(String)}`;
    throw error;
  } finally {
    // The page deletes its runs when it is left. The service accepts only a few.
    await page.goto('about:blank');
    await close();
  }
}

/** What a page shows when a test fails: its state and its messages. */
async function shown(page, pageErrors) {
  const texts = await page.evaluate(() => ['connection', 'phase', 'notice', 'ghosts'].map((id) => `${id}: ${document.getElementById(id)?.textContent.trim().replace(/\s+/g, ' ')}`));
  return [...texts, ...pageErrors].join('; ');
}

/** Waits until a pill (`connection` or `phase`) shows one of `values`. */
export function waitForState(page, pill, ...values) {
  const hasState = ([id, wanted]) => wanted.includes(document.getElementById(id)?.dataset[id]);
  return page.waitForFunction(hasState, [pill, values], { timeout: TIMEOUT_MS });
}

/** Time after which a change of the theme counts as lost, ms. */
const THEME_MS = 30_000;

/** Changes the theme that the system prefers, and waits until the page has it. A browser that has put the page aside may lose the change; it is made anew then. */
export async function prefer(page, theme) {
  const follows = (wanted) => document.documentElement.dataset.theme === wanted;
  for (let attempt = 1; ; attempt += 1) {
    await page.emulateMedia({ colorScheme: theme });
    const error = await page.waitForFunction(follows, theme, { timeout: THEME_MS, polling: 100 }).then(() => null, (error) => error);
    if (!error) return;
    if (attempt === 3) throw error;
    console.error(`${page.url()}: the page has not followed to the ${theme} theme`);
    await page.bringToFront();
    await page.emulateMedia({ colorScheme: theme === 'dark' ? 'light' : 'dark' });
  }
}

/** Ends the run. It may have ended by itself: a click would then wait for a button that stays disabled. */
export async function endRun(page) {
  await page.evaluate(() => document.getElementById('end').click());
  await waitForState(page, 'phase', 'finished');
}

/** Waits until the simulated time passes `time`, s. */
export function waitForClock(page, time) {
  return page.waitForFunction((wanted) => Number.parseFloat(document.getElementById('clock').textContent) > wanted, time, { timeout: TIMEOUT_MS });
}

/** Waits until the text of an element matches. */
export function waitForText(page, selector, pattern) {
  const matches = ([selector, source]) => new RegExp(source).test((document.querySelector(selector)?.textContent ?? '').trim().replace(/\s+/g, ' '));
  return page.waitForFunction(matches, [selector, pattern.source], { timeout: TIMEOUT_MS });
}

/** Finds the place where the canvas of the scene gets a CSS class under the pointer, and moves the mouse there. */
export async function findInScene(page, name) {
  const found = await page.evaluate((name) => {
    const scene = document.getElementById('scene');
    const { left, top, width, height } = document.getElementById('free').getBoundingClientRect();
    for (let y = top + 8; y < top + height; y += 8) {
      for (let x = left + 8; x < left + width; x += 8) {
        scene.dispatchEvent(new PointerEvent('pointermove', { clientX: x, clientY: y, pointerId: 99 }));
        if (scene.classList.contains(name)) return { x, y };
      }
    }
    return null;
  }, name);
  if (!found) throw new Error(`the scene has no place with the class ${name}`);
  await page.mouse.move(found.x, found.y);
  return found;
}

/** Returns the number that an element shows. */
export async function number(page, selector) {
  return Number((await page.textContent(selector)).replace('−', '-').replace(/[^\d.-]/g, ''));
}

/** Checks that axe finds nothing serious on a page. */
export async function checkAccess(page) {
  await page.evaluate(readFileSync(new URL('node_modules/axe-core/axe.min.js', import.meta.url), 'utf8'));
  const result = await page.evaluate(() => globalThis.axe.run(document));
  assert.ok(result.passes.length > MIN_RULES, `axe has checked the page by ${result.passes.length} rules`);
  const serious = result.violations.filter(({ impact }) => impact === 'serious' || impact === 'critical');
  assert.deepEqual(serious.map(({ id, nodes }) => `${id}: ${nodes[0].html}`), []);
}

/** Returns what part of the free scene, or of a strip of it across, has about one of some colours, as the screen shows it. */
export async function share(page, colours, reach = 26, [from, to] = [0, 1]) {
  const free = await page.locator('#free').boundingBox();
  const clip = { ...free, x: free.x + from * free.width, width: (to - from) * free.width };
  const picture = (await page.screenshot({ clip })).toString('base64');
  return page.evaluate(async ([picture, colours, reach]) => {
    const image = new Image();
    image.src = `data:image/png;base64,${picture}`;
    await image.decode();
    const canvas = Object.assign(document.createElement('canvas'), { width: image.width, height: image.height });
    const context = canvas.getContext('2d');
    context.drawImage(image, 0, 0);
    const { data } = context.getImageData(0, 0, canvas.width, canvas.height);
    let count = 0;
    for (let i = 0; i < data.length; i += 4) {
      count += Number(colours.some((colour) => colour.every((part, k) => Math.abs(data[i + k] - part) < reach)));
    }
    return count / (data.length / 4);
  }, [picture, colours, reach]);
}

/** Drops files, names and contents, onto the page. */
export const drop = (page, files) => page.evaluate((list) => {
  const data = new DataTransfer();
  for (const [name, bytes] of list) data.items.add(new File([new Uint8Array(bytes)], name));
  dispatchEvent(new DragEvent('drop', { dataTransfer: data, bubbles: true, cancelable: true }));
}, files.map(([name, content]) => [name, [...Buffer.from(content)]]));
