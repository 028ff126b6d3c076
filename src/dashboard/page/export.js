// Exports: a link to the setup, the control cycle as a command, the trace, and the figures.

import { DRAWINGS, cards } from './figures.js';
import { element } from './notices.js';
import { GifRecorder, LONGEST } from './gif_recorder.js';
import { linkOf } from './link.js';
import { methodName } from './setup.js';
import { Recorder } from './recorder.js';
import { asCurl, asPython, asRos2 } from './snippets.js';
import { SvgSurface, escaped } from './svg.js';
import { printPalette } from './theme.js';
import { download } from './transport.js';
import { view } from './view.js';

/**
 * @typedef {import('./run_control.js').RunControl} RunControl
 * @typedef {import('./scene.js').Scene} Scene
 * @typedef {import('./controls.js').Attempt} Attempt
 */

const TRACES = { csv: 'text/csv', mcap: 'application/vnd.mcap' };

/** @type {(runControl: RunControl, scene: Scene, attempt: Attempt) => {addPicture: () => void}} */
export function bind(runControl, scene, attempt) {
  const act = (/** @type {string} */ id, /** @type {() => Promise<void>} */ work) => {
    element(id).onclick = () => attempt(work);
  };
  act('copy-link', async () => {
    const { link, lost } = await linkOf(runControl, scene);
    await copy('Link', link);
    if (lost) showNote(`Link copied (${link.length} characters). It does not have: ${lost}.`);
  });
  act('copy-curl', async () => copy('curl command', asCurl(await runControl.cycle())));
  act('copy-python', async () => copy('Python program', asPython(await runControl.cycle())));
  act('copy-ros2', async () => copy('ROS 2 commands', asRos2((await runControl.cycle()).controller)));
  act('export-csv', () => trace(runControl, 'csv'));
  act('export-mcap', () => trace(runControl, 'mcap'));
  act('export-svg', async () => {
    save(new Blob([figureSheet(runControl, scene)], { type: 'image/svg+xml' }), `${fileStem(runControl)}.svg`);
  });
  const recorder = new Recorder(scene, (film) => save(film, `${fileStem(runControl)}.webm`), () => showRecorder(recorder));
  act('record', async () => recorder.toggle());
  const gif = new GifRecorder(scene, (film, text) => save(film, `${fileStem(runControl)}.gif`, text), (progress) => showGif(gif, progress));
  act('record-gif', () => gif.toggle());
  return {
    addPicture: () => {
      recorder.addPicture();
      gif.addPicture();
    },
  };
}

/** @param {Recorder} recorder */
function showRecorder({ isRecording }) {
  element('record').textContent = isRecording ? 'End film' : 'Record';
  element('record').ariaPressed = String(isRecording);
}

/** @type {(gif: GifRecorder, progress: number | null) => void} */
function showGif({ isRecording }, progress) {
  const button = /** @type {HTMLButtonElement} */ (element('record-gif'));
  button.textContent = isRecording ? 'End GIF' : 'GIF';
  button.ariaPressed = String(isRecording);
  button.disabled = progress !== null;
  if (isRecording) showNote(`Recording for at most ${LONGEST / 1000} s.`);
  if (progress !== null) showNote(`Encoding the GIF: ${Math.round(100 * progress)} %.`);
}

/** @type {(what: string, text: string) => Promise<void>} */
async function copy(what, text) {
  try {
    await navigator.clipboard.writeText(text);
  } catch {
    copyWithSelection(text);
  }
  showNote(`${what} copied (${text.length} characters).`);
}

/** Copies where the clipboard API is not available, as on addresses without encryption. @type {(text: string) => void} */
function copyWithSelection(text) {
  const field = document.createElement('textarea');
  field.value = text;
  document.body.append(field);
  field.select();
  document.execCommand('copy');
  field.remove();
}

/** @type {(text: string) => void} */
function showNote(text) {
  element('share-note').textContent = text;
}

/** @type {(runControl: RunControl) => string} */
function fileStem(runControl) {
  const { setup, run, watch } = runControl;
  if (watch) return `session-${watch.session.id.slice(0, 8)}`;
  return `${setup?.scenario}-${run?.simulation.method ?? setup?.method}-${run?.simulation.solver ?? setup?.solver}`;
}

/** @type {(runControl: RunControl, format: 'csv' | 'mcap') => Promise<void>} */
async function trace(runControl, format) {
  if (!runControl.run) return;
  save(await download(`${runControl.run.path}/trace`, TRACES[format]), `${fileStem(runControl)}.${format}`);
}

/** @type {(content: Blob, file: string, text?: string) => void} */
function save(content, file, text = '') {
  const anchor = document.createElement('a');
  anchor.href = URL.createObjectURL(content);
  anchor.download = file;
  anchor.click();
  setTimeout(() => URL.revokeObjectURL(anchor.href), 10_000);
  showNote(`${file} saved${text ? `: ${text}` : ''}.`);
}

const TITLES = {
  force: 'Contact force', pose: 'Pose error', velocities: 'Joint velocities', positions: 'Joint positions', residuals: 'Residual by priority',
  limits: 'Active limits', singularity: 'Smallest singular value', solver: 'Solver path and time', trips: 'Round trips',
};

/** Returns an SVG with the scene and all plots. @type {(runControl: RunControl, scene: Scene) => string} */
function figureSheet(runControl, scene) {
  const [wide, high, gap] = [460, 230, 24];
  const data = view(runControl);
  const hidden = new Set(Array.from(cards()).filter((card) => card.hidden).map((card) => card.dataset.plot));
  const colours = printPalette();
  const canvas = document.createElement('canvas');
  scene.paint(canvas);
  const picture = canvas.toDataURL('image/png');
  const plots = Object.entries(TITLES).filter(([plot]) => !hidden.has(plot)).map(([plot, title], i) => {
    const surface = new SvgSurface();
    DRAWINGS[plot](/** @type {any} */ (surface), wide, high - 24, data, colours);
    const [x, y] = [gap + ((i + 1) % 3) * (wide + gap), 60 + Math.floor((i + 1) / 3) * (high + gap)];
    return `<g transform="translate(${x} ${y})"><text x="8" y="12" font-size="13" font-weight="600" fill="${colours.text}">${title}</text><g transform="translate(0 22)">${surface.text}</g></g>`;
  });
  const [width, height] = [3 * (wide + gap) + gap, 60 + Math.ceil((plots.length + 1) / 3) * (high + gap)];
  const title = `${runControl.watch ? 'Session' : runControl.setup?.scenario.replaceAll('_', ' ')}: ${methodName(runControl.run?.simulation.method ?? runControl.setup?.method ?? '')}`;
  return `<svg xmlns="http://www.w3.org/2000/svg" width="${width}" height="${height}" viewBox="0 0 ${width} ${height}" font-family="system-ui, sans-serif">
<rect width="100%" height="100%" fill="#ffffff"/><text x="${gap + 8}" y="36" font-size="20" font-weight="600" fill="${colours.text}">${escaped(title)}</text>
<image x="${gap}" y="60" width="${wide}" height="${high}" href="${picture}"/>
${plots.join('\n')}
</svg>
`;
}
