"""The score of a run; docs/behaviour.md defines each number."""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np

from behaviour import arm as model
from behaviour.families import PERIOD_S, Family, inside
from behaviour.rotations import Array, rotation_angle
from behaviour.simulate import Record

RADIUS_M = 0.1
"""An angle counts as the motion of a point at this distance, m."""
RECOVERED_M = 0.02
"""Pose error below which the arm follows again, m."""
RECOVERED_FOR_S = 0.2
FROZEN_SPEED = 0.01
"""Norm of the command below which the arm stands still, rad/s."""
FROZEN_FOR_S = 0.5
SLACK_RAD = 5e-4
"""Positions may be this far outside the range: five standard deviations of the noise."""
SPEED_SLACK = 1e-4
"""Commands may exceed a speed limit by this part of it: the tolerance of a solver."""
CUT_OFF_HZ = 3.0


@dataclass(frozen=True)
class Score:
    """The numbers of one run."""

    tracking_mm: float
    """Root mean square of the pose error at the tracked times, mm."""
    position_mm: float
    """The same of the distance alone, mm."""
    angle_mrad: float
    """The same of the angle alone, mrad."""
    acceleration: float
    """Root mean square of the joint accelerations of the commands, rad/s²."""
    acceleration_over_limit: float
    """Largest acceleration of a command, as a multiple of the joint's limit."""
    vibration: float
    """Power of the commands above 3 Hz, summed over the joints, (rad/s)²."""
    violations: int
    """Periods with a joint outside its range or a command above its speed limit."""
    outside_mrad: float
    """Largest distance outside the range, mrad."""
    freezes: int
    """Times at which the arm stands still although its error is large and the target is reachable."""
    failures: int
    """Periods without an answer."""
    recovery_s: float | None
    """Longest time from the end of a disturbance until the arm follows again, s; none: never, or no disturbance."""
    recoveries_missed: int
    """Disturbances from which the arm did not recover before the next one or the end."""

    def as_json(self) -> dict[str, float | int | None]:
        """Returns the numbers by name, rounded to four significant digits."""
        return {
            name: float(f"{value:.4g}") if isinstance(value, float) else value for name, value in asdict(self).items()
        }


def pose_errors(record: Record, family: Family) -> tuple[Array, Array]:
    """Returns distance (m) and angle (rad) between tool and true target at the start of each period."""
    arm = model.load()
    distances, angles = [], []
    for number, position in enumerate(record.position):
        tool, target = arm.tool(position), family.pose(number * PERIOD_S)
        distances.append(np.linalg.norm(tool[:3, 3] - target[:3, 3]))
        angles.append(rotation_angle(tool[:3, :3].T @ target[:3, :3]))
    return np.array(distances), np.array(angles)


def rms(values: Array) -> float:
    """Returns the root mean square."""
    return float(np.sqrt(np.mean(values**2)))


def runs_of(flags: Array, least: int) -> int:
    """Returns how often a flag holds for at least this many periods without a break."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], flags.astype(int), [0]])))
    return int(np.sum(edges[1::2] - edges[::2] >= least))


def recovery(error: Array, end_s: float, limit_s: float) -> float | None:
    """Returns the time from the end of a disturbance until the error stays small, s; none: not before the limit."""
    least = round(RECOVERED_FOR_S / PERIOD_S)
    first, last = round(end_s / PERIOD_S), round(limit_s / PERIOD_S)
    for number in range(first, last - least + 1):
        if np.all(error[number : number + least] < RECOVERED_M):
            return (number - first) * PERIOD_S
    return None


def recoveries(error: Array, family: Family) -> list[float | None]:
    """Returns the recovery time of each disturbance, s."""
    ends = sorted(family.recoveries_s)
    limits = [*ends, family.duration_s][1:]
    return [recovery(error, end, limit) for end, limit in zip(ends, limits, strict=True)]


def power_above(command: Array) -> float:
    """Returns the power of the commands above the cut-off frequency, (rad/s)²."""
    spectrum = np.abs(np.fft.rfft(command, axis=0)) ** 2
    above = np.fft.rfftfreq(len(command), PERIOD_S) > CUT_OFF_HZ
    return float(2 * spectrum[above].sum() / len(command) ** 2)


def score(record: Record, family: Family) -> Score:
    """Returns the score of a run."""
    arm = model.load()
    times_s = PERIOD_S * np.arange(len(record.position), dtype=np.float64)
    distance, angle = pose_errors(record, family)
    error = np.hypot(distance, RADIUS_M * angle)
    tracked = ~inside(times_s, family.untracked)
    acceleration = np.diff(record.command, axis=0, prepend=0.0) / PERIOD_S
    outside = np.maximum(record.position - arm.upper, arm.lower - record.position).max(axis=1)
    too_fast = (np.abs(record.command) > arm.velocity * (1 + SPEED_SLACK)).any(axis=1)
    still = np.linalg.norm(record.command, axis=1) < FROZEN_SPEED
    frozen = still & (error > RECOVERED_M) & ~inside(times_s, family.unreachable)
    found = recoveries(error, family)
    times = [time_s for time_s in found if time_s is not None]
    return Score(
        tracking_mm=1e3 * rms(error[tracked]),
        position_mm=1e3 * rms(distance[tracked]),
        angle_mrad=1e3 * rms(angle[tracked]),
        acceleration=rms(acceleration),
        acceleration_over_limit=float((np.abs(acceleration) / arm.acceleration).max()),
        vibration=power_above(record.command),
        violations=int(np.sum((outside > SLACK_RAD) | too_fast)),
        outside_mrad=1e3 * max(0.0, float(outside.max())),
        freezes=runs_of(frozen, round(FROZEN_FOR_S / PERIOD_S)),
        failures=int(record.failed.sum()),
        recovery_s=max(times) if times and len(times) == len(found) else None,
        recoveries_missed=len(found) - len(times),
    )
