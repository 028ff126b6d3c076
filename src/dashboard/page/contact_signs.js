// The contacts of the law `contact`: what the scene and its description say of their states, with force and target.

import { fixed } from './number.js';

/**
 * @typedef {import('./types.js').LiveContact} LiveContact
 * @typedef {import('./types.js').LiveSample} LiveSample
 * @typedef {import('./types.js').Controller} Controller
 * @typedef {import('./theme.js').Palette} Palette
 *
 * @typedef {{state: LiveContact['state'], text: string}} ContactSign
 */

/** @type {Record<LiveContact['state'], string>} */
const STATES = { approach: 'approaches the surface', contact: 'in contact', loss: 'lost the surface, goes back', fault: 'gave up and retreated' };

/** @type {Record<NonNullable<LiveContact['fault']>, string>} */
const FAULTS = { pull: 'the force has the wrong sign', stays_in_retreat: 'the force stays in the retreat', force_limit: 'the force limit', stuck: 'the sensor sticks' };

/** Returns what the scene says of each contact. @type {(controller: Controller | undefined, sample: LiveSample | undefined) => ContactSign[]} */
export function contactSigns(controller, sample) {
  return (sample?.contacts ?? []).map(({ task: k, row, state, fault, force, target_force: target }) => {
    const task = controller?.tasks[k];
    const axis = task?.axes?.[row] ?? '';
    const unit = axis.length === 2 ? 'N·m' : 'N';
    const name = (task?.axes?.length ?? 1) > 1 ? `“${task?.name}” ${axis}` : `“${task?.name ?? k + 1}”`;
    const forces = state === 'fault' ? (fault ? `: ${FAULTS[fault]}` : '') : `: ${fixed(force, 1)} of ${fixed(target, 1)} ${unit}`;
    return { state, text: `${name} ${STATES[state]}${forces}` };
  });
}

/** Returns the colour of a state. @type {(state: LiveContact['state'], colours: Palette) => string} */
export const contactColour = (state, { room, accent }) => ({ approach: accent, contact: room.clear, loss: room.near, fault: room.below })[state];
