"""Times one control period in Python.

Usage: python steps.py PROGRAM STATES.npz URDF

`states` writes the states of a closed loop: an arm follows two tasks at 1 kHz, and limits of the joint velocities are
active in most periods. `revprio`, `pink`, `mink`, `placo`, `embodik` and `roboplan` compute the command for each of
these states, kinematics included. pink, mink and placo solve in one level: the first task has 1000 times the weight of
the second one. The targets of the other programs are computed before, so that only their own calls are timed.
`limited` times the steps of revprio with active limits, `threads` steps controllers in 1 to 8 threads. `run` runs
all of them, and `table.py` makes a table of the lines.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

PERIODS, PERIOD_S, WEIGHT, ROUNDS, THREAD_ROUNDS = 2000, 1e-3, 1e3, 3, 30
START = np.array([0.3, -0.6, 0.2, 1.4, 0.1, 0.9, 0.0])
AMPLITUDE = np.array([0.8, 0.6, 0.5, 1.5, 1.2, 1.0])
FREQUENCY = np.array([2.0, 3.0, 3.0, 3.0, 3.0, 3.0])
TOOL = "tool"
Array = NDArray[np.float64]
Step = Callable[[int], Array]

STATES, URDF = sys.argv[2:4]


def targets(period: int) -> Array:
    """Returns the tool velocity of a period, m/s and rad/s."""
    velocity: Array = AMPLITUDE * np.sin(FREQUENCY * (period * PERIOD_S))
    return velocity


def errors(rows: slice) -> list[Array]:
    """Returns the errors of a task of pink and mink with these rows, m and rad, by period."""
    return [-PERIOD_S * targets(i)[rows] for i in range(PERIODS)]


def moved(pose: Array, period: int) -> Array:
    """Returns the target pose of a tool with this pose, after the motion of a period."""
    velocity = targets(period)
    x, y, z = PERIOD_S * velocity[3:]
    # Exact to the second order of an angle of a milliradian.
    small = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    target = np.eye(4, order="F")
    target[:3, :3] = (np.eye(3) + small + small @ small / 2) @ pose[:3, :3]
    target[:3, 3] = pose[:3, 3] + PERIOD_S * velocity[:3]
    return target


def configuration() -> Any:  # noqa: ANN401
    """Returns the configuration of a controller of revprio with these targets."""
    import revprio  # noqa: PLC0415 - the other programs need not have it

    def task(name: str, axes: list[revprio.Axis], rows: slice) -> revprio.ControllerTask:
        profile = revprio.SineProfile(amplitude=AMPLITUDE[rows], offset=0, angular_frequency_rad_s=FREQUENCY[rows][0])
        return revprio.ControllerTask(name=name, axes=axes, law=revprio.VelocityLaw(target_velocity=profile))

    tasks = [task("first", ["x"], slice(0, 1)), task("second", ["y", "z", "rx", "ry", "rz"], slice(1, 6))]
    return revprio.ControllerConfig(robot="sawyer", period_s=PERIOD_S, limits="velocity", damping=None, tasks=tasks)


def controller() -> Any:  # noqa: ANN401
    """Returns a controller of revprio with these targets."""
    import revprio  # noqa: PLC0415

    config = configuration()
    return revprio.Controller(**{name: getattr(config, name) for name in config.model_fields_set})


def write_states() -> None:
    """Writes positions, limits, first rows of the Jacobian and the velocities of the first task."""
    import revprio  # noqa: PLC0415

    limit = np.array([joint.velocity_limit for joint in revprio.robot("sawyer").joints])
    q, positions, rows, first, active = START, [], [], [], 0
    with controller() as arm:
        for _ in range(PERIODS):
            answer = arm.step(q)
            positions.append(q)
            rows.append(revprio.kinematics(robot="sawyer", joint_position=q).jacobian[0])
            first.append(answer.tasks[0].achieved[0])
            active += bool(answer.active_limits)
            q = q + PERIOD_S * answer.joint_velocity
    Path(STATES).with_suffix(".positions.json").write_text(json.dumps([list(q) for q in positions]))
    Path(STATES).with_suffix(".controller.json").write_bytes(configuration().json_bytes())
    np.savez(STATES, positions=positions, limit=limit, rows=rows, first=first)
    print(f"limits active in {active / PERIODS:.0%} of {PERIODS} periods")


def with_revprio(states: Any) -> Step:  # noqa: ANN401
    """Steps a controller in the process."""
    arms = [controller() for _ in range(ROUNDS + 1)]
    calls = iter(range(len(arms) * PERIODS))
    return lambda i: arms[next(calls) // PERIODS].step(states["positions"][i]).joint_velocity


def with_pink(states: Any) -> Step:  # noqa: ANN401
    """Solves each state with pink and DAQP."""
    import pink  # noqa: PLC0415
    import pinocchio  # noqa: PLC0415
    from pink.limits import VelocityLimit  # noqa: PLC0415

    model = pinocchio.buildModelFromUrdf(URDF)
    model.velocityLimit = states["limit"]
    data, frame = model.createData(), model.getFrameId(TOOL)

    class Rows(pink.tasks.Task):  # type: ignore[misc]
        def __init__(self, rows: slice, cost: float) -> None:
            super().__init__(cost=cost)
            self.rows, self.errors, self.period = rows, errors(rows), 0

        def __repr__(self) -> str:
            return f"Rows({self.rows})"

        def compute_error(self, _: object) -> Array:
            return self.errors[self.period]

        def compute_jacobian(self, configuration: Any) -> Array:  # noqa: ANN401
            axes = pinocchio.LOCAL_WORLD_ALIGNED
            return pinocchio.getFrameJacobian(configuration.model, configuration.data, frame, axes)[self.rows]  # type: ignore[no-any-return]

    tasks = [Rows(slice(0, 1), WEIGHT**0.5), Rows(slice(1, 6), 1.0)]
    limits = [VelocityLimit(model)]
    configuration = pink.Configuration(model, data, states["positions"][0])

    def step(i: int) -> Array:
        configuration.update(states["positions"][i])
        for task in tasks:
            task.period = i
        return pink.solve_ik(  # type: ignore[no-any-return]
            configuration, tasks, PERIOD_S, solver="daqp", damping=1e-8, limits=limits, safety_break=False
        )

    return step


def with_mink(states: Any) -> Step:  # noqa: ANN401
    """Solves each state with mink and DAQP."""
    import mink  # noqa: PLC0415
    import mujoco  # noqa: PLC0415

    spec = mujoco.MjSpec.from_file(URDF)
    spec.compiler.balanceinertia, spec.compiler.boundmass, spec.compiler.boundinertia = True, 0.01, 0.01
    spec.compiler.fusestatic = False
    model = spec.compile()
    body = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, TOOL)
    linear, angular = np.zeros((3, model.nv)), np.zeros((3, model.nv))

    class Rows(mink.Task):  # type: ignore[misc]
        def __init__(self, rows: slice, cost: float) -> None:
            super().__init__(cost=np.full(rows.stop - rows.start, cost), gain=1.0, lm_damping=0.0)
            self.rows, self.errors, self.period = rows, errors(rows), 0

        def compute_error(self, _: object) -> Array:
            return self.errors[self.period]

        def compute_jacobian(self, configuration: Any) -> Array:  # noqa: ANN401
            mujoco.mj_jacBody(model, configuration.data, linear, angular, body)
            return np.vstack([linear, angular])[self.rows]

    tasks = [Rows(slice(0, 1), WEIGHT**0.5), Rows(slice(1, 6), 1.0)]
    names = [mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_JOINT, i) for i in range(model.njnt)]
    limits = [mink.VelocityLimit(model, dict(zip(names, states["limit"], strict=True)))]
    configuration = mink.Configuration(model)

    def step(i: int) -> Array:
        configuration.update(states["positions"][i])
        for task in tasks:
            task.period = i
        return mink.solve_ik(configuration, tasks, PERIOD_S, solver="daqp", damping=1e-8, limits=limits)  # type: ignore[no-any-return]

    return step


def with_placo(states: Any) -> Step:  # noqa: ANN401
    """Solves each state with placo."""
    import pinocchio  # noqa: PLC0415
    import placo  # noqa: PLC0415

    robot = placo.RobotWrapper(URDF, placo.Flags.ignore_collisions)
    names = list(pinocchio.buildModelFromUrdf(URDF).names)[1:]
    solver = placo.KinematicsSolver(robot)
    solver.mask_fbase(True)
    solver.enable_velocity_limits(True)
    solver.enable_joint_limits(False)
    solver.dt = PERIOD_S
    first, others = (solver.add_position_task(TOOL, np.zeros(3)) for _ in range(2))
    first.mask.set_axises("x")
    others.mask.set_axises("yz")
    rotation = solver.add_orientation_task(TOOL, np.eye(3))
    first.configure("x", "soft", WEIGHT)
    others.configure("yz", "soft", 1.0)
    rotation.configure("rotation", "soft", 1.0)
    solver.add_regularization_task(1e-8)
    for name, limit in zip(names, states["limit"], strict=True):
        robot.set_velocity_limit(name, limit)

    def place(i: int) -> None:
        for name, q in zip(names, states["positions"][i], strict=True):
            robot.set_joint(name, q)
        robot.update_kinematics()

    def target(i: int) -> tuple[Array, Array]:
        place(i)
        pose = moved(robot.get_T_world_frame(TOOL), i)
        return pose[:3, 3].copy(), pose[:3, :3].copy()

    goals = [target(i) for i in range(PERIODS)]

    def step(i: int) -> Array:
        place(i)
        position, rotation.R_world_frame = goals[i]
        first.target_world = others.target_world = position
        return solver.solve(False)[-7:] / PERIOD_S  # type: ignore[no-any-return]

    return step


def with_embodik(states: Any) -> Step:  # noqa: ANN401
    """Solves each state with EmbodiK, whose tasks have priorities and axes, in the mode SCALE of its examples."""
    import embodik  # noqa: PLC0415

    robot = embodik.RobotModel(URDF)
    solver = embodik.KinematicsSolver(robot)
    solver.dt = PERIOD_S
    solver.enable_position_limits(False)
    solver.enable_velocity_limits(True)
    for joint, limit in enumerate(states["limit"]):
        solver.set_joint_velocity_limit(joint, limit)
    first = solver.add_frame_task("first", TOOL, embodik.TaskType.FRAME_POSITION)
    second = solver.add_frame_task("second", TOOL, embodik.TaskType.FRAME_POSE)
    first.priority, second.priority = 0, 1
    first.set_position_mask(np.array([1.0, 0.0, 0.0]))
    second.set_position_mask(np.array([0.0, 1.0, 1.0]))

    goals = [(targets(i)[:3] * [1, 0, 0], targets(i) * [0, 1, 1, 1, 1, 1]) for i in range(PERIODS)]

    def step(i: int) -> Array:
        linear, velocity = goals[i]
        first.set_target_position_velocity(linear)
        second.set_target_velocity(velocity)
        return np.asarray(solver.solve_velocity(states["positions"][i]).joint_velocities)

    return step


def with_roboplan(states: Any) -> Step:  # noqa: ANN401
    """Solves each state with RoboPlan's Oink: one task of the whole tool, because its frame tasks have no axes."""
    from roboplan import core  # noqa: PLC0415
    from roboplan import optimal_ik as oink  # noqa: PLC0415

    scene = core.Scene("sawyer", core.loadUrdfSceneDescriptionFromXml(Path(URDF).read_text()))
    solver = oink.Oink(scene)
    goal = core.CartesianConfiguration()
    goal.base_frame, goal.tip_frame = "base", TOOL
    frame = oink.FrameTask(
        solver,
        scene,
        goal,
        oink.FrameTaskOptions(position_cost=1.0, orientation_cost=1.0, task_gain=1.0, lm_damping=0.0),
    )
    limits = [oink.VelocityLimit(solver, PERIOD_S, states["limit"])]
    displacement = np.zeros(7)
    goals = [moved(np.asarray(scene.forwardKinematics(q, TOOL)), i) for i, q in enumerate(states["positions"])]

    def step(i: int) -> Array:
        scene.setJointPositions(states["positions"][i])
        frame.setTargetFrameTransform(goals[i])
        solver.solveIk(scene, [frame], limits, [], displacement, 1e-8)
        return displacement / PERIOD_S

    return step


