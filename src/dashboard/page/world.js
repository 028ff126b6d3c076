// The data of the scene: arm, contacts, planes, forces and targets at the shown time.

import { axisOf, vec } from './arm.js';
import { add, scale, unit } from './geometry.js';
import { ghostsOf, shownTime } from './ghosts.js';
import { hasForces } from './goals.js';
import { positionAt, timeToShow } from './playback.js';
import { jointLabels } from './labels.js';
import { valueAt } from './profile.js';
import { room } from './room.js';
import { methodName } from './setup.js';
import { state } from './state.js';
import { handle } from './target.js';
import { signsOf } from './signs.js';
import { swungPosition } from './swing.js';
import { shownArm, shownController, shownSample } from './view.js';

/**
 * @typedef {import('./run_control.js').RunControl} RunControl
 * @typedef {import('./scene.js').World} World
 * @typedef {import('./scene.js').Contact} Contact
 * @typedef {import('./types.js').Scenario} Scenario
 * @typedef {import('./types.js').Vec3} Vec3
 */

/** Returns the data of the scene; `now`: real time for even motion between samples, s; null: at the samples. @type {(runControl: RunControl, now?: number | null) => World} */
export function world(runControl, now = null) {
  const { history, cursor, watch, visuals, robot } = runControl;
  const kinematics = runControl.kinematics?.robot === robot?.name ? runControl.kinematics : null;
  const position = shownPosition(runControl, now);
  const known = shownArm(runControl);
  const arm = known && kinematics ? kinematics.armAt(known, position) : known;
  const sample = shownSample(runControl);
  const scenario = watch ? null : (runControl.pastScenario ?? runControl.applied);
  // The contacts of an earlier part are stated from its start.
  const part = cursor === null ? undefined : history.segmentAt(cursor);
  const start = vec((part?.start ?? history.start ?? runControl.preview?.tool)?.position ?? [0, 0, 0]);
  const time = shownTime(runControl, now) - (part?.from ?? 0);
  const limited = [...(sample?.at_lower ?? []), ...(sample?.at_upper ?? [])];
  const goal = handle(runControl);
  const contacts = [
    // Doors and round surfaces have no picture.
    ...(scenario?.contacts ?? []).filter(({ radius_m: radius }) => !radius).map((contact) => currentContact(contact, start, time)),
    ...planes(runControl, sample?.active_inequalities ?? []),
  ];
  const about = { robot, labels: jointLabels(robot?.joints.map(({ name }) => name) ?? []), controller: shownController(runControl) };
  return {
    arm,
    signs: kinematics ? signsOf(runControl, about, kinematics, position, contacts, goal) : null,
    atLimit: (arm?.joints ?? []).map((_, joint) => limited.includes(joint)),
    history,
    until: cursor,
    contacts,
    start,
    force: vec(sample?.force ?? [0, 0, 0]),
    target: sample?.target_force ?? [null, null, null],
    push: vec(cursor === null ? (runControl.run?.frame?.external_force ?? [0, 0, 0]) : [0, 0, 0]),
    ghosts: ghostsOf(runControl, now),
    goal,
    room: room(runControl),
    visuals: robot && visuals.get(robot.name) || null,
    position,
    name: methodName(runControl.run?.simulation.method ?? runControl.setup?.method ?? ''),
    swung: kinematics && robot ? swungPosition(kinematics, robot, position, performance.now() / 1000) : null,
    kinematics,
    moves: Boolean(runControl.setup?.motion) && !watch,
  };
}

/** Returns the shown posture, rad or m. @type {(runControl: RunControl, now: number | null) => number[]} */
function shownPosition(runControl, now) {
  const { history, watch, applied, cursor } = runControl;
  const isEven = now !== null && cursor === null && !watch && state.value.phase === 'running';
  const even = isEven ? positionAt(history, timeToShow(history, runControl.setup?.speed ?? 1, now)) : null;
  return even ?? shownSample(runControl)?.joint_position ?? (watch ? [] : (applied?.start_joint_position ?? []));
}

/** Returns whether the page shows forces. @type {(runControl: RunControl) => boolean} */
export function showsForces({ watch, applied }) {
  const shown = watch ? { controller: watch.session.controller } : applied;
  return shown ? hasForces(shown) : true;
}

/** Returns the planes that the controller must not pass. @type {(runControl: RunControl, active: string[]) => Contact[]} */
function planes({ watch, applied, pastScenario }, active) {
  const controller = watch?.session.controller ?? (pastScenario ?? applied)?.controller;
  return (controller?.inequalities ?? []).flatMap((inequality) => {
    if (inequality.kind !== 'plane') return [];
    const inwards = unit(vec(inequality.normal));
    const at = scale(inwards, inequality.offset_m);
    return [{ isWall: true, isVirtual: true, isTouched: active.includes(inequality.name ?? ''), inwards, at }];
  });
}

/**
 * Returns a contact at its current position.
 * @param {NonNullable<Scenario['contacts']>[number]} contact
 * @param {Vec3} start of the tool
 * @param {number} time since then, s
 * @returns {Contact}
 */
function currentContact(contact, start, time) {
  const offset = contact.offset_m ?? 0;
  const isWall = contact.kind !== 'spring';
  const axis = axisOf('xyz'.indexOf(contact.axis ?? 'x'));
  const inwards = contact.normal ? unit(scale(vec(contact.normal), -1)) : scale(axis, isWall && offset < 0 ? -1 : 1);
  const away = offset + (contact.motion ? valueAt(contact.motion, 1, time)[0] : 0);
  return { isWall, isVirtual: false, isTouched: false, inwards, at: add(start, scale(contact.normal ? inwards : axis, away)) };
}
