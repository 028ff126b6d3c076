// The scene of docs/dashboard.png: a Panda after one round of its figure of eight, at the same simulated time in every run.

import { open, waitForClock, waitForState } from './harness.mjs';

/** Periods of 4 ms, 8 s: a little more than one round. */
const PERIODS = 2000;

/** Opens the scene, drawn with WebGL; afterwards its window has 1440 × 900 px. */
export async function openReadmeScene(browser, url, context = {}) {
  const address = `${url}/?renderer=webgl#scenario=playground&robot=panda&motion=eight`;
  const opened = await open(browser, address, { viewport: { width: 1440, height: 900 }, reducedMotion: 'reduce', ...context });
  const { page } = opened;
  await waitForState(page, 'connection', 'ready');
  await page.evaluate((periods) => document.getElementById('step-size').add(new Option('100', String(periods), false, true)), PERIODS);
  await page.click('#step');
  await waitForClock(page, 7.99);
  // The camera depends on how often the arm was drawn, unless it fits the arm now.
  await page.focus('#scene');
  await page.keyboard.press('0');
  await page.evaluate(() => document.activeElement.blur());
  await page.mouse.move(720, 4);
  // The camera comes to rest, and the pixels are as fine as the machine can draw them.
  await page.waitForTimeout(4000);
  return opened;
}