def report(name: str, step: Step, states: Any) -> None:  # noqa: ANN401
    """Prints a line: name, median and 99th percentile of the time, µs, limit violation, deviation of the first task."""
    commands = np.array([step(i) for i in range(PERIODS)])
    times = np.zeros((ROUNDS, PERIODS))
    for row in times:
        for i in range(PERIODS):
            start = time.perf_counter()
            step(i)
            row[i] = time.perf_counter() - start
    # The smallest of all rounds: other programs on the machine do not reach it.
    micros = times.min(axis=0) * 1e6
    excess = np.maximum(np.abs(commands) - states["limit"], 0).max()
    first = np.abs(np.einsum("ij,ij->i", states["rows"], commands) - states["first"]).max()
    print(f"{name},{np.median(micros):.2f},{np.quantile(micros, 0.99):.2f},{excess:.1e},{first:.1e}")


def report_limited(states: Any) -> None:  # noqa: ANN401
    """Prints the median time of the steps with active limits; `core_step` prints that of the same steps in Rust."""
    with controller() as arm:
        answers = [arm.step(q) for q in states["positions"]]
    limited = np.array([bool(answer.active_limits) for answer in answers])
    best = np.full(PERIODS, np.inf)
    for _ in range(ROUNDS):
        with controller() as arm:
            for i, q in enumerate(states["positions"]):
                start = time.perf_counter()
                arm.step(q)
                best[i] = min(best[i], time.perf_counter() - start)
    print(f"steps with active limits in Python: {np.median(best[limited]) * 1e6:.2f} µs")


