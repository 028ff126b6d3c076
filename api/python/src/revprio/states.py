"""Measured states with sequence numbers."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from revprio.bodies import ArrayLike, JointVector
from revprio.models import State, StreamedTarget, Wrench


class StateNumbering:
    """Gives each state the next sequence number and the start time of its period."""

    def __init__(self, period_s: float) -> None:
        """`period_s`: control period T, s."""
        self.period_s = period_s
        self._next = 0

    def state(
        self,
        joint_position: JointVector,
        joint_velocity: JointVector | None,
        wrench: Wrench | ArrayLike | None,
        time_s: float | None,
        targets: Mapping[str, StreamedTarget] | None = None,
    ) -> State:
        """Returns the next state, without arguments that are `None`. Default of `time_s`: sequence number times T."""
        sequence = self._next
        measured = {
            "joint_velocity": joint_velocity,
            "wrench": wrench if wrench is None else as_wrench(wrench),
            "targets": dict(targets) if targets else None,
        }
        state = State(
            sequence=sequence,
            time_s=sequence * self.period_s if time_s is None else time_s,
            joint_position=joint_position,
            **{name: value for name, value in measured.items() if value is not None},  # type: ignore[arg-type]
        )
        self._next += 1
        return state


def as_wrench(wrench: Wrench | ArrayLike) -> Wrench:
    """Converts six numbers (force x, y, z in N, then torque x, y, z in N·m) to a `Wrench`."""
    if isinstance(wrench, Wrench):
        return wrench
    six = np.asarray(wrench, dtype=np.float64)
    if six.shape != (6,):
        message = f"wrench: expected 6 numbers (force, then torque), got an array of shape {six.shape}"
        raise ValueError(message)
    return Wrench(force=six[:3], torque=six[3:])
