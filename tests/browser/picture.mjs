// Takes the picture that the README shows again, and compares it with the file: the places of the panels, and coarse colours.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { after, before, test } from 'node:test';

import { TIMEOUT_MS, cleanUp, launch, serve } from './harness.mjs';
import { openReadmeScene } from './readme_scene.mjs';

/** Width and height of a cell over which colours are averaged, px: texts of other fonts have the same mean. */
const CELL = 30;

/** Difference of a mean colour from which a cell is another one, of 255, and the largest part of such cells. */
const OTHER = 16;
const MOST = 0.02;

/** The parts of the page that must not cover each other. */
const PARTS = ['header.top', '#setup', '#plots', '.corner.left', '.corner.right', '#swing', '#shapes', '.dock'];

let browser;
let service;
before(async () => {
  browser = await launch({ webgl: true });
  service = await serve();
}, { timeout: TIMEOUT_MS });
after(async () => {
  cleanUp();
  await browser?.close();
});

/** Returns which part of the cells of two PNG pictures has other colours. */
function difference(page, one, other) {
  return page.evaluate(async ([texts, size, most]) => {
    const cells = await Promise.all(texts.map(async (text) => {
      const image = new Image();
      image.src = `data:image/png;base64,${text}`;
      await image.decode();
      const canvas = Object.assign(document.createElement('canvas'), { width: image.width, height: image.height });
      const context = canvas.getContext('2d');
      context.drawImage(image, 0, 0);
      const [columns, rows] = [image.width, image.height].map((length) => Math.floor(length / size));
      return Array.from({ length: columns * rows }, (_, i) => {
        const { data } = context.getImageData((i % columns) * size, Math.floor(i / columns) * size, size, size);
        return [0, 1, 2].map((part) => data.reduce((sum, value, k) => sum + (k % 4 === part ? value : 0), 0) / size ** 2);
      });
    }));
    if (cells[0].length !== cells[1].length) return 1;
    const others = cells[0].filter((cell, i) => cell.some((value, part) => Math.abs(value - cells[1][i][part]) > most));
    return others.length / cells[0].length;
  }, [[one, other].map((data) => data.toString('base64')), CELL, OTHER]);
}

/** Returns the pairs of parts that cover each other, and the parts that leave the window. */
function misplaced(page) {
  return page.evaluate((names) => {
    const boxes = names.map((name) => ({ name, box: document.querySelector(name).getBoundingClientRect() })).filter(({ box }) => box.width > 0);
    const cover = (a, b) => Math.min(a.right, b.right) - Math.max(a.left, b.left) > 1 && Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 1;
    const pairs = boxes.flatMap((one, i) => boxes.slice(i + 1).filter((other) => cover(one.box, other.box)).map((other) => `${one.name} and ${other.name}`));
    const outside = boxes.filter(({ box }) => box.left < 0 || box.top < 0 || box.right > innerWidth || box.bottom > innerHeight).map(({ name }) => name);
    return [...pairs, ...outside];
  }, PARTS);
}

test('the page looks like the picture of the README', { timeout: 4 * TIMEOUT_MS }, async () => {
  const picture = readFileSync(new URL('../../docs/dashboard.png', import.meta.url));
  const { page, pageErrors, close } = await openReadmeScene(browser, service.url);
  const share = async () => difference(page, picture, await page.screenshot());
  try {
    assert.deepEqual(await misplaced(page), []);
    const same = await share();
    assert.ok(same < MOST, `${(100 * same).toFixed(1)} % of the cells differ; renew docs/dashboard.png if that is right (tests/browser/screenshot.mjs)`);
    // The comparison finds what it is for: a missing arm, and a panel that covers another part.
    await page.evaluate(() => { document.getElementById('solid').style.opacity = '0'; });
    const withoutArm = await share();
    assert.ok(withoutArm > 2 * MOST, `without the arm ${withoutArm}`);
    await page.evaluate(() => { document.getElementById('solid').style.opacity = ''; document.getElementById('plots').style.translate = '-300px'; });
    const covered = await share();
    assert.ok(covered > 2 * MOST, `with a covered scene ${covered}`);
    assert.match((await misplaced(page)).join(), /#plots and \.corner\.right/);
    assert.deepEqual(pageErrors, []);
  } finally {
    await page.goto('about:blank');
    await close();
  }
});
