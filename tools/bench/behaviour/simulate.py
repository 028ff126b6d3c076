"""Runs controllers on the plant and records what they did."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from behaviour import arm as model
from behaviour.controllers.base import Controller, ControllerError, Setting
from behaviour.families import PERIOD_S, Family, Target
from behaviour.plant import Plant, brake
from behaviour.rotations import Array

Make = Callable[[Setting], Controller]


@dataclass(frozen=True)
class Record:
    """What one run did; one row per period."""

    position: Array
    """True joint positions at the start of each period, periods × n, rad."""
    command: Array
    """Commanded joint velocities, periods × n, rad/s."""
    failed: Array
    """1 if the controller had no answer, else 0; periods."""

    def save(self, path: Path) -> None:
        """Writes the file."""
        path.parent.mkdir(parents=True, exist_ok=True)
        np.savez_compressed(path, position=self.position, command=self.command, failed=self.failed)

    @classmethod
    def load(cls, path: Path) -> Record:
        """Reads the file."""
        with np.load(path) as data:
            return cls(data["position"], data["command"], data["failed"])


def newest(targets: list[Target]) -> Iterator[Target | None]:
    """Returns for each period the newest target that has arrived since the last one."""
    waiting = list(targets)
    measured_s = -np.inf
    number = 0
    while True:
        now_s = number * PERIOD_S + 1e-9
        arrived = [target for target in waiting if target.arrival_s <= now_s and target.measured_s > measured_s]
        waiting = [target for target in waiting if target.arrival_s > now_s]
        chosen = max(arrived, key=lambda target: target.measured_s, default=None)
        if chosen is not None:
            measured_s = chosen.measured_s
        number += 1
        yield chosen


def run(make: Make, family: Family, setting: Setting) -> Record:
    """Lets the arm follow the target of one family.

    Without an answer the joints brake with their acceleration limits, as the watchdog of an arm does.
    """
    plant = Plant(model.HOME, setting.condition)
    own = model.HOME.copy()
    command = np.zeros_like(own)
    rows: list[tuple[Array, Array, bool]] = []
    controller = make(setting)
    arrivals = newest(family.targets())
    try:
        for number in range(round(family.duration_s / PERIOD_S)):
            measured = plant.measure()
            failed = False
            try:
                answer = controller.step(
                    number * PERIOD_S, measured if setting.feed.is_measured else own, next(arrivals)
                )
                if not np.all(np.isfinite(answer)):
                    raise ControllerError("the command is not finite")
                command = answer
            except ControllerError:
                failed = True
                command = brake(command)
            rows.append((plant.position, command, failed))
            own = own + PERIOD_S * command
            plant.move(command)
    finally:
        controller.close()
    positions, commands, failures = zip(*rows, strict=True)
    return Record(np.array(positions), np.array(commands), np.array(failures, dtype=float))


def check_kinematics(controller: Controller) -> None:
    """Raises if the controller's kinematics differ from those of the score."""
    arm = model.load()
    random = np.random.default_rng(1)
    for _ in range(20):
        position = random.uniform(arm.lower, arm.upper)
        error = float(np.abs(controller.tool(position) - arm.tool(position)).max())
        if error > 1e-8:
            raise ValueError(f"tool poses differ by {error:.1e} at {position}")
