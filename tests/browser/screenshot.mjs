// Creates docs/dashboard.png. Run it after tests/browser/run:
//     node target/browser/screenshot.mjs FILE.png [SCENARIO [WIDTH [dark]]]

import { cleanUp, launch, open, serve, waitForState } from './harness.mjs';

const [file, scenario = 'stiff_wall_singular', width = '1440', colorScheme = 'light'] = process.argv.slice(2);
const browser = await launch({ webgl: true });
const service = await serve();
const viewport = { width: Number(width), height: 1000 };
const { page, close } = await open(browser, `${service.url}/?renderer=webgl#scenario=${scenario}&ghost=damped_least_squares`, { viewport, colorScheme });
await waitForState(page, 'connection', 'ready');
await page.click('#go');
await waitForState(page, 'phase', 'running');
await page.waitForFunction(() => Number.parseFloat(document.getElementById('clock').textContent) > 1.5);
// Paused, so that the slow software renderer shows everything at one time.
await page.click('#go');
await waitForState(page, 'phase', 'paused');
await page.waitForTimeout(1500);
await page.screenshot({ path: file });
await close();
await service.stop();
cleanUp();
await browser.close();
