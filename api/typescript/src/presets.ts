import type { Axis, ControllerTask, Law } from "./bodies.js";

const AXES: readonly Axis[] = ["x", "y", "z", "rx", "ry", "rz"];

/** Lag of the arm's velocity loop, s: the default of the `drive` of a controller. */
const LAG_S = 0.03;

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
  if (!Number.isFinite(newtons) || newtons === 0) {
    throw new RangeError("give a force; its sign is the direction in which the tool presses");
  }
  const { hold = "rest", periodS = 0.001, lagS = LAG_S, delayPeriods = DELAY_PERIODS } = options;
  const held = hold === "rest" ? AXES.filter((other) => other !== axis) : (hold ?? []);
  const toRest = lagS + delayPeriods * periodS;
  const law: Law = {
    kind: "contact",
    target_force: { kind: "constant", value: newtons },
    ...(options.approachSpeed !== undefined && { approach_speed: options.approachSpeed }),
    ...(options.stiffest !== undefined && { stiffest: options.stiffest }),
    ...(options.maxForce !== undefined && { max_force: options.maxForce }),
  };
  const tasks: ControllerTask[] = [{ name: "push", axes: [axis], law }];
  if (held.length > 0) {
    const gain = toRest <= 0 ? POSE_GAIN : Math.min(POSE_GAIN, 1 / (8 * toRest));
    tasks.push({ name: "hold", axes: held, law: { kind: "pose", gain } });
  }
  return tasks;
}
