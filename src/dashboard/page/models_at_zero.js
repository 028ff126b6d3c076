// Shapes of arms, stated in the base frame for the position zero of all joints, where most makers draw them.

import { block, drum, emptyForm, lathe, tube } from './forms.js';

/**
 * @typedef {import('./types.js').Vec3} Vec3
 * @typedef {import('./forms.js').Form} Form
 * @typedef {import('./models.js').Builder} Builder
 */

/** Adds a drum along x, y or z between two of its coordinates; `at` is a point of its axis. @type {(form: Form, axis: number, at: Vec3, low: number, high: number, radius: number, bevel?: number) => void} */
function along(form, axis, at, low, high, radius, bevel = 0.14 * radius) {
  const end = (/** @type {number} */ place) => /** @type {Vec3} */ (at.map((part, i) => (i === axis ? place : part)));
  drum(form, end(low), end(high), radius, bevel);
}

/** Adds a box that is turned about y, rad. @type {(form: Form, center: Vec3, size: Vec3, bevel: number, angle: number) => void} */
function tilted(form, center, size, bevel, angle) {
  const straight = emptyForm();
  block(straight, [0, 0, 0], size, bevel);
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  for (let i = 0; i < straight.places.length; i += 3) {
    const turn = (/** @type {number[]} */ list) => [c * list[i] + s * list[i + 2], list[i + 1], c * list[i + 2] - s * list[i]];
    form.places.push(...turn(straight.places).map((part, k) => part + center[k]));
    form.normals.push(...turn(straight.normals));
  }
}

/** Height of the joints of the iiwa and of the interface, m. */
const IIWA = [0.1575, 0.36, 0.5645, 0.78, 0.9645, 1.18, 1.261, 1.306];

