"""Tables of runs with the same drive."""

from __future__ import annotations

from collections.abc import Iterable

from contact_mujoco.arm import Drive
from contact_mujoco.conditions import Conditions
from contact_mujoco.robots import Robot
from contact_mujoco.score import Score

DRIVE = Drive(150.0, 0.005, 1)
"""Drive of all runs but those of the grid."""


def terms(robot: Robot, stiffness: float, speed: float = 0.03, target: float = 30.0) -> Conditions:
    """Returns conditions with the drive and the period of these runs; `speed`: v, m/s, `target`: F_d, N."""
    return Conditions(robot, DRIVE, 0.002, stiffness, speed, target)


def table(head: Iterable[str], rows: Iterable[Iterable[object]]) -> str:
    """Returns a table in Markdown."""
    names = list(head)
    lines = [names, ["---"] * len(names), *([str(cell) for cell in row] for row in rows)]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def short(value: float) -> str:
    """Returns a power of ten in few letters."""
    return f"{value:.0e}".replace("e+0", "e").replace("e-0", "e-")


def verdict(found: Score) -> list[str]:
    """Returns the cells that most tables share: settled, peak/allowed, time/allowed, error, losses."""
    return [
        "yes" if found.settled else f"no{f', {found.fault}' if found.fault else ''}",
        f"{found.peak / found.allowed:.2f}",
        f"{found.settling_s / found.allowed_s:.2f}",
        f"{found.error:.2f}",
        str(found.losses),
    ]


VERDICT = ["settled", "peak/allowed", "time/allowed", "error, N", "losses"]
