// Creates docs/dashboard.png, drawn with WebGL. Run it after tests/browser/run:
//     node target/browser/screenshot.mjs FILE.png [SETUP [WIDTH [dark]]]
// SETUP is the fragment of the page's address. The page is shown as it opens if it is missing.

import { cleanUp, launch, open, serve, waitForClock, waitForState } from './harness.mjs';

const [file, setup = '', width = '1440', colorScheme = 'light'] = process.argv.slice(2);

/** Simulated time of the picture, s: one round of the figure of eight, or the end of most scenarios. */
const TIME = setup ? 2.5 : 8;

const browser = await launch({ webgl: true });
const service = await serve();
const viewport = { width: Number(width), height: 900 };
const { page, close } = await open(browser, `${service.url}/?renderer=webgl#${setup}`, { viewport, colorScheme });
await waitForState(page, 'connection', 'ready');
if (setup) await page.click('#go');
await waitForClock(page, TIME);
await page.screenshot({ path: file });
await page.goto('about:blank');
await close();
await service.stop();
cleanUp();
await browser.close();
