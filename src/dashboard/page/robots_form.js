// The choice of the robot: built in, registered, or a URDF file with its meshes, dropped onto the page.

import { select as selectScenario } from './editing.js';
import { element, notify } from './notices.js';
import { PLAYGROUND } from './setup.js';
import { post, removeNow } from './transport.js';
import { parseUrdf } from './urdf.js';
import { loadVisuals } from './visuals.js';

/**
 * @typedef {import('./run_control.js').RunControl} RunControl
 * @typedef {import('./controls.js').Attempt} Attempt
 * @typedef {Map<string, File>} Files files by path
 */

/** @type {(runControl: RunControl, attempt: Attempt) => void} */
export function bind(runControl, attempt) {
  /** @type {HTMLSelectElement} */
  const robot = element('robot');
  robot.onchange = () => attempt(async () => {
    await selectScenario(runControl, PLAYGROUND, robot.value);
    runControl.showSetup();
  });
  /** @type {HTMLInputElement} */
  const picker = element('urdf');
  picker.onchange = () => attempt(async () => {
    const files = new Map(Array.from(picker.files ?? [], (file) => [file.webkitRelativePath || file.name, file]));
    await register(runControl, files);
    picker.value = '';
  });
  bindDrop(runControl, attempt);
}

/** @type {(runControl: RunControl, attempt: Attempt) => void} */
function bindDrop(runControl, attempt) {
  const hasFiles = (/** @type {DragEvent} */ event) => event.dataTransfer?.types.includes('Files') ?? false;
  addEventListener('dragover', (event) => {
    if (!hasFiles(event)) return;
    event.preventDefault();
    document.body.classList.add('dropping');
  });
  addEventListener('dragleave', (event) => {
    if (!event.relatedTarget) document.body.classList.remove('dropping');
  });
  addEventListener('drop', (event) => {
    document.body.classList.remove('dropping');
    if (!hasFiles(event)) return;
    event.preventDefault();
    // The list of items is empty after this event, so it is read at once.
    const items = Array.from(event.dataTransfer?.items ?? []).filter(({ kind }) => kind === 'file');
    const entries = items.map((item) => item.webkitGetAsEntry()).filter((entry) => entry !== null);
    const plain = Array.from(event.dataTransfer?.files ?? []);
    attempt(async () => {
      const files = entries.length > 0 ? await filesOf(entries) : new Map(plain.map((file) => [file.name, file]));
      await register(runControl, files);
    });
  });
}

/** Returns the files of entries and their folders. @type {(entries: FileSystemEntry[]) => Promise<Files>} */
async function filesOf(entries) {
  /** @type {Files} */
  const files = new Map();
  const read = async (/** @type {FileSystemEntry} */ entry) => {
    if (entry.isFile) {
      const file = await new Promise((resolve, reject) => /** @type {FileSystemFileEntry} */ (entry).file(resolve, reject));
      files.set(entry.fullPath.replace(/^\//, ''), file);
      return;
    }
    const reader = /** @type {FileSystemDirectoryEntry} */ (entry).createReader();
    for (;;) {
      // A reader returns the entries of a folder in parts.
      /** @type {FileSystemEntry[]} */
      const part = await new Promise((resolve, reject) => reader.readEntries(resolve, reject));
      if (part.length === 0) return;
      for (const child of part) await read(child);
    }
  };
  for (const entry of entries) await read(entry);
  return files;
}

/** Registers the robot of a URDF file and shows it. @type {(runControl: RunControl, files: Files) => Promise<void>} */
async function register(runControl, files) {
  const [path, file] = [...files].find(([name]) => /\.(urdf|xml)$/i.test(name)) ?? [];
  if (!file || !path) {
    notify('No URDF file', 'Drop a file that ends with .urdf, together with its meshes (STL or OBJ) or their folder.');
    return;
  }
  const urdf = await file.text();
  const model = parseUrdf(urdf);
  const tip = model.leaves.length > 1 ? await askForTip(model.leaves, model.longest) : null;
  if (model.leaves.length > 1 && !tip) return;
  const name = robotName(model.name || path.replace(/^.*\//, '').replace(/\.\w+$/, ''));
  const known = runControl.robots.find((robot) => robot.name === name);
  if (known) await removeNow(`/v1/robots/${name}`);
  await post('/v1/robots', { name, urdf, tip });
  const { visuals, missing } = await loadVisuals(model, files);
  runControl.visuals.set(name, visuals);
  await runControl.loadRobots();
  await selectScenario(runControl, PLAYGROUND, name);
  runControl.showSetup();
  const shown = `${visuals.shapes.length} shapes`;
  const lost = missing.length > 0 ? ` Not found or not readable: ${missing.slice(0, 4).join(', ')}. Drop their folder too, as STL or OBJ.` : '';
  notify(`Robot ${name}`, `Registered with ${runControl.robot?.joints.length ?? 0} joints and ${shown}.${lost}`, { info: missing.length === 0 });
}

/** @type {(text: string) => string} */
function robotName(text) {
  const name = text.replace(/[^A-Za-z0-9_.-]/g, '_').replace(/^[^A-Za-z0-9]+/, '').slice(0, 50);
  return `my_${name || 'robot'}`;
}

/** Asks for the link of the tool; null if the user cancels. @type {(leaves: string[], longest: string) => Promise<string | null>} */
function askForTip(leaves, longest) {
  /** @type {HTMLDialogElement} */
  const dialog = element('tip-dialog');
  /** @type {HTMLSelectElement} */
  const choice = element('tip-link');
  choice.replaceChildren(...leaves.map((leaf) => new Option(leaf, leaf, false, leaf === longest)));
  dialog.returnValue = '';
  dialog.showModal();
  return new Promise((resolve) => {
    dialog.onclose = () => resolve(dialog.returnValue === 'ok' ? choice.value : null);
  });
}

/** Shows the robots in the list. @type {(runControl: RunControl) => void} */
export function showRobots({ robots, scenario }) {
  /** @type {HTMLSelectElement} */
  const robot = element('robot');
  robot.replaceChildren(...robots.map(({ name }) => new Option(name, name)));
  robot.value = scenario?.controller.robot ?? '';
}
