// Light and dark colours. The curves use the palette of Okabe and Ito, which colour-blind readers can distinguish.

/**
 * @typedef {object} Palette
 * @property {boolean} dark
 * @property {string} text
 * @property {string} muted
 * @property {string} grid
 * @property {string} card
 * @property {string} scene background of the scene, top
 * @property {string} ground background of the scene, bottom
 * @property {string[]} axes curves of x, y, z; also of the tasks, highest first
 * @property {string} ghost
 * @property {string[]} ghosts one colour for each ghost; the first is `ghost`
 * @property {string} goal the target in the scene
 * @property {string} alarm active limits, warnings
 * @property {string} allowed allowed ranges
 * @property {string} accent
 * @property {Record<'closed_form' | 'active_set' | 'qp', string>} paths
 * @property {Record<import('./arm.js').Material, import('./shading.js').Rgb>} materials
 * @property {import('./webgl.js').Look} look light and background of the scene with WebGL
 * @property {{shape: import('./shading.js').Rgb, obstacle: import('./shading.js').Rgb} & Record<import('./room.js').Level, string>} room shapes of links, obstacles, and lines between pairs
 */

/** @type {Palette} */
const LIGHT = {
  dark: false,
  text: '#1b2530',
  muted: '#5b6875',
  grid: '#e3e8ee',
  card: '#ffffff',
  scene: '#f3f6fa',
  ground: '#dfe6ee',
  axes: ['#0072b2', '#d55e00', '#009e73'],
  ghost: '#b5568f',
  ghosts: ['#b5568f', '#00838f', '#8a6d00', '#5a6b7d', '#8d5a3c', '#4a7d1f'],
  goal: '#8a3ffc',
  alarm: '#d55e00',
  allowed: '#b9d4e8',
  accent: '#0072b2',
  paths: { closed_form: '#009e73', active_set: '#e69f00', qp: '#d55e00' },
  materials: { link: [226, 231, 238], joint: [70, 86, 104], limit: [226, 98, 12], tool: [0, 122, 190] },
  look: {
    above: [0.965, 0.975, 0.985], below: [0.845, 0.875, 0.91], line: [0.42, 0.5, 0.58], sky: [0.44, 0.47, 0.52], ground: [0.2, 0.205, 0.22],
    lamp: [0.86, 0.83, 0.78], darkness: 0.3,
  },
  room: { shape: [0, 140, 190], obstacle: [150, 96, 52], clear: '#00704f', near: '#8a5a00', below: '#c01030' },
};

/** @type {Palette} */
const DARK = {
  dark: true,
  text: '#e6ecf3',
  muted: '#98a6b5',
  grid: '#29333f',
  card: '#151c25',
  scene: '#1a2430',
  ground: '#0d1218',
  axes: ['#56b4e9', '#e69f00', '#2fc79b'],
  ghost: '#df94bd',
  ghosts: ['#df94bd', '#4dd0e1', '#e3c565', '#b3c0cf', '#d3a58a', '#a5cf7a'],
  goal: '#be95ff',
  alarm: '#ff7f2a',
  allowed: '#29506b',
  accent: '#56b4e9',
  paths: { closed_form: '#2fc79b', active_set: '#e69f00', qp: '#ff7f2a' },
  materials: { link: [196, 206, 218], joint: [84, 102, 124], limit: [255, 127, 42], tool: [86, 180, 233] },
  look: {
    above: [0.105, 0.145, 0.195], below: [0.035, 0.05, 0.07], line: [0.4, 0.5, 0.6], sky: [0.3, 0.34, 0.4], ground: [0.07, 0.08, 0.095],
    lamp: [0.95, 0.93, 0.9], darkness: 0.75,
  },
  room: { shape: [86, 180, 233], obstacle: [222, 160, 104], clear: '#2fc79b', near: '#ffc233', below: '#ff5a6e' },
};

const STORAGE_KEY = 'revprio-theme';
const system = matchMedia('(prefers-color-scheme: dark)');

/** @type {Set<() => void>} */
const listeners = new Set();

/** @returns {'light' | 'dark'} */
function currentTheme() {
  const kept = localStorage.getItem(STORAGE_KEY);
  if (kept === 'light' || kept === 'dark') return kept;
  return system.matches ? 'dark' : 'light';
}

/** @returns {Palette} */
export function palette() {
  return currentTheme() === 'dark' ? DARK : LIGHT;
}

/** Returns the palette of exported figures, which is always light. */
export function printPalette() {
  return LIGHT;
}

export function toggle() {
  localStorage.setItem(STORAGE_KEY, currentTheme() === 'dark' ? 'light' : 'dark');
  apply();
}

function apply() {
  document.documentElement.dataset.theme = currentTheme();
  for (const listener of listeners) listener();
}

/** @param {() => void} listener called after each change */
export function onTheme(listener) {
  listeners.add(listener);
}

system.addEventListener('change', apply);
apply();
