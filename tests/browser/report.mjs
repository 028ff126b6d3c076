// Tests of the page that `revprio demo` writes.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { pathToFileURL } from 'node:url';

import { TIMEOUT_MS, checkAccess, launch, open } from './harness.mjs';

const options = { timeout: 4 * TIMEOUT_MS };

/** Largest height of the page at 1280 px, as it opens, px: the story, and the tables that are open. */
const MAX_HEIGHT = 7000;

let browser;
let folder;
before(async () => {
  folder = mkdtempSync(join(tmpdir(), 'revprio-demo-'));
  execFileSync(process.env.REVPRIO, ['demo', '--out', folder], { stdio: 'ignore' });
  browser = await launch();
}, options);
after(async () => {
  await browser?.close();
  rmSync(folder, { recursive: true, force: true });
});

for (const [width, height] of [[1280, 800], [390, 844]]) {
  test(`the report of the demo fits ${width} px, and axe finds nothing serious, light and dark`, options, async () => {
    const address = pathToFileURL(join(folder, 'index.html')).href;
    const { page, pageErrors, close } = await open(browser, address, { viewport: { width, height }, colorScheme: 'light' });
    const size = () => page.evaluate(() => [document.documentElement.scrollWidth, document.documentElement.scrollHeight]);
    const [wide, high] = await size();
    assert.ok(wide <= width, `${wide} px on ${width}`);
    if (width === 1280) assert.ok(high > 1000 && high < MAX_HEIGHT, `${high} px high`);
    await page.evaluate(() => document.querySelectorAll('details').forEach((part) => { part.open = true; }));
    const [openWide, openHigh] = await size();
    assert.ok(openWide <= width, `${openWide} px on ${width} with everything open`);
    assert.ok(openHigh > high, 'details open');
    for (const colorScheme of ['light', 'dark']) {
      await page.emulateMedia({ colorScheme });
      await checkAccess(page);
    }
    assert.deepEqual(pageErrors, []);
    await close();
  });
}