/** A silver arm of rounded half joints with orange rings, of the proportions of the LBR iiwa. @param {Builder} b */
export function iiwa(b) {
  /** Half of a joint about y, on one side of the axis, with its ring and cover. @type {(height: number, side: number, radius: number, width: number) => void} */
  const half = (height, side, radius, width) => {
    const at = /** @type {Vec3} */ ([0, 0, height]);
    const span = (/** @type {number} */ a, /** @type {number} */ c) => /** @type {const} */ ([Math.min(side * a, side * c), Math.max(side * a, side * c)]);
    along(b.of('aluminium'), 1, at, ...span(0.003, width), radius, 0.3 * radius);
    along(b.of('orange'), 1, at, ...span(width - 0.006, width + 0.0015), 0.72 * radius, 0.003);
    along(b.of('aluminium'), 1, at, ...span(width - 0.004, width + 0.004), 0.62 * radius, 0.004);
  };
  lathe(b.of('aluminium'), [0, 0, 0], [0, 0, 1], [[0, 0], [0.132, 0], [0.134, 0.006], [0.131, 0.03], [0.118, 0.075], [0.1, 0.12], [0.094, 0.145], [0.09, 0.152], [0, 0.152]]);
  block(b.of('aluminium'), [-0.11, 0, 0.05], [0.13, 0.15, 0.095], 0.025);
  block(b.of('dark'), [-0.174, 0, 0.046], [0.008, 0.1, 0.05], 0.003);
  b.joint = 0;
  along(b.of('dark', true), 2, [0, 0, 0], 0.151, 0.159, 0.0915, 0.002);
  tube(b.of('aluminium'), [[0, 0, 0.158], [0, 0, 0.19], [0, -0.012, 0.25], [0, -0.044, 0.315], [0, -0.06, 0.36]], [0.09, 0.09, 0.089, 0.074, 0.045]);
  half(IIWA[1], -1, 0.092, 0.121);
  b.joint = 1;
  along(b.of('dark', true), 1, [0, 0, IIWA[1]], -0.005, 0.005, 0.087, 0.002);
  half(IIWA[1], 1, 0.092, 0.121);
  tube(b.of('aluminium'), [[0, 0.06, 0.36], [0, 0.044, 0.405], [0, 0.012, 0.47], [0, 0, 0.53], [0, 0, 0.56]], [0.045, 0.074, 0.087, 0.084, 0.083]);
  b.joint = 2;
  along(b.of('dark', true), 2, [0, 0, 0], 0.558, 0.567, 0.0845, 0.002);
  tube(b.of('aluminium'), [[0, 0, 0.566], [0, 0, 0.6], [0, 0.01, 0.665], [0, 0.04, 0.735], [0, 0.054, 0.78]], [0.083, 0.082, 0.079, 0.066, 0.04]);
  half(IIWA[3], 1, 0.08, 0.109);
  b.joint = 3;
  along(b.of('dark', true), 1, [0, 0, IIWA[3]], -0.005, 0.005, 0.075, 0.002);
  half(IIWA[3], -1, 0.08, 0.109);
  tube(b.of('aluminium'), [[0, -0.054, 0.78], [0, -0.04, 0.825], [0, -0.01, 0.885], [0, 0, 0.935], [0, 0, 0.96]], [0.04, 0.066, 0.076, 0.074, 0.073]);
  b.joint = 4;
  along(b.of('dark', true), 2, [0, 0, 0], 0.958, 0.967, 0.0745, 0.002);
  tube(b.of('aluminium'), [[0, 0, 0.966], [0, 0, 1], [0, -0.014, 1.05], [0, -0.05, 1.115], [0, -0.072, 1.18]], [0.073, 0.072, 0.067, 0.052, 0.03]);
  along(b.of('aluminium'), 1, [0, 0, IIWA[5]], -0.108, -0.058, 0.058, 0.018);
  b.joint = 5;
  along(b.of('dark', true), 1, [0, 0, IIWA[5]], -0.06, -0.052, 0.053, 0.002);
  along(b.of('aluminium'), 1, [0, 0, IIWA[5]], -0.054, 0.066, 0.066, 0.026);
  along(b.of('orange'), 1, [0, 0, IIWA[5]], 0.062, 0.0675, 0.036, 0.003);
  along(b.of('aluminium'), 1, [0, 0, IIWA[5]], 0.062, 0.0695, 0.03, 0.003);
  tube(b.of('aluminium'), [[0, 0, 1.18], [0, 0, 1.22], [0, 0, 1.255]], [0.06, 0.056, 0.048]);
  b.joint = 6;
  along(b.of('dark', true), 2, [0, 0, 0], 1.253, 1.262, 0.0515, 0.002);
  along(b.of('aluminium'), 2, [0, 0, 0], 1.26, 1.29, 0.05, 0.006);
  along(b.of('steel'), 2, [0, 0, 0], 1.289, IIWA[7], 0.0315, 0.003);
}

/** Middle of the links of the Gen3 at its joints 2, 4 and 6, and of its last joint, m. */
const GEN3 = [{ y: -0.0054, z: 0.2848 }, { y: -0.0181, z: 0.7056 }, { y: -0.0247, z: 1.0199 }];

