// Helpers of the dashboard tests: start the service and the browser, open the page, collect its errors.

import { spawn } from 'node:child_process';
import { existsSync, mkdtempSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { chromium } from 'playwright-core';

/** Time limit of every wait, long enough for a slow machine, ms. */
export const TIMEOUT_MS = 120_000;

const FLAGS = [
  '--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run', '--disable-background-networking',
  '--disable-component-update', '--disable-sync',
];

/** Starts a headless browser. */
export function launch() {
  const executablePath = ['/usr/bin/chromium', '/usr/bin/chromium-browser'].find(existsSync);
  return chromium.launch({ executablePath, headless: true, timeout: TIMEOUT_MS, args: FLAGS });
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
  return { url, port: Number(new URL(url).port), stop };
}

/** Opens the page; its exceptions and console errors are added to `pageErrors`. */
export async function open(browser, url, options = {}) {
  const context = await browser.newContext({ viewport: { width: 1440, height: 900 }, ...options });
  const page = await context.newPage();
  page.setDefaultTimeout(TIMEOUT_MS);
  page.setDefaultNavigationTimeout(TIMEOUT_MS);
  const pageErrors = [];
  page.on('pageerror', (error) => pageErrors.push(String(error.stack)));
  // The browser itself logs failed requests. The page handles and shows them, so they are ignored here.
  page.on('console', (message) => {
    if (message.type() === 'error' && !message.text().startsWith('Failed to load resource')) pageErrors.push(message.text());
  });
  await page.goto(url);
  return { page, pageErrors, close: () => context.close() };
}

/** Waits until a pill (`connection` or `phase`) shows one of `values`. */
export function waitForState(page, pill, ...values) {
  const hasState = ([id, wanted]) => wanted.includes(document.getElementById(id)?.dataset[id]);
  return page.waitForFunction(hasState, [pill, values], { timeout: TIMEOUT_MS });
}

/** Moves the mouse over the scene until its canvas has a CSS class; returns the position of the mouse. */
export async function findInScene(page, name) {
  const { x, y, width, height } = await page.locator('#scene').boundingBox();
  for (let row = 20; row < height; row += 30) {
    for (let column = 20; column < width; column += 30) {
      await page.mouse.move(x + column, y + row);
      if (await page.evaluate((name) => document.getElementById('scene').classList.contains(name), name)) return { x: x + column, y: y + row };
    }
  }
  throw new Error(`the scene has no place with the class ${name}`);
}

/** Returns the number that an element shows. */
export async function number(page, selector) {
  return Number((await page.textContent(selector)).replace('−', '-').replace(/[^\d.-]/g, ''));
}
