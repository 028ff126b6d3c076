// Planes and walls that the user adds to a scenario.

import { vec } from './arm.js';
import { dot, scale } from './geometry.js';

/**
 * @typedef {import('./types.js').Scenario} Scenario
 * @typedef {import('./types.js').Vec3} Vec3
 *
 * @typedef {object} Plane
 * @property {string} name
 * @property {'plane' | 'wall'} kind a plane is an inequality of the controller; a wall is a contact that pushes back
 * @property {string} side direction of the forbidden side, as in `-z`
 * @property {number} offset distance from the base origin in this direction, m
 */

/** Directions of the forbidden side. */
export const SIDES = ['+x', '−x', '+y', '−y', '+z', '−z'];

/** Stiffness and damping of an added wall, N/m and N·s/m. */
const WALL = { stiffness: 1e4, damping: 100 };

/** @type {(side: string) => Vec3} unit vector */
export function normalOf(side) {
  const sign = side.startsWith('+') ? 1 : -1;
  const axis = 'xyz'.indexOf(side[1]);
  return scale(vec([Number(axis === 0), Number(axis === 1), Number(axis === 2)]), sign);
}

/** Returns a plane next to the tool. @type {(planes: Plane[], kind: Plane['kind'], side: string, tool: Vec3) => Plane} */
export function newPlane(planes, kind, side, tool) {
  let number = 1;
  while (planes.some(({ name }) => name === `${kind} ${number}`)) number += 1;
  const offset = Math.round((dot(normalOf(side), tool) + 0.05) * 1000) / 1000;
  return { name: `${kind} ${number}`, kind, side, offset };
}

/** Adds planes to a scenario; `start`: position of the tool at the start, m. @type {(scenario: Scenario, planes: Plane[], start: Vec3) => void} */
export function addPlanes(scenario, planes, start) {
  for (const { name, kind, side, offset } of planes) {
    const normal = normalOf(side);
    if (kind === 'plane') {
      const inequality = /** @type {const} */ ({ kind: 'plane', name, normal, offset_m: offset });
      scenario.controller.inequalities = [...(scenario.controller.inequalities ?? []), { ...inequality, normal: [...normal] }];
    } else {
      const contact = /** @type {const} */ ({ kind: 'plane', ...WALL });
      const distance = offset - dot(normal, start);
      scenario.contacts = [...(scenario.contacts ?? []), { ...contact, normal: [...scale(normal, -1)], offset_m: distance }];
    }
  }
}
