import type { Axis, ControllerTask, Frame, Law } from "./bodies.js";

const AXES: readonly Axis[] = ["x", "y", "z", "rx", "ry", "rz"];

/** Lag of the arm's velocity loop, s: the default of the `drive` of a controller. */
const LAG_S = 0.03;
/** Largest tilt of a surface that a law accepts, rad. */
const MOST_TILT_RAD = 1.4;
/** Latest start of a motion, s. */
const LATEST_S = 1e6;

/** Delay of a command, periods: the default of the `drive` of a controller. */
const DELAY_PERIODS = 2;

/** Largest gain of a pose law, 1/s. */
const POSE_GAIN = 2;

/** Options of {@link push}. */
export interface PushOptions {
  /** Axes of a second task that holds its pose; `"rest"`: all others; `null`: no second task. Default `"rest"`. */
  hold?: "rest" | Axis[] | null;
  /** Period of the controller, s; default 0.001. */
  periodS?: number;
  /** Lag of the arm's velocity loop, s; default 0.03, that of the `drive` of a controller. */
  lagS?: number;
  /** Delay of a command, periods; default 2, that of the `drive` of a controller. */
  delayPeriods?: number;
  /** Speed of the approach, m/s; default: the largest that keeps 1.2 times the force. */
  approachSpeed?: number;
  /** Stiffness of the stiffest contact, N/m; default 1e6. */
  stiffest?: number;
  /** Force at which the tool leaves, N; default: none. */
  maxForce?: number;
}

/**
 * Returns the tasks that press with a force along one axis of the base, and hold other axes at their initial pose. The
 * law `contact` presses on a surface whose stiffness nobody knows; see docs/contact.md.
 *
 * `newtons`: target force on the environment, N (N·m for an axis of rotation). Its sign is the direction in which the
 * tool presses.
 */
export function push(axis: Axis, newtons: number, options: PushOptions = {}): ControllerTask[] {
  const held = heldAxes(options, [axis]);
  const tasks: ControllerTask[] = [{ name: "push", axes: [axis], law: contactLaw(newtons, options) }];
  if (held.length > 0) tasks.push({ name: "hold", axes: held, law: { kind: "pose", gain: poseGain(options) } });
  return tasks;
}

/** Options of {@link wipe}. */
export interface WipeOptions extends PushOptions {
  /** Way from the start along the axis and back, m; negative: the other direction. Default 0.1. */
  strokeM?: number;
  /** Largest speed, m/s; default 0.05. */
  speed?: number;
  /** `time_s` of the states at which the motion begins; on the clock of Unix it counts from the first state. Default 0. */
  startTimeS?: number;
  /** Axes of pressing, motion and hold; a pose for a tilted surface. Default `"base"`. */
  frame?: Frame;
  /** Largest tilt of a surface of unknown direction, whose normal these axes follow, rad; default: they stay. */
  maxTiltRad?: number;
}

/**
 * Returns the tasks that press with a force along one axis and move back and forth along another one, `x`, `y` or `z`.
 * The motion begins at `startTimeS`, also while the tool still approaches the surface. State it if the tasks replace others while
 * the arm moves, or if the first state has another time than 0: the arm would else catch up with the motion, faster than `speed`.
 */
export function wipe(axis: Axis, newtons: number, along: Axis, options: WipeOptions = {}): ControllerTask[] {
  const { strokeM = 0.1, speed = 0.05, startTimeS = 0, frame = "base", maxTiltRad } = options;
  if (!["x", "y", "z"].includes(along) || along === axis) {
    throw new RangeError("move along `x`, `y` or `z`, and along another axis than the one along which the tool presses");
  }
  if (!Number.isFinite(strokeM) || strokeM === 0) {
    throw new RangeError("give a way; its sign is the direction in which the motion begins");
  }
  if (!Number.isFinite(speed) || speed <= 0) throw new RangeError("give a speed above 0");
  if (!(Math.abs(startTimeS) <= LATEST_S)) {
    throw new RangeError("give a start time up to 1e6 s on the clock of the states; on that of Unix it counts from the first state");
  }
  if (maxTiltRad !== undefined && !(maxTiltRad > 0 && maxTiltRad <= MOST_TILT_RAD)) {
    throw new RangeError(`give a largest tilt above 0, and at most ${MOST_TILT_RAD} rad`);
  }
  const gain = poseGain(options);
  const half = strokeM / 2;
  const rate = speed / Math.abs(half);
  const way = {
    kind: "sine" as const,
    offset: half,
    amplitude: half,
    angular_frequency_rad_s: rate,
    phase_rad: -Math.PI / 2 - rate * startTimeS,
    ...(startTimeS !== 0 && { start_time_s: startTimeS }),
  };
  const surface = maxTiltRad === undefined ? {} : { surface: { max_tilt_rad: maxTiltRad } };
  const tasks: ControllerTask[] = [
    { name: "push", axes: [axis], frame, law: { ...contactLaw(newtons, options), ...surface } },
    { name: "wipe", axes: [along], frame, law: { kind: "pose", gain, target_displacement: way } },
  ];
  const held = heldAxes(options, [axis, along]);
  if (held.length > 0) tasks.push({ name: "hold", axes: held, frame, law: { kind: "pose", gain } });
  return tasks;
}

function contactLaw(newtons: number, options: PushOptions): Law {
  if (!Number.isFinite(newtons) || newtons === 0) {
    throw new RangeError("give a force; its sign is the direction in which the tool presses");
  }
  return {
    kind: "contact",
    target_force: { kind: "constant", value: newtons },
    ...(options.approachSpeed !== undefined && { approach_speed: options.approachSpeed }),
    ...(options.stiffest !== undefined && { stiffest: options.stiffest }),
    ...(options.maxForce !== undefined && { max_force: options.maxForce }),
  };
}

/** Axes to hold. Throws a `RangeError` for those that other tasks move. */
function heldAxes({ hold = "rest" }: PushOptions, moved: readonly Axis[]): Axis[] {
  if (hold === "rest") return AXES.filter((axis) => !moved.includes(axis));
  const held = hold ?? [];
  for (const [index, axis] of held.entries()) {
    if (moved.includes(axis)) throw new RangeError(`leave \`${axis}\` out of \`hold\`: it presses or moves already`);
    if (held.indexOf(axis) !== index) throw new RangeError(`give \`${axis}\` once in \`hold\``);
  }
  return held;
}

/** Gain of a pose law, 1/s, for the arm of the options. */
function poseGain({ periodS = 0.001, lagS = LAG_S, delayPeriods = DELAY_PERIODS }: PushOptions): number {
  const toRest = lagS + delayPeriods * periodS;
  return toRest <= 0 ? POSE_GAIN : Math.min(POSE_GAIN, 1 / (8 * toRest));
}
