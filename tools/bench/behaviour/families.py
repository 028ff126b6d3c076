"""The families of motion: what the target does, and when the arm can be expected to follow it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from behaviour import arm as model
from behaviour.rotations import Array, from_rotation_vector, turn_z

PERIOD_S = 0.01
"""Control period T, s."""
GAIN = 8.0
"""Gain K of controllers that receive measured positions, 1/s: that of revprio's teleoperation example."""
SEED = 17

START = model.load().tool(model.HOME)
Interval = tuple[float, float]
"""Start and end, s."""


@dataclass(frozen=True)
class Target:
    """A target as it arrives at a controller."""

    arrival_s: float
    measured_s: float
    """Time at which the pose was measured, s."""
    pose: Array
    """Pose of the tool in the base frame, 4 × 4, m."""
    ahead: tuple[tuple[float, Array], ...] = ()
    """Where the target will be, if its sender knows: times after `measured_s`, s, and poses."""


def every_period(family: Family) -> list[Target]:
    """Returns one exact target per control period, without latency."""
    times = PERIOD_S * np.arange(round(family.duration_s / PERIOD_S))
    return [Target(float(time_s), float(time_s), family.pose(float(time_s))) for time_s in times]


AHEAD_S = 0.04 * np.arange(1, 26)
"""Times after a target at which a sender that knows its motion gives the next ones, s."""


def planned(family: Family) -> list[Target]:
    """Returns one exact target per control period, each with where it will be in the next second."""
    return [
        replace(target, ahead=tuple((float(s), family.pose(target.measured_s + float(s))) for s in AHEAD_S))
        for target in every_period(family)
    ]


@dataclass(frozen=True)
class Family:
    """One motion of the target."""

    name: str
    title: str
    duration_s: float
    pose: Callable[[float], Array]
    """True pose of the target at a time (s), 4 × 4, m."""
    recoveries_s: tuple[float, ...] = ()
    """Times at which a disturbance ends, s. Recovery is counted from there."""
    untracked: tuple[Interval, ...] = ()
    """Times at which no arm could follow: out of reach, just after a jump, while no target arrives."""
    unreachable: tuple[Interval, ...] = ()
    """Times at which no posture within the limits reaches the target, or at which no controller knows it."""
    sender: Callable[[Family], list[Target]] = every_period

    def targets(self) -> list[Target]:
        """Returns the targets in the order of their arrival."""
        return self.sender(self)


def smooth_step(time_s: float, start_s: float, end_s: float) -> float:
    """Returns a motion from 0 to 1 that starts and ends at rest without acceleration."""
    s = float(np.clip((time_s - start_s) / (end_s - start_s), 0, 1))
    return s**3 * (10 - 15 * s + 6 * s**2)


def moved(displacement: tuple[float, float, float]) -> Array:
    """Returns the start pose, moved by a displacement in base axes, m."""
    pose = START.copy()
    pose[:3, 3] += displacement
    return pose


def circle(radius: float, phase: float) -> Array:
    """Returns a point of a circle in the y-z plane through the start."""
    return moved((0.0, radius * np.sin(phase), radius * (np.cos(phase) - 1)))


def slow_circle(time_s: float) -> Array:
    """Radius 0.1 m, 0.2 turns per second, reached within 2 s."""
    return circle(0.1, 0.4 * np.pi * (max(time_s - 2, 0) + 2 * integral_of_step(min(time_s, 2) / 2)))


def integral_of_step(s: float) -> float:
    """Returns the integral of the smooth step from 0 to s ≤ 1."""
    return s**4 * (2.5 - 3 * s + s**2)


def fast_circle(time_s: float) -> Array:
    """Radius 0.25 m: 0.06 turns per second, from 3 s to 7 s 1.2, which needs more than the speed limits."""
    rise = integral_of_step(float(np.clip(time_s - 2.5, 0, 1))) + max(time_s - 3.5, 0)
    fall = integral_of_step(float(np.clip(time_s - 6.5, 0, 1))) + max(time_s - 7.5, 0)
    begin = 2 * integral_of_step(min(time_s, 2) / 2) + max(time_s - 2, 0)
    return circle(0.25, 2 * np.pi * (0.06 * begin + 1.14 * (rise - fall)))


def out_of_reach(time_s: float) -> Array:
    """0.75 m forward, which is 0.35 m out of reach, up and down there, and back."""
    away = smooth_step(time_s, 1, 4) - smooth_step(time_s, 7, 10)
    weave = smooth_step(time_s, 3.5, 4) - smooth_step(time_s, 7, 7.5)
    return moved((0.75 * away, 0.0, 0.15 * weave * np.sin(np.pi * (time_s - 3.5))))


def into_joint_limit(time_s: float) -> Array:
    """Tilts the tool about the base y axis by 2.1 rad, where joint 6 can give 1.6 rad, and back."""
    angle = -2.1 * (smooth_step(time_s, 1, 4) - smooth_step(time_s, 6, 9))
    pose = START.copy()
    pose[:3, :3] = from_rotation_vector(np.array([0, angle, 0])) @ START[:3, :3]
    return pose


def flip(time_s: float) -> Array:
    """Turns the target about the axis of the tool by 170° at once, and back 4 s later."""
    return START @ turn_z(np.radians(-170)) if 1 <= time_s < 5 else START


STEPS_S = (1.0, 3.0, 5.0, 7.0)
"""Times of the steps, s."""
STEPS_M = ((0.0, 0.0, 0.0), (0.1, 0.0, 0.0), (0.1, -0.2, 0.0), (0.0, 0.1, 0.1), (0.0, 0.0, 0.0))
"""Places before the first step and after each of them, from the start, m: steps of 0.10, 0.20, 0.33 and 0.14 m."""


