"""Friction at the wall, while the tool presses and moves along it."""

from __future__ import annotations

from itertools import product

import mujoco
import numpy as np
import revprio

from contact_mujoco import pressing, scene
from contact_mujoco.conditions import Conditions
from contact_mujoco.pressing import Rig
from contact_mujoco.robots import DOWN, ROBOTS
from contact_mujoco.score import score
from contact_mujoco.tables import short, table, terms


class Wiping(Rig):
    """The tool presses on a wall with friction, and moves back and forth along it."""

    def __init__(self, conditions: Conditions, sliding: float, speed: float = 0.05) -> None:
        """`sliding`: Coulomb friction; `speed`: largest speed along the wall, m/s."""
        self._sliding, self._speed = sliding, speed
        super().__init__(conditions)

    def model(self) -> mujoco.MjModel:
        """Returns the model of a wall with friction."""
        return scene.model(self.conditions.robot, scene.wall(np.zeros(3), -DOWN, self._sliding))

    def tasks(self) -> list[revprio.ControllerTask]:
        """Returns the tasks of the preset `wipe`."""
        terms, told = self.conditions, self.conditions.told
        return revprio.wipe(
            "z",
            -terms.target,
            "y",
            speed=self._speed,
            approach_speed=terms.speed,
            period_s=terms.period_s,
            lag_s=told.lag_s,
            delay_periods=told.delay_periods,
        )


def friction() -> str:
    """Returns the table of friction: the force in the last two seconds of wiping."""
    rows = []
    for robot, stiffness, sliding in product(ROBOTS, (1e3, 1e4, 1e5, 1e6), (0.0, 0.2, 0.5)):
        conditions = terms(robot, stiffness, target=20.0)
        trace = pressing.press(Wiping(conditions, sliding), extra_s=2.0)
        force = np.array(trace.force)[np.array(trace.time_s) > trace.time_s[-1] - 2.0]
        found = score(conditions, trace)
        cells = [f"{force.mean():.2f}", f"{force.min():.1f}, {force.max():.1f}", found.losses, trace.fault or "–"]
        rows.append([robot.name, short(stiffness), sliding, *cells])
    return table(["arm", "K, N/m", "µ", "mean, N", "least, most N", "losses", "fault"], rows)
