"""The conditions of the runs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from contact_mujoco.arm import Drive
from contact_mujoco.robots import ROBOTS, Robot

STIFFNESSES = (1e3, 3e3, 1e4, 3e4, 1e5, 3e5, 1e6)
"""K, N/m."""
SPEEDS = (0.01, 0.03, 0.1)
"""v, m/s."""
LAGS = (0.0, 0.005, 0.01, 0.02)
"""L, s."""
DELAYS = (0, 1, 2)
"""D, periods."""
PERIODS = (0.001, 0.002, 0.008)
"""T, s."""
TARGETS = (5.0, 30.0, 100.0)
"""F_d, N."""
BANDWIDTHS = (400.0, 150.0, 100.0, 75.0)
"""ω of the velocity loop, rad/s."""
NOISE_N = 0.2
"""σ, N."""


@dataclass(frozen=True)
class Conditions:
    """One run: an arm presses on a wall of unknown stiffness."""

    robot: Robot
    drive: Drive
    period_s: float = 0.002
    """T, s."""
    stiffness: float = 1e5
    """K, N/m."""
    speed: float = 0.03
    """Approach speed v, m/s."""
    target: float = 30.0
    """F_d, N."""
    seed: int = 1
    """It sets the noise, and the part of a period at which the tool touches."""
    stated: Drive | None = None
    """The drive that the controller is told; default: the true one."""

    @property
    def told(self) -> Drive:
        """The drive that the controller is told."""
        return self.stated or self.drive

    @property
    def travel_s(self) -> float:
        """F_d/(K v): the time in which the approach speed builds the force up, s."""
        return self.target / (self.stiffness * self.speed)

    @property
    def band(self) -> float:
        """Half the width of the band of a settled force, N."""
        return max(0.05 * self.target, 1.0)

    @property
    def words(self) -> str:
        """The conditions in a line."""
        drive = f"{self.drive.bandwidth:.0f} rad/s L {self.drive.lag_s * 1e3:.0f} ms D {self.drive.delay_periods}"
        wall = f"K {self.stiffness:.0e} v {self.speed * 100:.0f} cm/s F {self.target:.0f} N"
        return f"{self.robot.name} {drive} T {self.period_s * 1e3:.0f} ms {wall} seed {self.seed}"

    @property
    def timestep_s(self) -> float:
        """Time step of the physics, s."""
        return 1e-4 if self.stiffness > 2e4 else 2e-4


def draw(robot: Robot, bandwidth: float, count: int) -> list[Conditions]:
    """Returns conditions drawn at random from the grid, each stiffness equally often; the same in each run."""
    random = np.random.default_rng([ROBOTS.index(robot), int(bandwidth), 33])
    drawn = []
    for number in range(count):
        lag, delay, period = random.choice(LAGS), int(random.choice(DELAYS)), float(random.choice(PERIODS))
        drawn.append(
            Conditions(
                robot,
                Drive(bandwidth, float(lag), delay),
                period,
                STIFFNESSES[number % len(STIFFNESSES)],
                float(random.choice(SPEEDS)),
                float(random.choice(TARGETS)),
                seed=number,
            )
        )
    return drawn
