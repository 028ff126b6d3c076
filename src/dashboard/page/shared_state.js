// The part of the setup that a link stores as one JSON text: planes, obstacles and moved targets; and the view of the camera.

/**
 * @typedef {import('./setup.js').Setup} Setup
 * @typedef {import('./geometry.js').Camera} Camera
 */

/** Longest text that is read. */
const MAX_LENGTH = 20_000;

/** @type {(setup: Setup) => string} empty if nothing was added or moved */
export function toText({ planes, obstacles, targets }) {
  const state = {
    ...(planes.length > 0 && { planes }), ...(obstacles && { obstacles }), ...(Object.keys(targets).length > 0 && { targets: rounded(targets) }),
  };
  return Object.keys(state).length > 0 ? JSON.stringify(state) : '';
}

/** Returns whether a text has a part that `fromText` leaves out. @type {(text: string | null) => boolean} */
export function isDamaged(text) {
  if (!text) return false;
  const read = Object.keys(fromText(text)).length;
  try {
    return read < Object.keys(JSON.parse(text)).length;
  } catch {
    return true;
  }
}

/** Reads what `toText` wrote; invalid parts are left out. @type {(text: string | null) => Partial<Setup>} */
export function fromText(text) {
  if (!text || text.length > MAX_LENGTH) return {};
  /** @type {any} */
  let state;
  try {
    state = JSON.parse(text);
  } catch {
    return {};
  }
  if (typeof state !== 'object' || state === null) return {};
  /** @type {Partial<Setup>} */
  const read = {};
  if (Array.isArray(state.planes) && state.planes.every(isPlane)) read.planes = state.planes;
  if (Array.isArray(state.obstacles) && state.obstacles.every(isObstacle)) read.obstacles = state.obstacles;
  if (isTargets(state.targets)) read.targets = state.targets;
  return read;
}

/** @type {(value: unknown) => value is number} */
const isNumber = (value) => typeof value === 'number' && Number.isFinite(value);

/** @type {(value: unknown) => boolean} */
const isPlace = (value) => Array.isArray(value) && value.length === 3 && value.every(isNumber);

/** @type {(plane: any) => boolean} */
const isPlane = (plane) => typeof plane?.name === 'string' && ['plane', 'wall'].includes(plane.kind) && /^[+−][xyz]$/.test(plane.side) && isNumber(plane.offset);

/** Whether an obstacle can be drawn; the service checks the numbers. @type {(obstacle: any) => boolean} */
function isObstacle(obstacle) {
  const { name, sphere, capsule, box, half_space: half } = obstacle ?? {};
  const pose = box?.pose;
  const isPose = !pose || isPlace(pose.position);
  const isTurn = !pose?.orientation || ['w', 'x', 'y', 'z'].every((part) => isNumber(pose.orientation[part]));
  const forms = [
    sphere && isNumber(sphere.radius) && (sphere.center === undefined || isPlace(sphere.center)),
    capsule && isNumber(capsule.radius) && isPlace(capsule.start) && isPlace(capsule.end),
    box && isPlace(box.size) && isPose && isTurn,
    half && isPlace(half.normal) && isNumber(half.offset_m),
  ];
  return typeof name === 'string' && forms.some(Boolean);
}

/** @type {(targets: any) => boolean} */
function isTargets(targets) {
  if (typeof targets !== 'object' || targets === null || Array.isArray(targets)) return false;
  const isTurn = (/** @type {any} */ turn) => ['w', 'x', 'y', 'z'].every((part) => isNumber(turn?.[part]));
  return Object.values(targets).every((/** @type {any} */ pose) => isPlace(pose?.position) && isTurn(pose?.orientation));
}

/** @type {(targets: Setup['targets']) => unknown} shorter numbers, to a micrometre */
const rounded = (targets) => JSON.parse(JSON.stringify(targets), (_, value) => (isNumber(value) ? Math.round(value * 1e6) / 1e6 : value));

/** @type {(camera: Camera) => string} */
export const viewText = ({ azimuth, elevation, distance, target }) =>
  [azimuth, elevation, distance, ...target].map((value) => Number(value.toFixed(3))).join(',');

/** Returns a view of the camera; null if the text has none. @type {(text: string | null) => Pick<Camera, 'azimuth' | 'elevation' | 'distance' | 'target'> | null} */
export function viewOf(text) {
  const values = (text ?? '').split(',').map(Number);
  if (values.length !== 6 || !values.every(Number.isFinite)) return null;
  const [azimuth, elevation, distance, x, y, z] = values;
  return { azimuth, elevation, distance, target: [x, y, z] };
}
