"""A Gymnasium environment of the Sawyer arm at a wall in MuJoCo, and a loop at 500 Hz that controls it in real time.

    pip install 'revprio[examples]'
    python gymnasium_wall.py

The controller runs in this process. The program prints how well the loop keeps its period.
"""

import argparse
import time
from typing import Any, TypedDict

import gymnasium
import numpy as np
from gymnasium.spaces import Box, Dict, Space
from sawyer_arm import PERIOD_S, TARGET_N, Array, Sawyer, pushing

import revprio


class Observation(TypedDict):
    """Measured values, with the names of the arguments of `Controller.step`."""

    joint_position: Array
    """7, rad."""
    joint_velocity: Array
    """7, rad/s."""
    wrench: Array
    """Of the tool on the wall: force, then torque; 6, N and N·m."""


class SawyerWall(gymnasium.Env[Observation, Array]):
    """The arm presses on a wall.

    Action: joint velocities for one period of 2 ms, 7, rad/s. Observation: `Observation`. Reward: the negative error of
    the force, as a share of its target.
    """

    metadata = {"render_modes": []}  # noqa: RUF012 - as Gymnasium declares it

    def __init__(self) -> None:
        """Creates the arm."""
        self._arm = Sawyer()
        speed = np.array([joint.velocity_limit for joint in revprio.robot("sawyer").joints], dtype=np.float64)
        self.action_space = Box(-speed, speed, dtype=np.float64)
        sizes = {"joint_position": 7, "joint_velocity": 7, "wrench": 6}
        boxes: dict[str, Space[Any]] = {name: Box(-np.inf, np.inf, (n,), np.float64) for name, n in sizes.items()}
        self.observation_space = Dict(boxes)  # type: ignore[assignment]

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Sets the arm at rest, 1 cm in front of the wall. Nothing is random."""
        super().reset(seed=seed, options=options)
        self._arm.reset()
        return self._observation(), {}

    def step(self, action: Array) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Simulates one period. An episode never ends by itself."""
        self._arm.follow(action)
        observation = self._observation()
        error = abs(observation["wrench"][0] - TARGET_N) / TARGET_N
        return observation, -float(error), False, False, {}

    def _observation(self) -> Observation:
        arm = self._arm
        return {"joint_position": arm.position, "joint_velocity": arm.velocity, "wrench": arm.wrench()}


def controller() -> revprio.Controller:
    """Starts a controller in this process."""
    return revprio.Controller(robot="sawyer", period_s=PERIOD_S, tasks=pushing())


class Loop:
    """Connects the environment to `revprio.drive`, and records when each command was sent."""

    def __init__(self) -> None:
        """Resets the environment."""
        self._environment = SawyerWall()
        self.observation, _ = self._environment.reset()
        self.sent_s: list[float] = []

    def read(self) -> revprio.Measurement:
        """Returns the measured values."""
        return revprio.Measurement(**self.observation)

    def write(self, command: Array) -> None:
        """Sends a command."""
        self.sent_s.append(time.monotonic())
        self.observation, *_ = self._environment.step(command)


def in_real_time(duration_s: float) -> tuple[revprio.Drive, Array, Observation]:
    """Controls the arm in real time; returns the statistics, the time between commands, s, and the end at rest."""
    loop = Loop()
    watchdog = revprio.Watchdog.of(revprio.robot("sawyer"))
    with controller() as arm:
        report = revprio.drive(arm, loop.read, loop.write, watchdog=watchdog, duration_s=duration_s)
    periods_s = np.diff(loop.sent_s[: report.periods])
    for _ in range(50):
        loop.write(np.zeros(7))  # the simulated arm follows with a lag
    return report, periods_s, loop.observation


def rate_without_waiting(periods: int) -> float:
    """Returns how many periods of controller and simulation this machine computes per second."""
    loop = Loop()
    with controller() as arm:
        start_s = time.monotonic()
        for _ in range(periods):
            loop.write(arm.step(**loop.observation).joint_velocity)
        return periods / (time.monotonic() - start_s)


def main() -> tuple[revprio.Drive, Observation]:
    """Runs both loops and prints their figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--duration", type=float, default=5.0, help="s")
    duration_s = parser.parse_args().duration
    report, periods_s, end = in_real_time(duration_s)
    print(f"requested rate               {1 / PERIOD_S:8.0f} Hz")
    print(f"achieved rate                {1 / report.achieved_period_s:8.1f} Hz")
    print(f"rate without waiting         {rate_without_waiting(round(duration_s / PERIOD_S)):8.0f} Hz")
    print(f"period, 99 %                 {1e3 * np.quantile(periods_s, 0.99):8.2f} ms")
    print(f"period, longest              {1e3 * periods_s.max():8.2f} ms")
    print(f"periods above 1.5 times 2 ms {100 * np.mean(periods_s > 1.5 * PERIOD_S):8.2f} %")
    print(f"skipped periods              {report.skipped:8d}")
    print(f"force on the wall            {end['wrench'][0]:8.2f} N")
    print(f"largest joint speed          {np.abs(end['joint_velocity']).max():8.0e} rad/s")
    return report, end


if __name__ == "__main__":
    main()