def report_threads(states: Any) -> None:  # noqa: ANN401
    """Prints the steps per second of all threads together."""

    def run(arm: Any) -> None:  # noqa: ANN401
        # Long enough for the operating system to give each thread its core.
        for _ in range(THREAD_ROUNDS):
            for q in states["positions"]:
                arm.step(q)

    for threads in (1, 2, 4, 8):
        seconds = np.inf
        for _ in range(ROUNDS):
            arms = [controller() for _ in range(threads)]
            with ThreadPoolExecutor(threads) as pool:
                start = time.perf_counter()
                list(pool.map(run, arms))
                seconds = min(seconds, time.perf_counter() - start)
        print(f"{threads} threads: {threads * THREAD_ROUNDS * PERIODS / seconds:.0f} steps per second")


def main() -> None:
    """Runs one program."""
    program = sys.argv[1]
    if program == "states":
        return write_states()
    with np.load(STATES) as stored:
        states = dict(stored)
    if program == "threads":
        return report_threads(states)
    if program == "limited":
        return report_limited(states)
    peers = {
        "pink": with_pink,
        "mink": with_mink,
        "placo": with_placo,
        "embodik": with_embodik,
        "roboplan": with_roboplan,
    }
    make = {"revprio": with_revprio, **peers}[program]
    return report(program, make(states), states)


if __name__ == "__main__":
    main()