/** A slim bright arm of round tubes with dark rings, of the proportions of the Gen3. @param {Builder} b */
export function gen3(b) {
  /** Half of an elbow: a drum about y on one side of the joint. @type {(at: {y: number, z: number}, side: number, radius: number) => void} */
  const half = ({ y, z }, side, radius) => {
    const [inner, outer] = [y + side * 0.001, y + side * 1.02 * radius];
    along(b.of('shell'), 1, [0, 0, z], Math.min(inner, outer), Math.max(inner, outer), radius, 0.4 * radius);
    const cover = outer - side * 0.003;
    along(b.of('grey'), 1, [0, 0, z], Math.min(cover, cover + side * 0.0045), Math.max(cover, cover + side * 0.0045), 0.5 * radius, 0.002);
  };
  /** Tube from a ring to half an elbow. @type {(from: number, y: number, at: {y: number, z: number}, side: number, radius: number) => void} */
  const limb = (from, y, at, side, radius) => {
    const up = Math.sign(at.z - from);
    const middle = at.y + side * 0.5 * radius;
    tube(b.of('shell'), [[0, y, from], [0, y, at.z - up * 1.9 * radius], [0, (y + middle) / 2, at.z - up * 0.95 * radius], [0, middle, at.z]], [radius, radius, 0.86 * radius, 0.5 * radius]);
    half(at, side, 1.02 * radius);
  };
  const ring = (/** @type {number} */ y, /** @type {number} */ z, /** @type {number} */ radius) => along(b.of('black', true), 2, [0, y, 0], z - 0.006, z + 0.006, radius, 0.002);
  along(b.of('black'), 2, [0, 0, 0], 0, 0.012, 0.06, 0.003);
  tube(b.of('shell'), [[0, 0, 0.011], [0, 0, 0.07], [0, 0, 0.152]], [0.052, 0.046, 0.046]);
  b.joint = 0;
  ring(0, 0.1564, 0.0465);
  limb(0.16, 0, GEN3[0], 1, 0.046);
  b.joint = 1;
  along(b.of('black', true), 1, [0, 0, GEN3[0].z], GEN3[0].y - 0.004, GEN3[0].y + 0.004, 0.0445, 0.001);
  limb(0.492, -0.0117, GEN3[0], -1, 0.046);
  b.joint = 2;
  ring(-0.0117, 0.4952, 0.0465);
  limb(0.499, -0.0117, GEN3[1], 1, 0.046);
  b.joint = 3;
  along(b.of('black', true), 1, [0, 0, GEN3[1].z], GEN3[1].y - 0.004, GEN3[1].y + 0.004, 0.0445, 0.001);
  limb(0.91, -0.0245, GEN3[1], -1, 0.045);
  b.joint = 4;
  ring(-0.0245, 0.914, 0.0405);
  limb(0.918, -0.0245, GEN3[2], 1, 0.0375);
  b.joint = 5;
  along(b.of('black', true), 1, [0, 0, GEN3[2].z], GEN3[2].y - 0.004, GEN3[2].y + 0.004, 0.0365, 0.001);
  limb(1.122, -0.0249, GEN3[2], -1, 0.0375);
  b.joint = 6;
  ring(-0.0249, 1.1259, 0.0385);
  along(b.of('shell'), 2, [0, -0.0249, 0], 1.13, 1.18, 0.0395, 0.006);
  block(b.of('black'), [0, 0.026, 1.158], [0.062, 0.032, 0.04], 0.008);
  for (const x of [-0.014, 0.014]) along(b.of('grey'), 2, [x, 0.028, 0], 1.176, 1.181, 0.0085, 0.002);
  along(b.of('steel'), 2, [0, -0.0249, 0], 1.178, 1.1874, 0.0315, 0.002);
}

