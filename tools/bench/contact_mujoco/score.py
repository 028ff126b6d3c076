"""How good a run is."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from contact_mujoco.conditions import Conditions
from contact_mujoco.pressing import Trace

LAST_S = 0.4
"""Time at the end of a run in which a settled force is judged, s."""


@dataclass(frozen=True)
class Score:
    """What counts of a run."""

    settled: bool
    """No loss in the last 0.4 s, and mean error and rms within max(5 %, 1 N)."""
    peak: float
    """Largest force, N."""
    unavoidable: float
    """Largest force under full reversal, N."""
    allowed: float
    """max(1.2 F_d, 1.1 × the unavoidable peak), N."""
    settling_s: float
    """Time from the touch until the force stays within max(5 %, 1 N), s."""
    allowed_s: float
    """0.5 s + F_d/(K v)."""
    error: float
    """Mean error of the last 0.4 s, N."""
    losses: int
    """How often the tool left the wall after its first touch."""
    fault: str | None
    """Why the law gave up."""
    stiffness: float
    """Stiffness of the wall at the end, N/m."""

    @property
    def misses(self) -> list[str]:
        """The goals that the run misses."""
        missed = {
            "not settled": not self.settled,
            "peak": self.peak > self.allowed,
            "late": self.settling_s > self.allowed_s,
            "error": abs(self.error) > 0.1,
            "losses": self.losses > 1,
            "fault": self.fault is not None,
        }
        return [name for name, is_missed in missed.items() if is_missed]


def score(conditions: Conditions, trace: Trace, since_s: float = 0.0) -> Score:
    """Judges a run; `since_s`: time since the first touch from which on it counts, s."""
    time, force = np.array(trace.time_s), np.array(trace.force)
    touch = int(np.flatnonzero(force > 0)[0])
    first = int(np.searchsorted(time, time[touch] + since_s))
    time, force = time[first:], force[first:]
    last = time > time[-1] - LAST_S
    error, rms = float(np.mean(force[last]) - conditions.target), float(np.std(force[last]))
    away = np.flatnonzero((force[:-1] > 0) & (force[1:] <= 0)) + 1
    outside = np.flatnonzero(np.abs(force - conditions.target) > conditions.band)
    return Score(
        settled=bool(abs(error) < conditions.band and rms < conditions.band and not last[away].any()),
        peak=float(force.max()),
        unavoidable=trace.unavoidable,
        allowed=max(1.2 * conditions.target, 1.1 * trace.unavoidable),
        settling_s=float(time[outside[-1]] - time[0]) if outside.size else 0.0,
        allowed_s=0.5 + conditions.travel_s,
        error=error,
        losses=int(away.size),
        fault=trace.fault,
        stiffness=float(trace.stiffness),
    )


HEAD = """| {} | runs | not settled | peak above allowed, worst | late, worst | error > 0.1 N, worst N \
| more than one loss, most | faults |
|{}|---|---|---|---|---|---|---|"""


def row(names: list[str], scores: Iterable[Score]) -> str:
    """Returns the row of a table."""
    each = list(scores)
    peaks = np.array([score.peak / score.allowed for score in each])
    times = np.array([score.settling_s / score.allowed_s for score in each])
    errors = np.abs([score.error for score in each])
    losses = np.array([score.losses for score in each])
    cells = [
        *names,
        len(each),
        sum(not score.settled for score in each),
        f"{np.sum(peaks > 1)}, {peaks.max():.2f}",
        f"{np.sum(times > 1)}, {times.max():.2f}",
        f"{np.sum(errors > 0.1)}, {errors.max():.2f}",
        f"{np.sum(losses > 1)}, {losses.max()}",
        sum(score.fault is not None for score in each),
    ]
    return f"| {' | '.join(map(str, cells))} |"
