// Measures how often the scene is drawn per second, with WebGL and on the canvas, and how the memory of the page grows. The browser
// draws without a graphics card, unless FRAMES_GPU=1 lets it use one. docs/dashboard.md has the figures. Run it after
// tests/browser/run:
//     REVPRIO=target/debug/revprio node target/browser/frames.mjs             drawings per second
//     REVPRIO=target/debug/revprio node target/browser/frames.mjs MINUTES     memory, on the canvas

import { TIMEOUT_MS, cleanUp, launch, open, serve, waitForState, waitForText } from './harness.mjs';

const [minutes = '0'] = process.argv.slice(2);
const measuresMemory = Number(minutes) > 0;

/** Time over which drawings are counted, s. */
const SECONDS = 8;

const LINKS = 8;

/** A chain of eight links with one mesh each. */
const URDF = `<robot name="chain"><link name="l0"/>${Array.from({ length: LINKS }, (_, i) => `
  <link name="l${i + 1}"><visual><geometry><mesh filename="ball.stl"/></geometry></visual></link>
  <joint name="j${i}" type="revolute"><parent link="l${i}"/><child link="l${i + 1}"/><origin xyz="0 0 0.13"/><axis xyz="${i % 2} ${1 - (i % 2)} 0"/>
  <limit lower="-3" upper="3" velocity="2" effort="1"/></joint>`).join('')}</robot>`;

/** A binary STL file of a ball with a number of triangles. */
function ball(count) {
  const rows = Math.round(Math.sqrt(count / 4));
  const place = (i, k) => {
    const [up, round] = [(Math.PI * i) / rows, (Math.PI * k) / rows];
    return [0.07 * Math.sin(up) * Math.cos(round), 0.07 * Math.sin(up) * Math.sin(round), 0.1 * Math.cos(up)];
  };
  const faces = [];
  for (let i = 0; i < rows; i += 1) {
    for (let k = 0; k < 2 * rows; k += 1) {
      faces.push([place(i, k), place(i + 1, k), place(i + 1, k + 1)], [place(i, k), place(i + 1, k + 1), place(i, k + 1)]);
    }
  }
  const file = Buffer.alloc(84 + 50 * faces.length);
  file.writeUInt32LE(faces.length, 80);
  faces.forEach((face, i) => face.flat().forEach((value, k) => file.writeFloatLE(value, 84 + 50 * i + 12 + 4 * k)));
  return file;
}

/** Drops the chain onto the page. */
async function dropChain(page, count) {
  const files = [['chain.urdf', Buffer.from(URDF)], ['ball.stl', ball(count / LINKS)]];
  await page.evaluate((list) => {
    const data = new DataTransfer();
    for (const [name, bytes] of list) data.items.add(new File([new Uint8Array(bytes)], name));
    dispatchEvent(new DragEvent('drop', { dataTransfer: data, bubbles: true, cancelable: true }));
  }, files.map(([name, bytes]) => [name, [...bytes]]));
  await waitForText(page, '#notice', /8 joints/);
  await page.selectOption('#motion', 'eight');
  await page.click('#go');
}

/** Returns drawings of the scene per second, and their number of pixels. */
async function rate(page) {
  const count = () => page.evaluate(() => Number(document.getElementById('scene').dataset.drawings));
  await page.waitForTimeout(3000);
  const [before, start] = [await count(), performance.now()];
  await page.waitForTimeout(1000 * SECONDS);
  const drawings = (1000 * (await count() - before)) / (performance.now() - start);
  const pixels = await page.evaluate(() => {
    const solid = document.getElementById('solid');
    const canvas = solid.hidden ? document.getElementById('scene') : solid;
    return `${canvas.width} × ${canvas.height}`;
  });
  return `${drawings.toFixed(1)} | ${pixels}`;
}

const usesCard = process.env.FRAMES_GPU === '1';
const browser = await launch({ webgl: true, card: usesCard });
const service = await serve();
if (measuresMemory) await printMemory(Number(minutes));
else await printRates();
cleanUp();
await browser.close();
process.exit(0);

/** Prints the drawings per second of both renderers. */
async function printRates() {
  console.log('| renderer | arm | drawings per second | pixels |\n|---|---|---|---|');
  for (const renderer of ['webgl', 'canvas']) {
    for (const count of [0, 6000, 60_000]) {
      const { page, close } = await open(browser, `${service.url}/?renderer=${renderer}#scenario=playground&robot=panda&motion=eight`);
      await waitForState(page, 'connection', 'ready');
      if (count > 0) await dropChain(page, count);
      await waitForState(page, 'phase', 'running');
      console.log(`| ${renderer} | ${count > 0 ? `${count} triangles, dropped` : 'Panda'} | ${await rate(page)} |`);
      await page.goto('about:blank');
      await close();
    }
  }
}

/** Prints the memory of the page while it runs. */
async function printMemory(total) {
  const { page } = await open(browser, `${service.url}/?renderer=canvas`);
  page.setDefaultTimeout(TIMEOUT_MS);
  const tools = await page.context().newCDPSession(page);
  await tools.send('HeapProfiler.enable');
  console.log('| minute | JavaScript heap after a collection, MB |\n|---|---|');
  for (let minute = 0; minute <= total; minute += 1) {
    await tools.send('HeapProfiler.collectGarbage');
    const { usedSize } = await tools.send('Runtime.getHeapUsage');
    if (minute % 2 === 0) console.log(`| ${minute} | ${(usedSize / 1e6).toFixed(1)} |`);
    const phase = await page.getAttribute('#phase', 'data-phase');
    if (phase === 'finished') await page.click('#go');
    if (minute < total) await page.waitForTimeout(60_000);
  }
}