/** A white arm with grey covers whose links stand beside the joints, of the proportions of the xArm 7. @param {Builder} b */
export function xarm7(b) {
  const elbow = /** @type {Vec3} */ ([0.0525, 0, 0.56]);
  const wrist = /** @type {Vec3} */ ([0.13, 0, 0.2175]);
  const cover = (/** @type {Vec3} */ at, /** @type {number} */ low, /** @type {number} */ high, /** @type {number} */ radius) => along(b.of('silver'), 1, at, low, high, radius, 0.004);
  along(b.of('grey'), 2, [0, 0, 0], 0, 0.012, 0.074, 0.003);
  lathe(b.of('white'), [0, 0, 0.011], [0, 0, 1], [[0.07, 0], [0.07, 0.02], [0.064, 0.06], [0.06, 0.11], [0.06, 0.14], [0, 0.14]]);
  block(b.of('white'), [-0.055, 0, 0.04], [0.06, 0.085, 0.055], 0.012);
  b.joint = 0;
  along(b.of('grey', true), 2, [0, 0, 0], 0.15, 0.158, 0.0605, 0.002);
  tube(b.of('white'), [[0, 0, 0.157], [0, 0, 0.2], [0, 0, 0.262]], [0.06, 0.06, 0.052]);
  along(b.of('white'), 1, [0, 0, 0.267], -0.058, 0.06, 0.0605, 0.014);
  cover([0, 0, 0.267], -0.063, -0.055, 0.043);
  b.joint = 1;
  along(b.of('grey', true), 1, [0, 0, 0.267], 0.058, 0.067, 0.056, 0.002);
  along(b.of('white'), 1, [0, 0, 0.267], 0.066, 0.126, 0.058, 0.016);
  cover([0, 0, 0.267], 0.122, 0.13, 0.04);
  tube(b.of('white'), [[0, 0.092, 0.267], [0, 0.092, 0.325], [0, 0.048, 0.39], [0, 0, 0.435], [0, 0, 0.47]], [0.046, 0.05, 0.053, 0.055, 0.055]);
  b.joint = 2;
  along(b.of('grey', true), 2, [0, 0, 0], 0.468, 0.477, 0.0545, 0.002);
  tube(b.of('white'), [[0, 0, 0.476], [0, 0, 0.51], [0.018, 0, 0.548], [0.0525, 0, 0.56]], [0.055, 0.055, 0.053, 0.048]);
  along(b.of('white'), 1, elbow, -0.042, 0.056, 0.056, 0.014);
  cover(elbow, 0.053, 0.061, 0.04);
  b.joint = 3;
  along(b.of('grey', true), 1, elbow, -0.049, -0.04, 0.052, 0.002);
  along(b.of('white'), 1, elbow, -0.108, -0.048, 0.053, 0.016);
  cover(elbow, -0.112, -0.104, 0.037);
  tube(b.of('white'), [[0.0525, -0.078, 0.56], [0.09, -0.08, 0.522], [0.122, -0.045, 0.475], [0.13, 0, 0.435], [0.13, 0, 0.4]], [0.042, 0.046, 0.048, 0.05, 0.049]);
  b.joint = 4;
  along(b.of('grey', true), 2, [0.13, 0, 0], 0.393, 0.402, 0.0485, 0.002);
  tube(b.of('white'), [[0.13, 0, 0.394], [0.13, -0.006, 0.345], [0.13, -0.045, 0.28], [0.13, -0.056, 0.2175]], [0.049, 0.047, 0.043, 0.036]);
  along(b.of('white'), 1, wrist, -0.088, -0.024, 0.046, 0.013);
  cover(wrist, -0.092, -0.085, 0.031);
  b.joint = 5;
  along(b.of('grey', true), 1, wrist, -0.026, -0.017, 0.0425, 0.002);
  along(b.of('white'), 1, wrist, -0.018, 0.044, 0.0445, 0.013);
  cover(wrist, 0.041, 0.048, 0.03);
  tube(b.of('white'), [[0.13, 0.014, 0.2175], [0.165, 0.008, 0.2145], [0.206, 0, 0.2]], [0.038, 0.037, 0.036]);
  along(b.of('white'), 2, [0.206, 0, 0], 0.144, 0.246, 0.0435, 0.012);
  along(b.of('silver'), 2, [0.206, 0, 0], 0.243, 0.25, 0.03, 0.003);
  b.joint = 6;
  along(b.of('grey', true), 2, [0.206, 0, 0], 0.137, 0.145, 0.0405, 0.002);
  along(b.of('steel'), 2, [0.206, 0, 0], 0.1205, 0.138, 0.0375, 0.003);
}

