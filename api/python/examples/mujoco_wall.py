"""A torque-controlled Sawyer in MuJoCo goes to a wall and presses on it with 30 N; revprio gives its joint velocities.

    pip install 'revprio[examples]'
    python mujoco_wall.py --url http://127.0.0.1:8080 --figure mujoco.png

What differs from the simulator that ships with the service, and what that does to the gains: README.md beside this.
"""

import argparse
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np
from numpy.typing import NDArray
from sawyer_mjcf import posture, sawyer_with_wall

from revprio import (
    Client,
    ConstantProfile,
    Contact,
    ControllerConfig,
    ControllerTask,
    EnvironmentAxis,
    ForceLaw,
    ImpedanceLaw,
    Scenario,
    Session,
    VelocityLoop,
)

URDF = Path(__file__).resolve().parents[3] / "fixtures/robots/sawyer.urdf"
PERIOD_S = 0.002
"""T, s: one call each."""
TIMESTEP_S = 0.0005
"""Of the physics and of the inner loop, s."""
GAP_M = 0.01
"""From the tool to the wall at the start, m."""
CONTACT_TIME_S = 0.016
"""Time constant of MuJoCo's contact, s."""
FRICTION_N_M = 0.5
"""Coulomb friction in each joint, which nothing compensates but the loop, N·m."""
LAG_S = 0.005
"""Of the inner loop without friction and limits of torque, s."""
TARGET_N = 30.0
WALL_N_PER_M = 1e5
"""What the gains are chosen for; the wall of MuJoCo comes out softer or harder than a number in its file."""

Array = NDArray[np.float64]


