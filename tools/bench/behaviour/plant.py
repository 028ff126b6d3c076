"""The arm that every controller drives: lag and delay of its joints, noise of its sensors."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np

from behaviour.arm import load
from behaviour.families import PERIOD_S, SEED
from behaviour.rotations import Array


@dataclass(frozen=True)
class Condition:
    """What separates a command from the motion, and the motion from the measurement."""

    name: str
    lag_s: float = 0.0
    """Time constant of the joint velocities, s."""
    delay_periods: int = 0
    """Whole periods from a measurement to the motion that its command causes."""
    noise_rad: float = 0.0
    """Standard deviation of the measured joint positions, rad."""


IDEAL = Condition("ideal")
REAL = Condition("real", lag_s=0.02, delay_periods=1, noise_rad=1e-4)


def brake(command: Array) -> Array:
    """Returns the command of the next period if the joints brake with their acceleration limits, n, rad/s."""
    slower = np.maximum(np.abs(command) - PERIOD_S * load().acceleration, 0)
    return np.asarray(np.sign(command) * slower)


class Plant:
    """Joints that follow their velocity commands with a first-order lag, after a delay."""

    def __init__(self, position: Array, condition: Condition) -> None:
        """Starts at rest."""
        self.position = position.copy()
        """True joint positions q, n, rad."""
        self.velocity = np.zeros_like(position)
        """True joint velocities q̇, n, rad/s."""
        self._condition = condition
        self._on_their_way = deque([np.zeros_like(position)] * condition.delay_periods)
        self._random = np.random.default_rng(SEED)

    def measure(self) -> Array:
        """Returns the measured joint positions, n, rad."""
        noise = self._random.normal(size=self.position.shape)
        return np.asarray(self.position + self._condition.noise_rad * noise)

    def move(self, command: Array) -> None:
        """Moves over one period, exactly for a constant command. `command`: n, rad/s."""
        self._on_their_way.append(command)
        target = self._on_their_way.popleft()
        lag_s = self._condition.lag_s
        if lag_s == 0:
            self.velocity = target
            self.position = self.position + PERIOD_S * target
            return
        kept = np.exp(-PERIOD_S / lag_s)
        self.position = self.position + PERIOD_S * target + lag_s * (1 - kept) * (self.velocity - target)
        self.velocity = target + kept * (self.velocity - target)
