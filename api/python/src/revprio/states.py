"""Measured states with sequence numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from revprio.bodies import ArrayLike, JointVector
from revprio.errors import InvalidError, pointer_to
from revprio.models import ChannelInput, ObstacleState, Problem, State, StreamedTarget, Wrench


class StateNumbering:
    """Gives each state the next sequence number and the start time of its period."""

    def __init__(self, period_s: float) -> None:
        """`period_s`: control period T, s."""
        self.period_s = period_s
        self._next = 0

    def state(  # noqa: PLR0913 - the parts of a state, by name
        self,
        joint_position: JointVector,
        joint_velocity: JointVector | None,
        wrench: Wrench | ArrayLike | None,
        time_s: float | None,
        *,
        targets: Mapping[str, StreamedTarget] | None = None,
        obstacles: Sequence[ObstacleState] | None = None,
        wrenches: Mapping[str, Wrench | ArrayLike] | None = None,
        channels: Mapping[str, ChannelInput] | None = None,
    ) -> State:
        """Returns the next state, without arguments that are `None`. Default of `time_s`: sequence number times T."""
        sequence = self._next
        measured = {
            "joint_velocity": joint_velocity,
            "wrench": wrench if wrench is None else as_wrench(wrench),
            "targets": dict(targets) if targets else None,
            "obstacles": list(obstacles) if obstacles else None,
            "wrenches": as_wrenches(wrenches) if wrenches else None,
            "channels": dict(channels) if channels else None,
        }
        state = State(
            sequence=sequence,
            time_s=sequence * self.period_s if time_s is None else time_s,
            joint_position=joint_position,
            **{name: value for name, value in measured.items() if value is not None},  # type: ignore[arg-type]
        )
        self._next += 1
        return state

    def follow(self, state: State) -> None:
        """Goes on after a state that has its own sequence number."""
        self._next = max(self._next, state.sequence + 1)


def as_wrenches(wrenches: Mapping[str, Wrench | ArrayLike]) -> dict[str, Wrench]:
    """Converts six numbers for each tip to a `Wrench`."""
    return {tip: as_wrench(wrench, pointer_to("wrenches", tip)) for tip, wrench in wrenches.items()}


def as_wrench(wrench: Wrench | ArrayLike, pointer: str = "/wrench") -> Wrench:
    """Converts six numbers (force x, y, z in N, then torque x, y, z in N·m) to a `Wrench`."""
    if isinstance(wrench, Wrench):
        return wrench
    try:
        six = np.asanyarray(wrench)  # a masked array stays one, and is refused
    except ValueError:  # rows of different length
        six = np.empty(0)
    if six.shape != (6,):
        detail = "give six numbers: force x, y, z in N, then torque x, y, z in N·m"
        problem = Problem(type="/problems/invalid", title="Invalid field", status=422, detail=detail)
        raise InvalidError(problem.model_copy(update={"pointer": pointer}))
    try:
        return Wrench(force=six[:3], torque=six[3:])
    except InvalidError as error:
        raise InvalidError(error.problem.model_copy(update={"pointer": f"{pointer}{error.pointer}"})) from None
