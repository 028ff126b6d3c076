// The motion that the tool does not see: a ghost of the arm that swings its elbow while the tool stays where it is.

import { norm, sub } from './geometry.js';
import { element } from './notices.js';
import { inverse, multiply, rotationVector } from './rotation.js';

/**
 * @typedef {import('./kinematics.js').Kinematics} Kinematics
 * @typedef {import('./types.js').Robot} Robot
 */

/** Step along the motion, rad, the largest number of steps to one side, and the time of one swing, s. */
const STEP = 0.03;
const STEPS = 22;
const PERIOD = 5;

/** Regularization of the pseudo-inverse, and the smallest motion that is left for a swing. */
const REGULAR = 1e-6;
const MIN_MOTION = 0.05;

/** Largest distance of the tool of a shown posture from that of the arm, m. */
const TOLERANCE = 2e-3;

let isShown = false;

/** @param {() => void} onChange */
export function bind(onChange) {
  element('swing').onclick = () => {
    isShown = !isShown;
    element('swing').ariaPressed = String(isShown);
    onChange();
  };
}

/** Returns whether the ghost is shown. */
export const isSwinging = () => isShown;

/** The last postures, and of what. @type {{key: string, postures: number[][]}} */
let last = { key: '', postures: [] };

/** Returns the posture of the ghost; null if it is off or the arm has no such motion. @type {(kinematics: Kinematics, robot: Robot, position: number[], now: number) => number[] | null} `now`: real time, s */
export function swungPosition(kinematics, robot, position, now) {
  if (!isShown || position.length !== kinematics.joints.length) return null;
  const key = `${kinematics.robot} ${position.map((q) => q.toFixed(3))}`;
  if (last.key !== key) last = { key, postures: swing(kinematics, robot, position) };
  const { postures } = last;
  if (postures.length < 2) return null;
  const at = (postures.length - 1) * (0.5 - 0.5 * Math.cos((2 * Math.PI * now) / PERIOD));
  const [low, part] = [Math.floor(at), at - Math.floor(at)];
  const [a, b] = [postures[low], postures[Math.min(low + 1, postures.length - 1)]];
  return a.map((value, i) => value + part * (b[i] - value));
}

/** Returns postures with the same pose of the tool, from one end of the swing to the other. @type {(kinematics: Kinematics, robot: Robot, position: number[]) => number[][]} */
export function swing(kinematics, robot, position) {
  const side = (/** @type {number} */ sign) => {
    /** @type {number[][]} */
    const found = [];
    let [q, direction] = [position, /** @type {number[] | null} */ (null)];
    for (let i = 0; i < STEPS; i += 1) {
      direction = freeDirection(kinematics, q, direction, sign);
      if (!direction) break;
      const step = direction;
      q = corrected(kinematics, q.map((value, joint) => value + STEP * step[joint]), position);
      if (!isInside(robot, q) || toolDistance(kinematics, q, position) > TOLERANCE) break;
      found.push(q);
    }
    return found;
  };
  return [...side(-1).reverse(), position, ...side(1)];
}

/** Returns the unit vector of the motion that the tool does not see, in the direction of the one before; null if there is none. @type {(kinematics: Kinematics, q: number[], before: number[] | null, sign: number) => number[] | null} */
function freeDirection(kinematics, q, before, sign) {
  const columns = kinematics.jacobian(kinematics.frames(q));
  const wanted = before ?? q.map((_, joint) => sign * Math.cos(joint));
  const seen = leastSquares(columns, columns[0].map((_, row) => columns.reduce((sum, column, joint) => sum + column[row] * wanted[joint], 0)));
  const free = wanted.map((value, joint) => value - seen[joint]);
  const size = Math.hypot(...free);
  return size > MIN_MOTION ? free.map((value) => value / size) : null;
}

/** Moves a posture so that the tool returns to its pose. @type {(kinematics: Kinematics, q: number[], goal: number[]) => number[]} */
function corrected(kinematics, q, goal) {
  const frames = kinematics.frames(q);
  const [tool, wanted] = [kinematics.tool(frames), kinematics.tool(kinematics.frames(goal))];
  const error = [...sub(wanted.position, tool.position), ...rotationVector(multiply(wanted.orientation, inverse(tool.orientation)))];
  const back = leastSquares(kinematics.jacobian(frames), error);
  return q.map((value, joint) => value + back[joint]);
}

/** @type {(kinematics: Kinematics, q: number[], goal: number[]) => number} m */
function toolDistance(kinematics, q, goal) {
  const [a, b] = [q, goal].map((posture) => kinematics.tool(kinematics.frames(posture)).position);
  return norm(sub(a, b));
}

/** @type {(robot: Robot, q: number[]) => boolean} */
function isInside({ joints }, q) {
  return joints.every(({ position_limit: range }, i) => !range || (q[i] >= range[0] && q[i] <= range[1]));
}

/** Returns Jᵀ (J Jᵀ + ε)⁻¹ x by Cholesky's method. @type {(columns: number[][], x: number[]) => number[]} */
function leastSquares(columns, x) {
  const size = x.length;
  const lower = Array.from({ length: size }, () => Array(size).fill(0));
  for (let i = 0; i < size; i += 1) {
    for (let j = 0; j <= i; j += 1) {
      const gram = columns.reduce((sum, column) => sum + column[i] * column[j], i === j ? REGULAR : 0);
      const rest = gram - lower[i].slice(0, j).reduce((sum, value, k) => sum + value * lower[j][k], 0);
      lower[i][j] = i === j ? Math.sqrt(Math.max(rest, 1e-12)) : rest / lower[j][j];
    }
  }
  const y = [...x];
  for (let i = 0; i < size; i += 1) y[i] = (y[i] - lower[i].slice(0, i).reduce((sum, value, k) => sum + value * y[k], 0)) / lower[i][i];
  for (let i = size - 1; i >= 0; i -= 1) {
    for (let k = i + 1; k < size; k += 1) y[i] -= lower[k][i] * y[k];
    y[i] /= lower[i][i];
  }
  return columns.map((column) => column.reduce((sum, value, row) => sum + value * y[row], 0));
}
