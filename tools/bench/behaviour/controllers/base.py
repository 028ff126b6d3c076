"""What a controller is for this comparison."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from behaviour.families import GAIN, PERIOD_S, Target
from behaviour.plant import IDEAL, REAL, Condition
from behaviour.rotations import Array


class ControllerError(Exception):
    """The controller has no command for this period."""


class Controller(Protocol):
    """Computes joint velocities from joint positions and the newest target, once per period."""

    def tool(self, position: Array) -> Array:
        """Returns the pose of the tool, 4 × 4, m, by the controller's own kinematics."""

    def step(self, time_s: float, position: Array, new: Target | None) -> Array:
        """Returns the joint velocities, n, rad/s.

        `position`: joint positions, n, rad, of the arm or of the controller's own model; see `Feed`.
        `new`: the newest target, if one has arrived since the last step.
        Raises `ControllerError` if there is no answer.
        """

    def close(self) -> None:
        """Ends the controller."""


@dataclass(frozen=True)
class Feed:
    """Where the joint positions of a controller come from."""

    name: str
    is_measured: bool


MEASURED = Feed("measured", is_measured=True)
"""The sensors of the arm, as every controller needs that shall notice a push or a stop."""
OWN = Feed("own model", is_measured=False)
"""The integral of the controller's own commands. The arm follows them as a position drive would."""


@dataclass(frozen=True)
class Setting:
    """A condition, and where the positions come from."""

    condition: Condition
    feed: Feed

    @property
    def name(self) -> str:
        """Name for tables and files."""
        return self.condition.name if self.condition is IDEAL else f"{self.condition.name}, {self.feed.name}"

    def drive(self) -> Condition:
        """Returns what separates the commands from the positions that the controller receives."""
        return self.condition if self.feed.is_measured else IDEAL

    def gain(self) -> float:
        """Returns the part of an error that a peer removes in one period.

        It is 1 as the peers recommend for a model that follows exactly. With lag and delay in the loop, 1 oscillates.
        """
        return 1.0 if self.drive() is IDEAL else GAIN * PERIOD_S


SETTINGS = (Setting(IDEAL, MEASURED), Setting(REAL, MEASURED), Setting(REAL, OWN))
"""Under ideal conditions measured positions and the own model are the same."""
