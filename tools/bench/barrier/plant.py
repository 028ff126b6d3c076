"""The arm that all programs drive: joints that follow at once, or with a lag."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from behaviour.rotations import Array

from barrier.scenes import PERIOD_S

PLACES = 5
"""Number of places in a period at which the distance is measured."""


@dataclass(frozen=True)
class Drive:
    """How the joints follow a command."""

    name: str
    lag_s: float
    """Time constant of the joint velocities, s."""


PERFECT = Drive("perfect", 0.0)
LAGGING = Drive("20 ms lag", 0.02)
DRIVES = (PERFECT, LAGGING)


def brake(velocity: Array, acceleration: Array) -> Array:
    """Returns the velocities of the next period if the joints brake with their acceleration limits, n."""
    return np.asarray(np.sign(velocity) * np.maximum(np.abs(velocity) - PERIOD_S * acceleration, 0))


class Plant:
    """Joints that follow their velocity commands with a first-order lag."""

    def __init__(self, position: Array, drive: Drive) -> None:
        """Starts at rest."""
        self.position = position.copy()
        """Joint positions q, n, rad or m."""
        self.velocity = np.zeros_like(position)
        """Joint velocities q̇, n, rad/s or m/s."""
        self._lag_s = drive.lag_s

    def move(self, command: Array) -> list[Array]:
        """Moves over one period and returns the positions at `PLACES` places of it. `command`: n, rad/s or m/s."""
        start, before = self.position, self.velocity
        places = []
        for place in range(1, PLACES + 1):
            time_s = PERIOD_S * place / PLACES
            if self._lag_s == 0:
                self.velocity = command
                self.position = start + time_s * command
            else:
                kept = np.exp(-time_s / self._lag_s)
                self.velocity = command + kept * (before - command)
                self.position = start + time_s * command + self._lag_s * (1 - kept) * (before - command)
            places.append(self.position)
        return places
