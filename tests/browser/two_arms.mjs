// Creates docs/guides/two-arms.png. Run it after tests/browser/run:
//     node target/browser/two_arms.mjs FILE.png

import { readFile } from 'node:fs/promises';

import { cleanUp, launch, open, serve, waitForState } from './harness.mjs';

const [file] = process.argv.slice(2);
const browser = await launch({ webgl: true });
const service = await serve();
const call = async (path, body) => (await fetch(service.url + path, { method: 'POST', headers: { 'content-type': 'application/json' }, body: JSON.stringify(body) })).json();
await call('/v1/robots', JSON.parse(await readFile('api/examples/robot_two_arms.json', 'utf8')));
const task = { axes: ['x', 'y', 'rz'], law: { kind: 'pose', gain: 4 } };
const tasks = [{ name: 'part', link: 'right', relative_to: 'left', ...task }, { name: 'carry', link: 'left', ...task }];
const { id } = await call('/v1/controllers', { robot: 'two-arms', period_s: 0.01, tasks });
const { page, close } = await open(browser, `${service.url}/?renderer=webgl#scenario=stiff_wall`, { viewport: { width: 1440, height: 1000 } });
await waitForState(page, 'connection', 'ready');
await page.click('text=Live session');
await waitForState(page, 'phase', 'watching');
await call(`/v1/controllers/${id}/step`, { sequence: 0, time_s: 0, joint_position: [0.1, 0.6, -0.9, 0.3, -0.6, 0.9, -0.3] });
await page.waitForTimeout(3000);
await page.screenshot({ path: file, clip: await page.locator('#free').boundingBox() });
await close();
await service.stop();
cleanUp();
await browser.close();
