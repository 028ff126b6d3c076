// Creates docs/dashboard.png, drawn with WebGL. Run it after tests/browser/run:
//     node target/browser/screenshot.mjs FILE.png [SETUP [WIDTH [dark]]]
// SETUP is the fragment of the page's address; if it is missing, the picture is that of the README.

import { cleanUp, launch, open, serve, waitForClock, waitForState } from './harness.mjs';
import { openReadmeScene } from './readme_scene.mjs';

const [file, setup = '', width = '1440', colorScheme = 'light'] = process.argv.slice(2);

/** Simulated time of the picture of a setup, s: the end of most scenarios. */
const TIME = 2.5;

const browser = await launch({ webgl: true });
const service = await serve();
const context = { viewport: { width: Number(width), height: 900 }, colorScheme };
const { page, close } = setup ? await open(browser, `${service.url}/?renderer=webgl#${setup}`, context) : await openReadmeScene(browser, service.url, context);
if (setup) {
  await waitForState(page, 'connection', 'ready');
  await page.click('#go');
  await waitForClock(page, TIME);
}
await page.screenshot({ path: file });
await page.goto('about:blank');
await close();
await service.stop();
cleanUp();
await browser.close();
