// What can be taken along: link, cycle, trace, figures.

import { DRAWINGS } from './figures.js';
import { element } from './notices.js';
import { methodName, toFragment } from './setup.js';
import { asCurl, asPython } from './snippets.js';
import { SvgSurface, escaped } from './svg.js';
import { printing } from './theme.js';
import { download } from './transport.js';

/**
 * @typedef {import('./desk.js').Desk} Desk
 * @typedef {import('./scene.js').Scene} Scene
 * @typedef {import('./controls.js').Attempt} Attempt
 */

const TRACES = { csv: 'text/csv', mcap: 'application/vnd.mcap' };

/** @type {(desk: Desk, scene: Scene, attempt: Attempt) => void} */
export function bind(desk, scene, attempt) {
  const act = (/** @type {string} */ id, /** @type {() => Promise<void>} */ work) => {
    element(id).onclick = () => attempt(work);
  };
  act('copy-link', () => copy('Link', link(desk)));
  act('copy-curl', async () => copy('curl command', asCurl(await desk.cycle())));
  act('copy-python', async () => copy('Python program', asPython(await desk.cycle())));
  act('export-csv', () => trace(desk, 'csv'));
  act('export-mcap', () => trace(desk, 'mcap'));
  act('export-svg', async () => save(new Blob([sheet(desk, scene)], { type: 'image/svg+xml' }), `${name(desk)}.svg`));
}

/** @type {(desk: Desk) => string} */
function link(desk) {
  const fragment = desk.setup && desk.scenario ? toFragment(desk.setup, desk.scenario) : '';
  return `${location.origin}/#${fragment}`;
}

/** @type {(what: string, text: string) => Promise<void>} */
async function copy(what, text) {
  try {
    await navigator.clipboard.writeText(text);
  } catch {
    copyOldWay(text);
  }
  say(`${what} copied (${text.length} characters).`);
}

/** Where a page may not use the clipboard: on an address without encryption. @type {(text: string) => void} */
function copyOldWay(text) {
  const field = document.createElement('textarea');
  field.value = text;
  document.body.append(field);
  field.select();
  document.execCommand('copy');
  field.remove();
}

/** @type {(text: string) => void} */
function say(text) {
  element('share-note').textContent = text;
}

/** @type {(desk: Desk) => string} */
function name(desk) {
  const { setup, run, watch } = desk;
  if (watch) return `session-${watch.session.id.slice(0, 8)}`;
  return `${setup?.scenario}-${run?.simulation.method ?? setup?.method}-${run?.simulation.solver ?? setup?.solver}`;
}

/** @type {(desk: Desk, format: 'csv' | 'mcap') => Promise<void>} */
async function trace(desk, format) {
  if (!desk.run) return;
  save(await download(`${desk.run.path}/trace`, TRACES[format]), `${name(desk)}.${format}`);
}

/** @type {(content: Blob, file: string) => void} */
function save(content, file) {
  const anchor = document.createElement('a');
  anchor.href = URL.createObjectURL(content);
  anchor.download = file;
  anchor.click();
  setTimeout(() => URL.revokeObjectURL(anchor.href), 10_000);
  say(`${file} saved.`);
}

const TITLES = {
  force: 'Contact force', velocities: 'Joint velocities', positions: 'Joint positions', residuals: 'Residual by priority',
  limits: 'Active limits', singularity: 'Smallest singular value', solver: 'Solve path and time', trips: 'Round trips',
};

/** All plots and the scene on one sheet. @type {(desk: Desk, scene: Scene) => string} */
function sheet(desk, scene) {
  const [wide, high, gap] = [460, 230, 24];
  const view = desk.view();
  const colours = printing();
  const picture = scene.canvas.toDataURL('image/png');
  const plots = Object.entries(TITLES).map(([plot, title], i) => {
    const surface = new SvgSurface();
    DRAWINGS[plot](/** @type {any} */ (surface), wide, high - 24, view, colours);
    const [x, y] = [gap + ((i + 1) % 3) * (wide + gap), 60 + Math.floor((i + 1) / 3) * (high + gap)];
    return `<g transform="translate(${x} ${y})"><text x="8" y="12" font-size="13" font-weight="600" fill="${colours.text}">${title}</text><g transform="translate(0 22)">${surface.text}</g></g>`;
  });
  const [width, height] = [3 * (wide + gap) + gap, 60 + 3 * (high + gap)];
  const title = `${desk.watch ? 'Session' : desk.setup?.scenario.replaceAll('_', ' ')}: ${methodName(desk.run?.simulation.method ?? desk.setup?.method ?? '')}`;
  return `<svg xmlns="http://www.w3.org/2000/svg" width="${width}" height="${height}" viewBox="0 0 ${width} ${height}" font-family="system-ui, sans-serif">
<rect width="100%" height="100%" fill="#ffffff"/><text x="${gap + 8}" y="36" font-size="20" font-weight="600" fill="${colours.text}">${escaped(title)}</text>
<image x="${gap}" y="60" width="${wide}" height="${high}" href="${picture}"/>
${plots.join('\n')}
</svg>
`;
}
