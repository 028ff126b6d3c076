"""Encoders with steps."""

from __future__ import annotations

from itertools import product

import numpy as np
import revprio

from contact_mujoco import pressing
from contact_mujoco.conditions import NOISE_N, Conditions
from contact_mujoco.pressing import Rig
from contact_mujoco.robots import PANDA, Array
from contact_mujoco.score import score
from contact_mujoco.tables import VERDICT, short, table, terms, verdict


class Coarse(Rig):
    """The encoders have steps, and the velocity of the joints is the difference of two readings."""

    def __init__(self, conditions: Conditions, step_rad: float) -> None:
        """`step_rad`: resolution of each joint, rad."""
        self._step_rad = step_rad
        super().__init__(conditions)
        self._last = self._read()

    def _read(self) -> Array:
        return np.asarray(self._step_rad * np.round(self.arm.position / self._step_rad))

    def step(self) -> revprio.StepAnswer:
        """Rounds the positions."""
        position = self._read()
        velocity = (position - self._last) / self.conditions.period_s
        self._last = position
        wrench = self.arm.filtered.copy()
        wrench[:3] += NOISE_N * self._noise.normal(size=3)
        return self.law.step(position, joint_velocity=velocity, wrench=wrench)


def encoders() -> str:
    """Returns the table of coarse position sensors."""
    rows = []
    for step, stiffness in product((1e-5, 1e-3), (1e3, 1e6)):
        conditions = terms(PANDA, stiffness)
        found = score(conditions, pressing.press(Coarse(conditions, step)))
        rows.append([short(step), short(stiffness), *verdict(found)])
    return table(["step, rad", "K, N/m", *VERDICT], rows)
