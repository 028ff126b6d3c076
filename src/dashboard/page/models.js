// The shapes of the arms that come with the service, made of bevelled forms in the frames of their joints.

import { ball, block, drum, emptyForm, lathe, tube } from './forms.js';
import { sub } from './geometry.js';
import { IDENTITY, inverse, rotate } from './rotation.js';

/**
 * @typedef {import('./types.js').Vec3} Vec3
 * @typedef {import('./forms.js').Form} Form
 * @typedef {import('./urdf.js').Placement} Placement
 * @typedef {import('./webgl.js').Mesh} Mesh
 *
 * @typedef {object} Finish
 * @property {import('./shading.js').Rgb} rgb
 * @property {number} roughness
 * @property {number} metal
 *
 * @typedef {object} ModelPart
 * @property {number} joint index of the joint whose frame carries it; −1: the base
 * @property {Mesh} mesh
 * @property {Finish} finish
 * @property {boolean} marks whether it changes its colour when the joint is at a limit
 */

/** @type {Placement} */
const BASE = { position: [0, 0, 0], orientation: IDENTITY };

/** @type {Record<string, Finish>} */
export const FINISHES = {
  white: { rgb: [238, 240, 243], roughness: 0.32, metal: 0 },
  grey: { rgb: [122, 130, 140], roughness: 0.45, metal: 0 },
  dark: { rgb: [44, 49, 56], roughness: 0.5, metal: 0 },
  steel: { rgb: [196, 201, 207], roughness: 0.34, metal: 0.75 },
  silver: { rgb: [190, 196, 203], roughness: 0.4, metal: 0.35 },
  sky: { rgb: [108, 172, 220], roughness: 0.38, metal: 0 },
  red: { rgb: [178, 30, 40], roughness: 0.35, metal: 0 },
  black: { rgb: [30, 32, 36], roughness: 0.45, metal: 0 },
  aluminium: { rgb: [224, 226, 228], roughness: 0.36, metal: 0.22 },
  shell: { rgb: [226, 228, 231], roughness: 0.3, metal: 0.12 },
  orange: { rgb: [238, 112, 22], roughness: 0.4, metal: 0 },
  print: { rgb: [246, 190, 32], roughness: 0.62, metal: 0 },
  screen: { rgb: [112, 176, 214], roughness: 0.3, metal: 0 },
};

/** Collects the forms of a model by joint, finish and mark. */
export class Builder {
  constructor() {
    /** @type {Map<string, {joint: number, finish: Finish, marks: boolean, form: Form}>} */
    this.forms = new Map();
    this.joint = -1;
  }

  /** Returns the form that collects bodies of one finish in the frame of the current joint. @type {(finish: string, marks?: boolean) => Form} */
  of(finish, marks = false) {
    const key = `${this.joint} ${finish} ${marks}`;
    const known = this.forms.get(key) ?? { joint: this.joint, finish: FINISHES[finish], marks, form: emptyForm() };
    this.forms.set(key, known);
    return known.form;
  }

  /** Returns the parts. If the forms are stated in the base frame, `frames` are those of the joints for the same posture. @type {(frames?: Placement[]) => ModelPart[]} */
  parts(frames = []) {
    return Array.from(this.forms.values(), ({ joint, finish, marks, form: { places, normals } }) => {
      const { position, orientation } = frames[joint] ?? BASE;
      const back = inverse(orientation);
      const inFrame = (/** @type {number[]} */ list, /** @type {Vec3} */ origin) => {
        const moved = new Float32Array(list.length);
        for (let i = 0; i < list.length; i += 3) moved.set(rotate(back, sub([list[i], list[i + 1], list[i + 2]], origin)), i);
        return moved;
      };
      return { joint, finish, marks, mesh: { places: inFrame(places, position), normals: inFrame(normals, [0, 0, 0]) } };
    });
  }
}

/** Adds a drum along z of the current frame. @type {(form: Form, low: number, high: number, radius: number, x?: number, y?: number, top?: number) => void} */
const upright = (form, low, high, radius, x = 0, y = 0, top = radius) => drum(form, [x, y, low], [x, y, high], radius, 0.14 * radius, top);

