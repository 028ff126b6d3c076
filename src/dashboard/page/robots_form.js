// The choice of the robot: built in, registered, or a URDF file with its meshes, dropped onto the page.

import { select as selectScenario } from './editing.js';
import { element, notify } from './notices.js';
import { PLAYGROUND } from './setup.js';
import { state } from './state.js';
import { ApiError, post, removeNow } from './transport.js';
import { parseUrdf } from './urdf.js';
import { loadVisuals } from './visuals.js';
import { unzip } from './zip.js';

/**
 * @typedef {import('./run_control.js').RunControl} RunControl
 * @typedef {import('./controls.js').Attempt} Attempt
 * @typedef {import('./types.js').Robot} Robot
 * @typedef {import('./types.js').RobotRegistration} RobotRegistration
 * @typedef {import('./urdf.js').Urdf} Urdf
 * @typedef {import('./drop.js').Files} Files
 */

/** Maximum number of meshes that a message names. */
const MAX_NAMES = 4;

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
}

/** Returns the files with those of zip files among them. @type {(given: Files) => Promise<Files>} */
async function unpacked(given) {
  /** @type {Files} */
  const files = new Map();
  for (const [path, file] of given) {
    const inner = /\.zip$/i.test(path) ? await unzip(file) : new Map([[path, file]]);
    for (const [name, content] of inner) files.set(name, content);
  }
  return files;
}

/** Registers the robot of a URDF file and shows it. @type {(runControl: RunControl, given: Files) => Promise<void>} */
export async function register(runControl, given) {
  const files = await unpacked(given);
  const found = [/\.urdf$/i, /\.xml$/i].map((ending) => [...files].find(([name]) => ending.test(name)));
  const [path, file] = found[0] ?? found[1] ?? [];
  if (!file || !path) {
    notify('No URDF file', 'Drop a file that ends with .urdf, together with its meshes (STL, OBJ, Collada or glTF) or their folder, or a zip file of both.');
    return;
  }
  const urdf = await file.text();
  const parsed = parseUrdf(urdf);
  const stem = path.replace(/\.\w+$/, '');
  const stated = await overrides(files.get(`${stem}.json`));
  const name = robotName(parsed.name || stem.replace(/^.*\//, ''));
  const registered = await registerChain({ ...stated, name, urdf });
  if (!registered) return;
  const { robot, registration } = registered;
  runControl.dropped.set(name, registration);
  const model = named(parsed, stated.joint_names ?? {}, robot.chain?.base ?? parsed.root);
  const { visuals, missing, unreadable } = await loadVisuals(model, files);
  runControl.visuals.set(name, visuals);
  await runControl.loadRobots();
  // The page shows the robot in a scenario of its own, not in the session of another client.
  if (state.value.source === 'session') await runControl.leaveSession();
  await selectScenario(runControl, PLAYGROUND, name);
  runControl.showSetup();
  const shown = `${visuals.shapes.length} shapes`;
  const lost = missing.length > 0 ? ` Not found: ${listed(missing)}. Drop their folder too.` : '';
  const broken = unreadable.length > 0 ? ` Not readable: ${listed(unreadable)}. STL, OBJ, Collada and glTF are read.` : '';
  const detail = `Registered with ${robot.joints.length} joints and ${shown}. ${chainText(robot)}${lost}${broken}`;
  notify(`Robot ${name}`, detail, { info: missing.length + unreadable.length === 0 });
}

/** @type {(names: string[]) => string} */
function listed(names) {
  const more = names.length > MAX_NAMES ? ` and ${names.length - MAX_NAMES} more` : '';
  return `${names.slice(0, MAX_NAMES).join(', ')}${more}`;
}

/** Reads the fields of the registration from the file beside the URDF file. @type {(file: File | undefined) => Promise<Partial<RobotRegistration>>} */
async function overrides(file) {
  if (!file) return {};
  try {
    return JSON.parse(await file.text());
  } catch {
    throw new Error(`${file.name} is not JSON; it states limits, joint_names, tool_offset, base or tip of the robot`);
  }
}

/**
 * Registers the robot. If the service cannot tell which links are its ends, asks for them.
 * @type {(registration: RobotRegistration) => Promise<{robot: Robot, registration: RobotRegistration} | null>} null if the user cancels
 */
async function registerChain(registration) {
  try {
    return { robot: await post('/v1/robots', registration), registration };
  } catch (error) {
    if (!(error instanceof ApiError)) throw error;
    // The service checks the name last, so it accepts the robot in place of the one before.
    if (error.status === 409) {
      await removeNow(`/v1/robots/${registration.name}`);
      return { robot: await post('/v1/robots', registration), registration };
    }
    const { pointer, candidates = [], detail } = error.problem;
    const field = pointer === '/tip' ? 'tip' : 'base';
    if (pointer !== `/${field}` || candidates.length === 0 || registration[field]) throw error;
    const link = await askForLink(field, detail, candidates);
    return link ? registerChain({ ...registration, [field]: link }) : null;
  }
}

/** Names the chain, why it ends there, and the joints that are no part of it. @type {(robot: Robot) => string} */
function chainText({ chain }) {
  if (!chain) return '';
  const reason = chain.reason.replaceAll('_', ' ');
  const shown = chain.left_out.slice(0, 6).map(({ joint, reason: why }) => `${joint} (${why.replaceAll('_', ' ')})`);
  const more = chain.left_out.length > shown.length ? ` and ${chain.left_out.length - shown.length} more` : '';
  const leftOut = shown.length > 0 ? ` Left out: ${shown.join(', ')}${more}.` : '';
  return `Chain from ${chain.base} to ${chain.tip} (${reason}).${leftOut}`;
}

/** Returns the model with the names of joints that requests use. @type {(model: Urdf, names: Record<string, string>, root: string) => Urdf} */
export function named(model, names, root) {
  const renamed = (/** @type {string} */ name) => names[name] ?? name;
  const joints = model.joints.map((joint) => ({
    ...joint,
    name: renamed(joint.name),
    mimic: joint.mimic && { ...joint.mimic, joint: renamed(joint.mimic.joint) },
  }));
  return { ...model, root, joints };
}

/** @type {(text: string) => string} */
function robotName(text) {
  const name = text.replace(/[^A-Za-z0-9_.-]/g, '_').replace(/^[^A-Za-z0-9]+/, '').slice(0, 50);
  return `my_${name || 'robot'}`;
}

/** Asks for a link; null if the user cancels. @type {(field: 'base' | 'tip', detail: string, links: string[]) => Promise<string | null>} */
function askForLink(field, detail, links) {
  /** @type {HTMLDialogElement} */
  const dialog = element('tip-dialog');
  /** @type {HTMLSelectElement} */
  const choice = element('tip-link');
  element('tip-title').textContent = field === 'tip' ? 'Which link is the tool?' : 'Which link is the base?';
  element('tip-detail').textContent = `The service says: ${detail}.`;
  choice.replaceChildren(...links.map((link) => new Option(link, link)));
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
