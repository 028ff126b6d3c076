"""A torque-controlled Sawyer arm in MuJoCo presses on a wall with 30 N; revprio computes the joint velocities.

    pip install 'revprio[examples]'
    python mujoco_wall.py --url http://127.0.0.1:8080 --figure mujoco.png

README.md in this directory lists the differences to the built-in simulator and explains the gains.
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
"""Control period T, s; one call of the service per period."""
TIMESTEP_S = 0.0005
"""Time step of the physics and of the inner velocity loop, s."""
GAP_M = 0.01
"""Distance from the tool to the wall at the start, m."""
CONTACT_TIME_S = 0.016
"""Time constant of MuJoCo's contact, s."""
FRICTION_N_M = 0.5
"""Coulomb friction in each joint, N·m; only the integral part of the inner loop compensates it."""
LAG_S = 0.005
"""Lag of the inner loop without friction and torque limits, s."""
TARGET_N = 30.0
WALL_N_PER_M = 1e5
"""Wall stiffness for which the gains are chosen, N/m; the stiffness in MuJoCo is only known after the run."""

Array = NDArray[np.float64]


@dataclass
class Run:
    """Contact force over time."""

    time_s: Array
    force_n: Array

    def measures(self) -> tuple[float, float, float]:
        """Returns peak force, N; settling time to ±5 % of the target, s; mean error over the last tenth, N."""
        outside = np.flatnonzero(np.abs(self.force_n - TARGET_N) > 0.05 * TARGET_N)
        settled = outside[-1] + 1 if outside.size else 0
        settling_s = self.time_s[settled] if settled < self.time_s.size else np.nan
        last = self.force_n[-max(self.force_n.size // 10, 1) :]
        return float(self.force_n.max()), float(settling_s), float(last.mean() - TARGET_N)


class Sawyer:
    """The arm in MuJoCo with an inner velocity loop: computed torque with a proportional and an integral part."""

    def __init__(self, wall_x_m: float) -> None:
        """Creates the arm at rest in the nominal posture."""
        mjcf = sawyer_with_wall(URDF, wall_x_m, TIMESTEP_S, CONTACT_TIME_S, FRICTION_N_M)
        self._model = mujoco.MjModel.from_xml_string(mjcf)
        self._data = mujoco.MjData(self._model)
        self._data.qpos[:] = posture()
        mujoco.mj_forward(self._model, self._data)
        self._integral = np.zeros(7)

    @property
    def position(self) -> Array:
        """Joint position q, 7, rad."""
        return np.array(self._data.qpos)

    @property
    def velocity(self) -> Array:
        """Joint velocity q̇, 7, rad/s."""
        return np.array(self._data.qvel)

    @property
    def tool_m(self) -> Array:
        """Position of the tool point, 3, base frame, m."""
        return np.array(self._data.geom("tool").xpos)

    def wrench(self) -> Array:
        """Returns the wrench of the tool on the wall, 6, base frame, N and N·m; the torque of a sphere is 0."""
        wrench = np.zeros(6)
        for index in range(self._data.ncon):
            contact_force = np.zeros(6)
            mujoco.mj_contactForce(self._model, self._data, index, contact_force)
            # MuJoCo gives the force in the contact frame. Its first axis points from the wall to the tool.
            wrench[:3] += self._data.contact[index].frame.reshape(3, 3).T @ contact_force[:3]
        return wrench

    def follow(self, command: Array) -> None:
        """Simulates one period with commanded joint velocities, rad/s."""
        for _ in range(round(PERIOD_S / TIMESTEP_S)):
            error = command - self._data.qvel
            self._integral += TIMESTEP_S * error
            acceleration = (error + self._integral / (4 * LAG_S)) / LAG_S
            torque = np.zeros(7)
            mujoco.mj_mulM(self._model, self._data, torque, acceleration)
            self._data.ctrl[:] = torque + self._data.qfrc_bias
            mujoco.mj_step(self._model, self._data)


def controller(client: Client) -> ControllerConfig:
    """Returns a controller with a force task along x and an impedance task for the other axes.

    The damping of the force law is 1.5 times the minimum that is stable with this contact stiffness and lag.
    """
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
    """Runs the controller in MuJoCo; returns the run and the measured stiffness of the wall, N/m."""
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
    """Runs the controller in the built-in simulator: the wall is a spring, the arm a first-order lag."""
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
    """Draws the forces of all runs over time."""
    from matplotlib.figure import Figure  # noqa: PLC0415  only needed for a figure

    figure = Figure(figsize=(8, 3.2), layout="constrained")
    axes = figure.subplots()
    for name, run in runs.items():
        axes.plot(run.time_s, run.force_n, label=name, linewidth=1.2)
    axes.axhline(TARGET_N, color="0.5", linewidth=0.8, linestyle="--")
    axes.set(xlabel="time (s)", ylabel="force on the wall (N)")
    axes.legend(frameon=False)
    figure.savefig(path)


def main() -> dict[str, Run]:
    """Runs both simulations, prints a table and draws a figure; returns the runs."""
    parser = argparse.ArgumentParser(description="A Sawyer arm in MuJoCo presses on a wall, controlled by revprio")
    parser.add_argument("--url", default="http://127.0.0.1:8080")
    parser.add_argument("--duration", type=float, default=1.2, help="s")
    parser.add_argument("--figure", help="output file of the figure, .svg or .png")
    options = parser.parse_args()
    with Client(options.url, step_timeout_s=30) as client:
        config = controller(client)
        mujoco_run, stiffness = in_mujoco(client, config, options.duration)
        runs = {"MuJoCo": mujoco_run, "built-in": built_in(client, config, options.duration, stiffness)}
    law = config.tasks[0].law
    assert isinstance(law, ForceLaw)
    print(f"damping of the force law {float(np.asarray(law.damping)):.0f} N·s/m; wall {stiffness:.3g} N/m")
    print(f"{'':10}{'peak (N)':>10}{'settling (s)':>14}{'steady error (N)':>18}")
    for name, run in runs.items():
        peak, settling, error = run.measures()
        print(f"{name:10}{peak:10.1f}{settling:14.3f}{error:18.3f}")
    if options.figure:
        draw(runs, options.figure)
    return runs


if __name__ == "__main__":
    main()
