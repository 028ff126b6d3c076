"""What happens to the wall while an arm presses on it, and drives that are slower than stated."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from contact_mujoco import pressing
from contact_mujoco.conditions import SPEEDS, STIFFNESSES, Conditions, draw
from contact_mujoco.pressing import Trace, Wall
from contact_mujoco.robots import ROBOTS
from contact_mujoco.score import HEAD, Score, row, score
from contact_mujoco.tables import DRIVE, short, table, terms

PUSH_S = 0.01
"""Time in which the wall pushes, s."""
LEAVES_S = 1.5
"""Time for which a wall moves away, and then back, s."""
WALL_SPEEDS = (0.01, 0.02, 0.05)
"""Speeds of a wall that moves, m/s."""


@dataclass(frozen=True)
class Kind:
    """What happens once the force has settled."""

    name: str
    happens: Callable[[float, Wall, Conditions], None]
    """Gets the time since it begins, s, and the wall."""
    stiffnesses: tuple[float, ...]
    """K before, N/m."""


def change(factor: float, since_s: float, wall: Wall, conditions: Conditions) -> None:
    """Changes the stiffness once."""
    if since_s >= 0 and wall.stiffness == conditions.stiffness:
        wall.change(factor)


def push(since_s: float, wall: Wall, conditions: Conditions) -> None:
    """Pushes the tool back by min(2 mm, 3 F_d/K), within 10 ms."""
    way = min(0.002, 3 * conditions.target / conditions.stiffness)
    wall.move(-way * min(max(since_s / PUSH_S, 0.0), 1.0))


def leave(speed: float, since_s: float, wall: Wall, conditions: Conditions) -> None:
    """Moves the wall away for 1.5 s and back for 1.5 s."""
    del conditions
    wall.move(speed * max(min(since_s, 2 * LEAVES_S - since_s), 0.0))


KINDS = (
    Kind("stiffness × 10", partial(change, 10.0), tuple(k for k in STIFFNESSES if k <= 1e5)),
    Kind("stiffness ÷ 10", partial(change, 0.1), tuple(k for k in STIFFNESSES if k >= 1e4)),
    Kind("push", push, STIFFNESSES),
)


def begins_s(conditions: Conditions) -> float:
    """Returns the time after the touch at which an event begins, s."""
    return 1.2 + 1.5 * conditions.travel_s


def run(kind: Kind, conditions: Conditions, lasts_s: float) -> Trace:
    """Runs until some time after the event."""
    begin = begins_s(conditions)

    def event(time_s: float, wall: Wall) -> None:
        kind.happens(time_s - begin, wall, conditions)

    return pressing.run(conditions, event, begin - 1.5 * conditions.travel_s + lasts_s)


def settled_again() -> str:
    """Returns the table of walls that change at once."""
    rows = []
    for kind in KINDS:
        for robot in ROBOTS:
            for stiffness in kind.stiffnesses:
                conditions = terms(robot, stiffness)
                trace = run(kind, conditions, 2.0 + 3 * conditions.travel_s)
                found = score(conditions, trace, begins_s(conditions))
                force = np.array(trace.force)[np.array(trace.time_s) > trace.touched_s + begins_s(conditions)]
                cells = [kind.name, robot.name, short(stiffness), "yes" if found.settled else "no"]
                cells += [f"{force.min():.1f}, {force.max():.1f}", f"{found.settling_s:.2f}", f"{found.error:.2f}"]
                rows.append([*cells, found.losses])
    head = ["event", "arm", "K before, N/m", "settled again", "least, most N", "settled after, s", "error, N", "losses"]
    return table(head, rows)


def moving() -> str:
    """Returns the table of walls that leave and return."""
    rows = []
    for robot in ROBOTS:
        for stiffness in (1e3, 3e3, 1e4, 3e4, 1e5):
            for speed in WALL_SPEEDS:
                conditions = terms(robot, stiffness)
                trace = run(Kind("leave", partial(leave, speed), ()), conditions, 2 * LEAVES_S)
                rows.append(moving_row(conditions, speed, trace))
    head = ["arm", "K, N/m", "wall, cm/s", "away: mean, least N", "back: mean, most N", "losses", "settled"]
    return table(head, rows)


def moving_row(conditions: Conditions, speed: float, trace: Trace) -> list[object]:
    """Returns the row of a wall that leaves and returns: forces in the last second of each way."""
    begin = begins_s(conditions)
    since, force = np.array(trace.time_s) - trace.touched_s - begin, np.array(trace.force)
    away = force[(since > LEAVES_S - 1) & (since < LEAVES_S)]
    back = force[(since > 2 * LEAVES_S - 1) & (since < 2 * LEAVES_S)]
    found = score(conditions, trace, begin)
    cells: list[object] = [conditions.robot.name, short(conditions.stiffness), f"{100 * speed:.0f}"]
    cells += [f"{away.mean():.1f}, {away.min():.1f}", f"{back.mean():.1f}, {back.max():.1f}"]
    return [*cells, found.losses, "yes" if found.settled else "no"]


def understated(count: int) -> str:
    """Returns the table of controllers that are told half of the lag: drawn conditions, without those of no lag."""
    rows = [HEAD.format("arm | approach, cm/s", "---|---")]
    for robot in ROBOTS:
        scores: dict[float, list[Score]] = {speed: [] for speed in SPEEDS}
        for conditions in draw(robot, DRIVE.bandwidth, count):
            drive = conditions.drive
            if drive.lag_s > 0:
                told = replace(conditions, stated=replace(drive, lag_s=0.5 * drive.lag_s))
                scores[conditions.speed].append(score(told, pressing.run(told)))
        rows.extend(row([robot.name, f"{100 * speed:.0f}"], found) for speed, found in scores.items() if found)
    return "\n".join(rows)
