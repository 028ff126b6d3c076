"""Runs controllers on the plant and records what they did."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from behaviour.rotations import Array

from barrier.controllers.base import Controller
from barrier.plant import Drive, Plant, brake
from barrier.scenes import DURATION_S, PERIOD_S, Scene, Start

Make = Callable[[], Controller]


@dataclass(frozen=True)
class Record:
    """What one run did; one row per period."""

    position: Array
    """Joint positions at the start and at `PLACES` places of each period, (periods · places + 1) × n, rad or m."""
    command: Array
    """Commanded joint velocities, periods × n, rad/s or m/s."""
    refused: Array
    """1 if the program did not do what it should, else 0; periods."""
    step_s: Array
    """Time of each step, periods, s."""

    def save(self, path: Path) -> None:
        """Writes the file."""
        path.parent.mkdir(parents=True, exist_ok=True)
        np.savez_compressed(
            path, position=self.position, command=self.command, refused=self.refused, step_s=self.step_s
        )

    @classmethod
    def load(cls, path: Path) -> Record:
        """Reads the file."""
        with np.load(path) as data:
            return cls(data["position"], data["command"], data["refused"], data["step_s"])


def run(make: Make, scene: Scene, start: Start, drive: Drive, duration_s: float = DURATION_S) -> Record:
    """Leads the tool along the path of the scene.

    Without a command the joints brake with their acceleration limits, as the watchdog of an arm does.
    """
    position = scene.start(start)
    plant = Plant(position, drive)
    target = scene.targets(position)
    command = np.zeros_like(position)
    positions, commands, refused, step_s = [position], [], [], []
    controller = make()
    try:
        for number in range(round(duration_s / PERIOD_S)):
            goal = target((number + 1) * PERIOD_S)
            begin = time.perf_counter()
            answer = controller.step(plant.position.copy(), command.copy(), goal)
            step_s.append(time.perf_counter() - begin)
            velocity = answer.velocity
            is_command = velocity is not None and bool(np.all(np.isfinite(velocity)))
            command = np.asarray(velocity, dtype=float) if is_command else brake(command, scene.acceleration)
            commands.append(command)
            refused.append(answer.refusal is not None or not is_command)
            positions.extend(plant.move(command))
    finally:
        controller.close()
    return Record(np.array(positions), np.array(commands), np.array(refused, dtype=float), np.array(step_s))


def check_kinematics(controller: Controller, scene: Scene) -> None:
    """Raises if the program's kinematics differ from those that measure it."""
    random = np.random.default_rng(1)
    lower, upper = scene.limits("lower"), scene.limits("upper")
    for _ in range(20):
        position = random.uniform(lower, upper)
        error = float(np.abs(controller.tool(position) - scene.tool(position)[:3, 3]).max())
        if error > 1e-8:
            raise ValueError(f"tools differ by {error:.1e} m at {position}")
