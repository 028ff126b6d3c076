"""What is measured of a run."""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np

from barrier.scenes import MIN_DISTANCE_M, PERIOD_S, Scene
from barrier.simulate import Record

ROUNDING_M = 1e-6
"""Distance by which a program may be too near without being counted, m."""
REST = 0.01
"""Largest commanded speed of an arm at rest, rad/s or m/s."""
REST_S = 0.2
"""Time at the end of a run in which it must rest, s."""
REACHED_M = 0.005
"""Largest error of the tool that has reached its target, m."""


@dataclass(frozen=True)
class Score:
    """Numbers of one run."""

    start_mm: float
    """Distance at the start, mm."""
    least_mm: float
    """Least distance, mm."""
    end_mm: float
    """Distance at the end, mm."""
    acceleration_over_limit: float
    """Largest change of the command of a joint in a period, as a multiple of what its acceleration limit allows."""
    refused: int
    """Number of periods in which the program refused or failed."""
    error_mm: float
    """Distance of the tool from its target at the end, mm."""
    rests: bool
    """Whether the arm rests at the end."""

    @property
    def is_too_near(self) -> bool:
        """Whether a run that starts outside came nearer than it should."""
        return self.least_mm < 1e3 * (MIN_DISTANCE_M - ROUNDING_M)

    @property
    def has_left(self) -> bool:
        """Whether the arm is as far away at the end as it should."""
        return self.end_mm >= 1e3 * (MIN_DISTANCE_M - ROUNDING_M)

    @property
    def reached(self) -> bool:
        """Whether the tool is at its target at the end."""
        return self.error_mm <= 1e3 * REACHED_M

    @property
    def deeper_mm(self) -> float:
        """How much nearer than at the start the arm came, mm."""
        return max(0.0, self.start_mm - self.least_mm)

    def as_json(self) -> dict[str, float | bool]:
        """Returns the fields, rounded."""
        return {name: value if isinstance(value, bool) else round(value, 6) for name, value in asdict(self).items()}


def score(record: Record, scene: Scene) -> Score:
    """Measures a run."""
    distances = scene.distance(record.position)
    changes = np.diff(record.command, axis=0, prepend=0.0) / PERIOD_S
    end = scene.tool(record.position[-1])
    last = record.command[-round(REST_S / PERIOD_S) :]
    return Score(
        start_mm=float(1e3 * distances[0]),
        least_mm=float(1e3 * distances.min()),
        end_mm=float(1e3 * distances[-1]),
        acceleration_over_limit=float((np.abs(changes) / scene.acceleration).max()),
        refused=int(record.refused.sum()),
        error_mm=float(1e3 * np.linalg.norm(end[:3, 3] - scene.path[1])),
        rests=bool(np.abs(last).max() <= REST),
    )
