// A service, a browser, and a page that may not complain.

import { spawn } from 'node:child_process';
import { existsSync, mkdtempSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { chromium } from 'playwright-core';

/** Longer than anything takes on a busy machine, ms. */
export const PATIENCE = 120_000;

const FLAGS = [
  '--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run', '--disable-background-networking',
  '--disable-component-update', '--disable-sync',
];

/** Starts a browser without a screen. */
export function launch() {
  const executablePath = ['/usr/bin/chromium', '/usr/bin/chromium-browser'].find(existsSync);
  return chromium.launch({ executablePath, headless: true, timeout: PATIENCE, args: FLAGS });
}

/** Services that have not ended, as that of a test that failed. */
const alive = new Set();

/** Ends what tests have left behind. */
export function cleanUp() {
  for (const child of alive) child.kill('SIGKILL');
}

/** Starts the service; `port` 0 takes a free one. */
export async function serve(port = 0, token = '') {
  const options = ['serve', '--listen', `127.0.0.1:${port}`];
  if (token) {
    const file = join(mkdtempSync(join(tmpdir(), 'revprio-')), 'token');
    writeFileSync(file, token, { mode: 0o600 });
    options.push('--token-file', file);
  }
  const child = spawn(process.env.REVPRIO, options, { stdio: ['ignore', 'pipe', 'inherit'] });
  alive.add(child);
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
      alive.delete(child);
      child.kill(signal);
    });
  return { url, port: Number(new URL(url).port), stop };
}

/** Opens the page; what it complains about is kept in `complaints`. */
export async function open(browser, url, options = {}) {
  const context = await browser.newContext({ viewport: { width: 1440, height: 900 }, ...options });
  const page = await context.newPage();
  page.setDefaultTimeout(PATIENCE);
  page.setDefaultNavigationTimeout(PATIENCE);
  const complaints = [];
  page.on('pageerror', (error) => complaints.push(String(error.stack)));
  // A request that got no answer is logged by the browser itself; the page says so in its own words.
  page.on('console', (message) => {
    if (message.type() === 'error' && !message.text().startsWith('Failed to load resource')) complaints.push(message.text());
  });
  await page.goto(url);
  return { page, complaints, close: () => context.close() };
}

/** Waits for the state of the connection or of the run. */
export function until(page, pill, ...values) {
  const ask = ([id, wanted]) => wanted.includes(document.getElementById(id)?.dataset[id]);
  return page.waitForFunction(ask, [pill, values], { timeout: PATIENCE });
}

/** Moves the mouse over the scene until its canvas has a class; where that is. */
export async function spotOf(page, name) {
  const { x, y, width, height } = await page.locator('#scene').boundingBox();
  for (let row = 20; row < height; row += 30) {
    for (let column = 20; column < width; column += 30) {
      await page.mouse.move(x + column, y + row);
      if (await page.evaluate((name) => document.getElementById('scene').classList.contains(name), name)) return { x: x + column, y: y + row };
    }
  }
  throw new Error(`nowhere is the scene ${name}`);
}

/** The number that an element shows. */
export async function number(page, selector) {
  return Number((await page.textContent(selector)).replace('−', '-').replace(/[^\d.-]/g, ''));
}