def steps(time_s: float) -> Array:
    """Jumps to a new place at once, without a turn."""
    return moved(STEPS_M[sum(1 if time_s >= step else 0 for step in STEPS_S)])


def figure(speed: float) -> Callable[[float], Array]:
    """Returns a figure of 0.12, 0.18 and 0.12 m with the frequencies ω, 2ω and 3ω; `speed`: its largest one, m/s."""
    # The largest speed of the figure with ω = 1 is 0.519.
    omega = speed / 0.519

    def pose(time_s: float) -> Array:
        size, phase = smooth_step(time_s, 0, 2), omega * time_s
        x, y, z = 0.12 * np.sin(phase), 0.18 * np.sin(2 * phase + 0.5), 0.12 * np.sin(3 * phase + 1.0)
        return moved((size * x, size * y, size * z))

    return pose


JUMPS_S = (3.0, 5.0, 7.0)
"""Times of the jumps of the hand, s."""
DROP_OUTS: tuple[Interval, ...] = ((8.5, 9.3), (10.8, 11.2))
"""Times at which no target arrives, s."""


def hand(time_s: float) -> Array:
    """Returns a figure of eight, 0.12 m high, that jumps by 0.1 m and turns by 0.3 rad at once."""
    phase = 2 * np.pi * 0.2 * max(time_s - 0.5, 0)
    size = 0.06 * smooth_step(time_s, 0.5, 2.5)
    jumps = sum(1 if time_s >= jump else 0 for jump in JUMPS_S)
    side = 0.1 * (jumps % 2)
    pose = moved((0.5 * size * np.sin(phase), side + size * np.sin(phase), size * np.sin(2 * phase)))
    turn = np.array([0.3 * (jumps % 2), 0.0, 0.2 * np.sin(phase)])
    pose[:3, :3] = from_rotation_vector(turn) @ START[:3, :3]
    return pose


def tracker(family: Family, drop_outs: tuple[Interval, ...] = DROP_OUTS) -> list[Target]:
    """Returns targets at 45 Hz with 30 % jitter, 0.3 mm and 2 mrad noise, 0 to 20 ms latency and 5 % losses."""
    random = np.random.default_rng(SEED)
    sent: list[Target] = []
    time_s = 0.0
    while time_s < family.duration_s:
        pose = family.pose(time_s).copy()
        pose[:3, 3] += random.normal(scale=3e-4, size=3)
        pose[:3, :3] = from_rotation_vector(random.normal(scale=2e-3, size=3)) @ pose[:3, :3]
        is_lost = random.uniform() < 0.05 or any(start <= time_s < end for start, end in drop_outs)
        arrival_s = time_s + random.uniform(0, 0.02)
        if not is_lost:
            sent.append(Target(arrival_s, time_s, pose))
        time_s += float(1 + random.uniform(-0.3, 0.3)) / 45
    return sorted(sent, key=lambda target: target.arrival_s)


ALL = (
    Family("slow_circle", "slow circle", 12.0, slow_circle),
    Family("too_fast", "faster than the limits allow", 12.0, fast_circle, recoveries_s=(7.5,)),
    Family(
        "out_of_reach",
        "out of reach and back",
        12.0,
        out_of_reach,
        recoveries_s=(8.8,),
        untracked=((2.4, 8.8),),
        unreachable=((2.4, 8.6),),
    ),
    Family(
        "joint_limit",
        "into a joint limit and back",
        11.0,
        into_joint_limit,
        recoveries_s=(7.2,),
        untracked=((3.0, 7.2),),
        unreachable=((3.0, 7.0),),
    ),
    Family("flip", "orientation flip", 9.0, flip, recoveries_s=(1.0, 5.0), untracked=((1.0, 2.5), (5.0, 6.5))),
    Family(
        "jumping",
        "jumping targets at 45 Hz with drop-outs",
        13.0,
        hand,
        recoveries_s=(*JUMPS_S, *(end for _, end in DROP_OUTS)),
        untracked=(*((jump, jump + 0.8) for jump in JUMPS_S), *((start, end + 0.5) for start, end in DROP_OUTS)),
        unreachable=DROP_OUTS,
        sender=tracker,
    ),
    Family(
        "steps",
        "steps of 0.1 to 0.33 m",
        9.0,
        steps,
        recoveries_s=STEPS_S,
        untracked=tuple((step, step + 0.8) for step in STEPS_S),
    ),
    Family("figure", "figure at 0.6 m/s, known ahead", 9.0, figure(0.6), untracked=((0.0, 2.0),), sender=planned),
    Family(
        "fast_figure", "figure at 0.95 m/s, known ahead", 9.0, figure(0.95), untracked=((0.0, 2.0),), sender=planned
    ),
)


def families(quick: bool) -> list[Family]:
    """Returns all families. `quick`: only their first 2 s."""
    return [shortened(family, 2.0) for family in ALL] if quick else list(ALL)


def shortened(family: Family, duration_s: float) -> Family:
    """Returns the start of a family."""
    ends = tuple(end for end in family.recoveries_s if end < duration_s)
    return replace(family, duration_s=duration_s, recoveries_s=ends)


def inside(times_s: Array, intervals: tuple[Interval, ...]) -> NDArray[np.bool_]:
    """Returns for each time whether it is in one of the intervals."""
    within = np.zeros(len(times_s), dtype=bool)
    for start, end in intervals:
        within |= (times_s >= start) & (times_s < end)
    return within