/** A red and black arm with a screen, of the proportions of the Sawyer, without its pedestal. @param {Builder} b */
export function sawyer(b) {
  const shoulder = /** @type {Vec3} */ ([0.081, 0, 0.317]);
  const [elbow, wrist] = /** @type {Vec3[]} */ ([[0.481, 0, 0.317], [0.881, 0, 0.317]]);
  const cover = (/** @type {Vec3} */ at, /** @type {number} */ low, /** @type {number} */ high, /** @type {number} */ radius) => along(b.of('grey'), 1, at, low, high, radius, 0.003);
  along(b.of('black'), 2, [0, 0, 0], 0, 0.022, 0.112, 0.005);
  along(b.of('dark'), 2, [0, 0, 0], 0.02, 0.075, 0.09, 0.006);
  b.joint = 0;
  along(b.of('black', true), 2, [0, 0, 0], 0.074, 0.084, 0.084, 0.002);
  tube(b.of('red'), [[0, 0, 0.082], [0, 0, 0.15], [0, 0, 0.24], [0, 0, 0.3]], [0.083, 0.078, 0.078, 0.082]);
  along(b.of('red'), 2, [0, 0, 0], 0.26, 0.385, 0.083, 0.03);
  tube(b.of('red'), [[0, 0, 0.317], [0.04, 0.008, 0.317], [0.081, 0.02, 0.317]], [0.07, 0.07, 0.064]);
  along(b.of('dark'), 1, shoulder, -0.05, 0.066, 0.068, 0.014);
  cover(shoulder, -0.054, -0.047, 0.046);
  along(b.of('dark'), 2, [0, 0, 0], 0.38, 0.41, 0.035, 0.004);
  block(b.of('black'), [0.012, 0, 0.485], [0.04, 0.27, 0.175], 0.014);
  block(b.of('screen'), [0.032, 0, 0.488], [0.006, 0.236, 0.142], 0.002);
  b.joint = 1;
  along(b.of('black', true), 1, shoulder, 0.064, 0.073, 0.065, 0.002);
  along(b.of('dark'), 1, shoulder, 0.072, 0.258, 0.066, 0.018);
  cover(shoulder, 0.254, 0.261, 0.044);
  along(b.of('dark'), 0, [0, 0.1925, 0.317], 0.081, 0.21, 0.062, 0.008);
  b.joint = 2;
  along(b.of('black', true), 0, [0, 0.1925, 0.317], 0.208, 0.217, 0.06, 0.002);
  tube(b.of('red'), [[0.215, 0.1925, 0.317], [0.28, 0.1905, 0.317], [0.4, 0.178, 0.317], [0.481, 0.168, 0.317]], [0.062, 0.059, 0.054, 0.05]);
  along(b.of('dark'), 1, elbow, 0.118, 0.218, 0.059, 0.014);
  cover(elbow, 0.214, 0.221, 0.04);
  b.joint = 3;
  along(b.of('black', true), 1, elbow, 0.111, 0.12, 0.056, 0.002);
  along(b.of('dark'), 1, elbow, -0.032, 0.112, 0.057, 0.016);
  cover(elbow, -0.036, -0.029, 0.038);
  along(b.of('dark'), 0, [0, 0.024, 0.317], 0.481, 0.596, 0.053, 0.007);
  b.joint = 4;
  along(b.of('black', true), 0, [0, 0.024, 0.317], 0.594, 0.603, 0.051, 0.002);
  tube(b.of('red'), [[0.601, 0.024, 0.317], [0.67, 0.026, 0.317], [0.8, 0.036, 0.317], [0.881, 0.042, 0.317]], [0.053, 0.049, 0.043, 0.04]);
  along(b.of('dark'), 1, wrist, -0.008, 0.086, 0.049, 0.012);
  cover(wrist, -0.012, -0.005, 0.032);
  b.joint = 5;
  along(b.of('black', true), 1, wrist, 0.084, 0.093, 0.046, 0.002);
  along(b.of('dark'), 1, wrist, 0.092, 0.208, 0.047, 0.013);
  cover(wrist, 0.204, 0.211, 0.03);
  along(b.of('red'), 0, [0, 0.1603, 0.317], 0.881, 0.964, 0.045, 0.006);
  b.joint = 6;
  along(b.of('black', true), 0, [0, 0.1603, 0.317], 0.962, 0.971, 0.043, 0.002);
  along(b.of('silver'), 0, [0, 0.1603, 0.317], 0.97, 1.002, 0.042, 0.006);
  block(b.of('black'), [0.986, 0.1603, 0.366], [0.026, 0.032, 0.018], 0.004);
  along(b.of('steel'), 0, [0, 0.1603, 0.317], 1, 1.0148, 0.0315, 0.002);
}