/** Adds a drum along y of the current frame. @type {(form: Form, low: number, high: number, radius: number, x?: number, z?: number) => void} */
const crosswise = (form, low, high, radius, x = 0, z = 0) => drum(form, [x, low, z], [x, high, z], radius, 0.14 * radius);

/** A white arm with seven joints and slim wrist, of the proportions of the Panda. @param {Builder} b */
export function panda(b) {
  lathe(b.of('white'), [0, 0, 0], [0, 0, 1], [[0, 0], [0.094, 0], [0.096, 0.006], [0.092, 0.022], [0.074, 0.06], [0.063, 0.11], [0.061, 0.138], [0.056, 0.143], [0, 0.143]]);
  block(b.of('white'), [-0.095, 0, 0.035], [0.12, 0.12, 0.066], 0.014);
  block(b.of('dark'), [-0.155, 0, 0.036], [0.008, 0.085, 0.042], 0.003);
  b.joint = 0;
  upright(b.of('dark', true), -0.191, -0.181, 0.0595);
  tube(b.of('white'), [[0, 0, -0.182], [0, 0, -0.12], [0, 0, -0.04], [0, 0, 0]], [0.059, 0.058, 0.06, 0.06]);
  crosswise(b.of('white'), -0.052, 0.052, 0.066);
  b.joint = 1;
  for (const side of [-1, 1]) {
    drum(b.of('white'), [0, 0, side * 0.0535], [0, 0, side * 0.074], 0.061, 0.014);
    drum(b.of('dark', true), [0, 0, side * 0.051], [0, 0, side * 0.0545], 0.0635, 0.002);
    drum(b.of('grey'), [0, 0, side * 0.073], [0, 0, side * 0.0765], 0.036, 0.002);
  }
  tube(b.of('white'), [[0, 0, 0], [0, -0.06, 0], [0, -0.13, 0], [0, -0.192, 0]], [0.05, 0.06, 0.059, 0.0575]);
  b.joint = 2;
  upright(b.of('dark', true), -0.125, -0.116, 0.058);
  tube(b.of('white'), [[0, 0, -0.117], [0, 0, -0.07], [0.028, 0, -0.012], [0.0825, 0, 0]], [0.0575, 0.058, 0.058, 0.052]);
  crosswise(b.of('white'), -0.05, 0.05, 0.06, 0.0825, 0);
  b.joint = 3;
  for (const side of [-1, 1]) {
    drum(b.of('white'), [0, 0, side * 0.0515], [0, 0, side * 0.07], 0.056, 0.013);
    drum(b.of('dark', true), [0, 0, side * 0.049], [0, 0, side * 0.0525], 0.0585, 0.002);
    drum(b.of('grey'), [0, 0, side * 0.069], [0, 0, side * 0.0722], 0.033, 0.002);
  }
  tube(b.of('white'), [[0, 0, 0], [-0.05, 0.03, 0], [-0.0825, 0.08, 0], [-0.0825, 0.122, 0]], [0.048, 0.057, 0.057, 0.056]);
  b.joint = 4;
  upright(b.of('dark', true), -0.263, -0.254, 0.0565);
  tube(b.of('white'), [[0, 0, -0.255], [0, 0.012, -0.2], [0, 0.046, -0.13], [0, 0.062, -0.06], [0, 0.056, 0]], [0.056, 0.055, 0.045, 0.042, 0.046]);
  crosswise(b.of('white'), 0.006, 0.1, 0.05);
  crosswise(b.of('grey'), 0.099, 0.103, 0.028);
  b.joint = 5;
  upright(b.of('dark', true), -0.009, -0.002, 0.0495);
  upright(b.of('white'), -0.003, 0.052, 0.049);
  tube(b.of('white'), [[0, 0, 0.02], [0.03, 0, 0.018], [0.06, 0, 0.004], [0.088, 0, 0]], [0.044, 0.044, 0.044, 0.043]);
  crosswise(b.of('white'), -0.058, 0.05, 0.0475, 0.088, 0);
  crosswise(b.of('dark'), 0.049, 0.053, 0.03, 0.088, 0);
  b.joint = 6;
  upright(b.of('dark', true), 0.056, 0.064, 0.0465);
  upright(b.of('white'), 0.063, 0.094, 0.0455);
  block(b.of('white'), [0.03, 0.03, 0.078], [0.05, 0.05, 0.026], 0.009);
  upright(b.of('steel'), 0.093, 0.107, 0.0315);
}