@dataclass
class Run:
    """Force over time."""

    time_s: Array
    force_n: Array

    def measures(self) -> tuple[float, float, float]:
        """Peak, N; time after which it stays within 5 % of the target, s; mean error over the last tenth, N."""
        outside = np.flatnonzero(np.abs(self.force_n - TARGET_N) > 0.05 * TARGET_N)
        settled = outside[-1] + 1 if outside.size else 0
        settling_s = self.time_s[settled] if settled < self.time_s.size else np.nan
        last = self.force_n[-max(self.force_n.size // 10, 1) :]
        return float(self.force_n.max()), float(settling_s), float(last.mean() - TARGET_N)


class Sawyer:
    """The arm in MuJoCo behind an inner velocity loop: computed torque with a proportional and an integral part."""

    def __init__(self, wall_x_m: float) -> None:
        """At rest in the nominal posture."""
        mjcf = sawyer_with_wall(URDF, wall_x_m, TIMESTEP_S, CONTACT_TIME_S, FRICTION_N_M)
        self._model = mujoco.MjModel.from_xml_string(mjcf)
        self._data = mujoco.MjData(self._model)
        self._data.qpos[:] = posture()
        mujoco.mj_forward(self._model, self._data)
        self._integral = np.zeros(7)

    @property
    def position(self) -> Array:
        """q, 7, rad."""
        return np.array(self._data.qpos)

    @property
    def velocity(self) -> Array:
        """q̇, 7, rad/s."""
        return np.array(self._data.qvel)

    @property
    def tool_m(self) -> Array:
        """Where the tool point is, 3, base frame, m."""
        return np.array(self._data.geom("tool").xpos)

    def wrench(self) -> Array:
        """What the tool exerts on the wall, 6, base frame, N and N·m: its force, no torque as it is a ball."""
        wrench = np.zeros(6)
        for index in range(self._data.ncon):
            of_contact = np.zeros(6)
            mujoco.mj_contactForce(self._model, self._data, index, of_contact)
            # In the frame of the contact, whose first axis points from its first geom, the wall, to the second.
            wrench[:3] += self._data.contact[index].frame.reshape(3, 3).T @ of_contact[:3]
        return wrench

    def follow(self, command: Array) -> None:
        """Lets one period pass under commanded joint velocities, rad/s."""
        for _ in range(round(PERIOD_S / TIMESTEP_S)):
            error = command - self._data.qvel
            self._integral += TIMESTEP_S * error
            acceleration = (error + self._integral / (4 * LAG_S)) / LAG_S
            torque = np.zeros(7)
            mujoco.mj_mulM(self._model, self._data, torque, acceleration)
            self._data.ctrl[:] = torque + self._data.qfrc_bias
            mujoco.mj_step(self._model, self._data)


def controller(client: Client) -> ControllerConfig:
    """Force along x, the rest held; 1.5 times the damping that the margin of this contact and lag asks for."""
    wall = EnvironmentAxis(stiffness=WALL_N_PER_M)
    margin = client.stability(
        inertia=15, damping=150, environment=wall, period_s=PERIOD_S, lag_s=LAG_S, delay_periods=1
    )
    assert margin.smallest_damping is not None
    law = ForceLaw(inertia=15, damping=1.5 * margin.smallest_damping, target_force=ConstantProfile(value=TARGET_N))
    hold = ImpedanceLaw(
        inertia=[15, 15, 80, 80, 80], damping=[150, 150, 280, 280, 280], stiffness=[1000, 1000, 100, 100, 100],
        target_pose="initial",
    )  # fmt: skip
    tasks = [
        ControllerTask(name="push", axes=["x"], law=law),
        ControllerTask(name="hold", axes=["y", "z", "rx", "ry", "rz"], law=hold),
    ]
    return ControllerConfig(robot="sawyer", period_s=PERIOD_S, tasks=tasks)


def in_mujoco(client: Client, config: ControllerConfig, duration_s: float) -> tuple[Run, float]:
    """The run, and how stiff the wall has turned out, N/m."""
    start = client.kinematics(robot="sawyer", joint_position=posture()).pose.position
    wall_x_m = float(np.asarray(start)[0]) + GAP_M
    arm = Sawyer(wall_x_m)
    forces = []
    with Session(client, config) as session:
        for _ in range(round(duration_s / PERIOD_S)):
            wrench = arm.wrench()
            forces.append(wrench[0])
            answer = session.step(arm.position, joint_velocity=arm.velocity, wrench=wrench)
            arm.follow(answer.joint_velocity)
    stiffness = arm.wrench()[0] / max(arm.tool_m[0] - wall_x_m, 1e-9)
    return Run(PERIOD_S * np.arange(len(forces), dtype=np.float64), np.array(forces)), float(stiffness)


def built_in(client: Client, config: ControllerConfig, duration_s: float, stiffness: float) -> Run:
    """The same with the simulator of the service: a spring for the wall, a lag for the arm."""
    scenario = Scenario(
        name="mujoco_equivalent", description="The arm of the MuJoCo example as a lag, its wall as a spring.",
        duration_s=duration_s, start_joint_position=posture(), controller=config,
        velocity_loop=VelocityLoop(lag_s=LAG_S, delay_periods=0),
        contacts=[Contact(axis="x", kind="wall", offset_m=GAP_M, stiffness=stiffness)],
    )  # fmt: skip
    run = client.simulate(scenario=scenario)
    run.result()
    trace = run.trace()
    return Run(trace["time_s"], trace["force_x_n"])


def draw(runs: dict[str, Run], path: str) -> None:
    """Both forces over time."""
    from matplotlib.figure import Figure  # noqa: PLC0415  only where a figure is asked for

    figure = Figure(figsize=(8, 3.2), layout="constrained")
    axes = figure.subplots()
    for name, run in runs.items():
        axes.plot(run.time_s, run.force_n, label=name, linewidth=1.2)
    axes.axhline(TARGET_N, color="0.5", linewidth=0.8, linestyle="--")
    axes.set(xlabel="time (s)", ylabel="force on the wall (N)")
    axes.legend(frameon=False)
    figure.savefig(path)


def main() -> dict[str, Run]:
    """Runs both, prints a table, draws a figure."""
    parser = argparse.ArgumentParser(description="Sawyer of MuJoCo at a wall, driven by revprio")
    parser.add_argument("--url", default="http://127.0.0.1:8080")
    parser.add_argument("--duration", type=float, default=1.2, help="s")
    parser.add_argument("--figure", help="where to draw, .svg or .png")
    options = parser.parse_args()
    with Client(options.url, step_timeout_s=30) as client:
        config = controller(client)
        mujoco_run, stiffness = in_mujoco(client, config, options.duration)
        runs = {"MuJoCo": mujoco_run, "built-in": built_in(client, config, options.duration, stiffness)}
    law = config.tasks[0].law
    assert isinstance(law, ForceLaw)
    print(f"damping of the law {float(np.asarray(law.damping)):.0f} N·s/m; wall {stiffness:.3g} N/m")
    print(f"{'':10}{'peak (N)':>10}{'settling (s)':>14}{'steady error (N)':>18}")
    for name, run in runs.items():
        peak, settling, error = run.measures()
        print(f"{name:10}{peak:10.1f}{settling:14.3f}{error:18.3f}")
    if options.figure:
        draw(runs, options.figure)
    return runs


if __name__ == "__main__":
    main()