/** Printed yellow brackets with black servos, of the proportions of the SO-101, gripper closed. @param {Builder} b */
export function so101(b) {
  /** Two plates beside a servo, with round ends, and their screws. @type {(from: [number, number], to: [number, number], radius: number, y: number) => void} */
  const plates = (from, to, radius, y) => {
    const [dx, dz] = [to[0] - from[0], to[1] - from[1]];
    const length = Math.hypot(dx, dz);
    for (const side of [-1, 1]) {
      const span = /** @type {const} */ ([side * y - 0.003, side * y + 0.003]);
      for (const [x, z] of [from, to]) along(b.of('print'), 1, [x, 0, z], ...span, radius, 0.0012);
      tilted(b.of('print'), [(from[0] + to[0]) / 2, side * y, (from[1] + to[1]) / 2], [length, 0.006, 2 * radius], 0.0012, -Math.atan2(dz, dx));
      along(b.of('black', true), 1, [from[0], 0, from[1]], side * y - 0.005, side * y + 0.005, 0.0095, 0.001);
      along(b.of('steel'), 1, [from[0], 0, from[1]], side * y - 0.0056, side * y + 0.0056, 0.003, 0.0008);
    }
  };
  const servo = (/** @type {Vec3} */ center, /** @type {Vec3} */ size) => block(b.of('black'), center, size, 0.002);
  block(b.of('print'), [0.008, 0, 0.005], [0.118, 0.118, 0.01], 0.003);
  block(b.of('print'), [0.02, 0, 0.034], [0.07, 0.062, 0.05], 0.005);
  block(b.of('print'), [-0.03, 0, 0.02], [0.04, 0.07, 0.026], 0.004);
  servo([0.0288, 0, 0.043], [0.0452, 0.0247, 0.035]);
  for (const y of [-0.045, 0.045]) for (const x of [-0.038, 0.055]) along(b.of('steel'), 2, [x, y, 0], 0.009, 0.0125, 0.004, 0.001);
  b.joint = 0;
  along(b.of('black', true), 2, [0.0388, 0, 0], 0.0605, 0.0655, 0.0125, 0.001);
  block(b.of('print'), [0.0505, 0, 0.0685], [0.055, 0.052, 0.008], 0.002);
  block(b.of('print'), [0.0692, 0, 0.083], [0.036, 0.05, 0.032], 0.004);
  servo([0.0692, 0, 0.1045], [0.0247, 0.035, 0.0452]);
  b.joint = 1;
  plates([0.0692, 0.1166], [0.0745, 0.205], 0.0155, 0.0225);
  block(b.of('print'), [0.0645, 0, 0.182], [0.014, 0.045, 0.062], 0.003);
  servo([0.0872, 0, 0.2292], [0.0452, 0.035, 0.0247]);
  block(b.of('print'), [0.078, 0, 0.2292], [0.03, 0.044, 0.034], 0.004);
  b.joint = 2;
  plates([0.0972, 0.2292], [0.178, 0.2325], 0.0145, 0.0265);
  block(b.of('print'), [0.158, 0, 0.232], [0.05, 0.052, 0.024], 0.004);
  servo([0.2221, 0, 0.2344], [0.0452, 0.035, 0.0247]);
  block(b.of('print'), [0.203, 0, 0.2344], [0.034, 0.045, 0.033], 0.004);
  b.joint = 3;
  plates([0.2321, 0.2344], [0.252, 0.2344], 0.0145, 0.0235);
  block(b.of('print'), [0.259, 0, 0.2344], [0.014, 0.05, 0.036], 0.003);
  servo([0.2745, 0, 0.2344], [0.035, 0.0452, 0.0247]);
  block(b.of('print'), [0.27, 0, 0.2344], [0.024, 0.052, 0.032], 0.004);
  b.joint = 4;
  along(b.of('black', true), 0, [0, 0, 0.2344], 0.2915, 0.296, 0.0125, 0.001);
  block(b.of('print'), [0.303, 0, 0.234], [0.016, 0.05, 0.05], 0.004);
  servo([0.3265, 0.0, 0.247], [0.0452, 0.035, 0.0247]);
  tilted(b.of('print'), [0.329, 0, 0.2185], [0.05, 0.046, 0.01], 0.003, 0.12);
  tilted(b.of('print'), [0.372, 0, 0.2155], [0.052, 0.026, 0.009], 0.003, -0.12);
  for (const y of [-0.021, 0.021]) along(b.of('print'), 1, [0.335, 0, 0.249], y - 0.003, y + 0.003, 0.013, 0.001);
  tilted(b.of('print'), [0.353, 0, 0.2425], [0.05, 0.046, 0.009], 0.003, 0.26);
  tilted(b.of('print'), [0.384, 0, 0.2315], [0.034, 0.026, 0.009], 0.003, 0.36);
}