/** A silver arm with six joints and coloured caps, of the proportions of the UR5e. @param {Builder} b */
export function ur5e(b) {
  const cap = (/** @type {Vec3} */ a, /** @type {Vec3} */ end, /** @type {number} */ radius) => drum(b.of('sky'), a, end, radius, 0.45 * radius);
  upright(b.of('dark'), 0, 0.018, 0.078);
  upright(b.of('silver'), 0.017, 0.072, 0.069);
  b.joint = 0;
  upright(b.of('dark', true), 0.071, 0.078, 0.067);
  tube(b.of('silver'), [[0, 0, 0.077], [0, 0, 0.12], [0, 0, 0.1625]], [0.067, 0.065, 0.06]);
  crosswise(b.of('silver'), -0.066, 0.06, 0.0665, 0, 0.1625);
  cap([0, 0.058, 0.1625], [0, 0.084, 0.1625], 0.063);
  b.joint = 1;
  upright(b.of('dark', true), 0.065, 0.073, 0.066);
  upright(b.of('silver'), 0.072, 0.195, 0.0665);
  cap([0, 0, 0.193], [0, 0, 0.219], 0.063);
  drum(b.of('silver'), [-0.055, 0, 0.138], [-0.37, 0, 0.138], 0.0475, 0.004, 0.0455);
  for (const x of [-0.062, -0.362]) drum(b.of('dark'), [x - 0.004, 0, 0.138], [x + 0.004, 0, 0.138], 0.0495, 0.002);
  upright(b.of('silver'), 0.075, 0.193, 0.056, -0.425, 0);
  cap([-0.425, 0, 0.191], [-0.425, 0, 0.214], 0.0535);
  b.joint = 2;
  upright(b.of('dark', true), 0.067, 0.076, 0.055);
  upright(b.of('silver'), -0.045, 0.068, 0.0555);
  cap([0, 0, -0.043], [0, 0, -0.066], 0.053);
  drum(b.of('silver'), [-0.045, 0, 0.012], [-0.352, 0, 0.012], 0.04, 0.004, 0.037);
  for (const x of [-0.055, -0.345]) drum(b.of('dark'), [x - 0.0035, 0, 0.012], [x + 0.0035, 0, 0.012], 0.0415, 0.002);
  upright(b.of('silver'), -0.04, 0.058, 0.0445, -0.3922, 0);
  cap([-0.3922, 0, -0.038], [-0.3922, 0, -0.058], 0.0425);
  b.joint = 3;
  upright(b.of('dark', true), 0.057, 0.065, 0.0445);
  tube(b.of('silver'), [[0, 0, 0.064], [0, 0, 0.1], [0, 0, 0.1333]], [0.0445, 0.0445, 0.04]);
  crosswise(b.of('silver'), -0.046, 0.044, 0.0445, 0, 0.1333);
  cap([0, 0.042, 0.1333], [0, 0.061, 0.1333], 0.0425);
  b.joint = 4;
  upright(b.of('dark', true), 0.045, 0.052, 0.0445);
  tube(b.of('silver'), [[0, 0, 0.051], [0, 0, 0.075], [0, 0, 0.0997]], [0.0445, 0.0445, 0.04]);
  crosswise(b.of('silver'), -0.044, 0.046, 0.0445, 0, 0.0997);
  cap([0, -0.042, 0.0997], [0, -0.061, 0.0997], 0.0425);
  b.joint = 5;
  upright(b.of('dark', true), 0.045, 0.052, 0.0435);
  upright(b.of('silver'), 0.051, 0.09, 0.0435);
  upright(b.of('steel'), 0.089, 0.0996, 0.0325);
}

/** Marks the tool point. @type {(b: Builder, at: Vec3, radius: number) => void} */
export const tip = (b, at, radius) => ball(b.of('steel'), at, radius);
