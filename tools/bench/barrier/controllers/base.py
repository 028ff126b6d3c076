"""What a controller is for this comparison."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from behaviour.rotations import Array

from barrier.plant import Drive
from barrier.scenes import PERIOD_S, Scene

GAIN = 8.0
"""Gain of the tool's position where the joints lag, 1/s; revprio has it always."""


@dataclass(frozen=True)
class Answer:
    """What a program answers."""

    velocity: Array | None
    """Joint velocities, n, rad/s or m/s; none: there is no command, and the arm brakes."""
    refusal: str | None = None
    """Why the program did not do what it should, in its words."""


class Controller(Protocol):
    """Computes joint velocities from joint positions and the target of the tool, once per period."""

    def tool(self, position: Array) -> Array:
        """Returns the position of the tool, 3, m, by the program's own kinematics."""

    def step(self, position: Array, last: Array, target: Array) -> Answer:
        """Computes one period.

        `position`: joint positions, n, rad or m.
        `last`: the command of the last period, n.
        `target`: pose of the tool, 4 × 4, m.
        """

    def close(self) -> None:
        """Ends the controller."""


@dataclass(frozen=True)
class Task:
    """What a controller shall do."""

    scene: Scene
    drive: Drive
    limits_acceleration: bool
    folder: Path
    """Folder for files that a program reads."""

    def part(self) -> float:
        """Returns the part of an error that a program without gains in 1/s removes in one period.

        It is 1 as these programs recommend for joints that follow at once. With a lag, 1 oscillates.
        """
        return 1.0 if self.drive.lag_s == 0 else GAIN * PERIOD_S
