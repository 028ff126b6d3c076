// The scenario that continues a run from its present posture, after a change that needs a new run.

import { vec } from './arm.js';
import { dot, norm, sub, unit, scale } from './geometry.js';
import { inTaskFrame, positionRows, referencePose } from './goals.js';
import { toolPose } from './measures.js';
import { negated, shifted } from './profile.js';

/**
 * @typedef {import('./types.js').Scenario} Scenario
 * @typedef {import('./types.js').ControllerTask} Task
 * @typedef {import('./types.js').Contact} Contact
 * @typedef {import('./types.js').TargetProgram} TargetProgram
 * @typedef {import('./types.js').Pose} Pose
 * @typedef {import('./types.js').LiveSample} LiveSample
 * @typedef {import('./types.js').Robot} Robot
 */

/** Minimum duration of the continued run, s. */
const MIN_DURATION = 10;

/**
 * Returns the scenario with the same targets, contacts and pushes, seen from the posture and the time of a sample.
 * @param {Scenario} scenario with the changes of the setup
 * @param {Robot} robot
 * @param {Pose} start pose of the tool at the start of the first run
 * @param {LiveSample} sample
 * @returns {Scenario}
 */
export function continued(scenario, robot, start, sample) {
  const time = sample.time_s;
  const moved = sub(vec(sample.position), vec(start.position));
  /** @type {Scenario} */
  const next = structuredClone(scenario);
  next.duration_s = Math.max(MIN_DURATION, scenario.duration_s - time);
  next.start_joint_position = sample.joint_position.map((q, joint) => withinRange(q, robot.joints[joint].position_limit));
  next.contacts = (scenario.contacts ?? []).map((contact) => continuedContact(contact, moved, time));
  const programs = scenario.target_programs ?? [];
  const ended = programs.filter((program) => hasFound(program, next.contacts ?? []));
  next.target_programs = programs.filter((program) => !ended.includes(program)).map((program) => continuedProgram(program, sample));
  const held = ended.map(({ task }) => task);
  next.controller.tasks = scenario.controller.tasks.map((task) => continuedTask(task, held.includes(task.name) ? toolPose(sample) : start, time));
  next.obstacle_motions = (scenario.obstacle_motions ?? []).map((motion) => ({ ...motion, displacement: shifted(motion.displacement, time) }));
  if (next.external_wrench) next.external_wrench = shifted(next.external_wrench, time);
  if (next.faults?.outages) {
    next.faults.outages = next.faults.outages
      .filter((outage) => outage.start_s > time)
      .map((outage) => ({ ...outage, start_s: outage.start_s - time }));
  }
  return next;
}

/** Samples have single precision, so a joint at its limit can seem to be beyond it. @type {(q: number, range: number[] | null | undefined) => number} */
function withinRange(q, range) {
  return range ? Math.max(range[0], Math.min(range[1], q)) : q;
}

/** @type {(task: Task, start: Pose, time: number) => Task} */
function continuedTask(task, start, time) {
  /** @type {any} */
  const law = structuredClone(task.law);
  for (const name of ['target_displacement', 'target_force', 'target_velocity', 'target_position']) {
    if (typeof law?.[name] === 'object' && law[name]) law[name] = shifted(law[name], time);
  }
  const isInitial = (law?.target_pose ?? 'initial') === 'initial';
  if (positionRows(task).length > 0 && isInitial && ['pose', 'impedance', 'hybrid'].includes(law?.kind)) {
    law.target_pose = inTaskFrame(task, referencePose(task, start));
  }
  return { ...task, law };
}

/** Returns whether a search has led the tool into the hole; its task then holds this place. @type {(program: TargetProgram, contacts: Contact[]) => boolean} `contacts`: as seen from the tool */
function hasFound(program, contacts) {
  return program.kind === 'spiral_search' && contacts.some(({ hole, offset_m: away = 0 }) => hole && away < -program.inserted_m);
}

/** A force along the motion keeps its direction. A search that has found nothing begins anew about the tool. @type {(program: TargetProgram, sample: LiveSample) => TargetProgram} */
function continuedProgram(program, { target_force: force }) {
  if (program.kind !== 'force_along_motion') return program;
  const direction = vec(force.map((part) => (part ?? 0) / program.force));
  return norm(direction) > 0 ? { ...program, start_direction: direction } : program;
}

/** @type {(contact: Contact, moved: [number, number, number], time: number) => Contact} */
function continuedContact(contact, moved, time) {
  const offset = contact.offset_m ?? 0;
  const motion = contact.motion ? shifted(contact.motion, time) : contact.motion;
  const k = 'xyz'.indexOf(contact.axis ?? 'x');
  if (contact.kind === 'spring') return { ...contact, motion, offset_m: offset - moved[k] };
  if (contact.normal && contact.radius_m) return { ...continuedRound(contact, moved), ...(motion && { motion }) };
  if (contact.normal) {
    const { hole, edge } = contact;
    return {
      ...contact, motion, offset_m: offset + dot(unit(vec(contact.normal)), moved),
      ...(hole && { hole: { ...hole, center: sub(vec(hole.center), moved) } }),
      ...(edge && { edge: { ...edge, distance_m: (edge.distance_m ?? 0) - dot(unit(vec(edge.direction)), moved) } }),
    };
  }
  // A tool that touches a wall has passed its surface. A plane keeps its side, a wall would change it.
  const side = offset < 0 ? -1 : 1;
  const normal = scale(vec([Number(k === 0), Number(k === 1), Number(k === 2)]), -side);
  const { axis: _, ...rest } = contact;
  // The motion of a wall is along its axis, that of a plane into its material.
  const inward = motion && side < 0 ? negated(motion) : motion;
  return { ...rest, kind: 'plane', normal, motion: inward, offset_m: side * offset + dot(normal, moved) };
}

/** A cylinder, a sphere or a door keeps its middle. A door, which starts at the tool, is as wide as the tool is away from its hinge. @type {(contact: Contact, moved: [number, number, number]) => Contact} */
function continuedRound(contact, moved) {
  const radius = contact.radius_m ?? 0;
  const offset = contact.offset_m ?? 0;
  const k = contact.axis ? 'xyz'.indexOf(contact.axis) : -1;
  const center = sub(scale(unit(vec(/** @type {number[]} */ (contact.normal))), -(offset + radius)), moved);
  const across = vec(center.map((part, i) => (i === k ? 0 : part)));
  const distance = norm(across);
  if (distance === 0) return contact;
  const normal = scale(across, -1 / distance);
  return contact.kind === 'door' ? { ...contact, normal, radius_m: distance } : { ...contact, normal, offset_m: distance - radius };
}
