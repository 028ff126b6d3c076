"""A torque-controlled Sawyer arm in MuJoCo presses on a wall with 30 N; revprio computes the joint velocities.

    pip install 'revprio[examples]'
    python mujoco_wall.py --figure mujoco.png

The program starts a service for the built-in simulator, or uses that of `--url` or `REVPRIO_URL`. README.md in this
directory lists the differences between the two simulators and explains the gains.
"""

import argparse
import os
from contextlib import AbstractContextManager
from dataclasses import dataclass

import numpy as np
from sawyer_arm import GAP_M, LAG_S, PERIOD_S, TARGET_N, Array, Sawyer, pushing
from sawyer_mjcf import posture

import revprio
from revprio import Client, Contact, ControllerConfig, ForceLaw, Scenario, Session, VelocityLoop


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


def in_mujoco(client: Client, config: ControllerConfig, duration_s: float) -> tuple[Run, float]:
    """Runs the controller in MuJoCo; returns the run and the measured stiffness of the wall, N/m."""
    arm = Sawyer()
    forces = []
    with Session(client, config) as session:
        for _ in range(round(duration_s / PERIOD_S)):
            wrench = arm.wrench()
            forces.append(wrench[0])
            answer = session.step(arm.position, joint_velocity=arm.velocity, wrench=wrench)
            arm.follow(answer.joint_velocity)
    stiffness = arm.wrench()[0] / max(arm.depth_m, 1e-9)
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


def service(url: str | None) -> AbstractContextManager[Client]:
    """Returns a client of the service at `url`, or of a service that it starts."""
    return revprio.serve(step_timeout_s=30) if url is None else Client(url, step_timeout_s=30)


def main() -> dict[str, Run]:
    """Runs both simulations, prints a table and draws a figure; returns the runs."""
    parser = argparse.ArgumentParser(description="A Sawyer arm in MuJoCo presses on a wall, controlled by revprio")
    parser.add_argument(
        "--url", default=os.environ.get("REVPRIO_URL"), help="address of a service; default: starts one"
    )
    parser.add_argument("--duration", type=float, default=1.2, help="s")
    parser.add_argument("--figure", help="output file of the figure, .svg or .png")
    options = parser.parse_args()
    config = ControllerConfig(robot="sawyer", period_s=PERIOD_S, tasks=pushing())
    with service(options.url) as client:
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
