"""Chunks of actions from arrays, as policies compute them."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from revprio.bodies import finite_array
from revprio.errors import InvalidError
from revprio.models import ChunkAction, Orientation, Problem, StreamedTarget


def chunk(  # noqa: PLR0913 - what actions may have, by name
    time_s: ArrayLike,
    *,
    position: ArrayLike | None = None,
    orientation: ArrayLike | None = None,
    joint_position: ArrayLike | None = None,
    velocity: ArrayLike | None = None,
    force: ArrayLike | None = None,
    gripper: ArrayLike | None = None,
    align: Literal["time", "progress"] = "time",
) -> StreamedTarget:
    """Returns a target of a task from the arrays of a policy: one row per action.

    `time_s`: times of the actions on the clock of the states, s, k entries. `position`: k × 3, m. `orientation`:
    unit quaternions x, y, z, w, k × 4. `joint_position`: in the order of the task's joints, rad or m. `velocity`
    and `force`: one column for each row of the task, m/s and rad/s, N and N·m. `gripper`: targets of the channel
    `gripper`, k entries. `align`: which actions of a late chunk are past: those before the time of the state, or
    those before the place that the arm has reached.
    """
    times = np.atleast_1d(_numbers("time_s", time_s))
    if times.ndim != 1:
        raise _refusal("time_s", f"an array of shape {times.shape}; give one time per action")
    columns = {
        "position": _rows("position", position, times, 3),
        "orientation": _rows("orientation", orientation, times, 4),
        "joint_position": _rows("joint_position", joint_position, times, None),
        "velocity": _rows("velocity", velocity, times, None),
        "force": _rows("force", force, times, None),
        "gripper": _rows("gripper", gripper, times, 1),
    }
    given = {name: rows for name, rows in columns.items() if rows is not None}
    if not given:
        raise _refusal("position", "the actions have no values; give `position` or another one")

    def action(k: int) -> ChunkAction:
        values = {name: _value(name, rows[k]) for name, rows in given.items()}
        return ChunkAction.model_validate({"time_s": float(times[k]), **values})

    return StreamedTarget(chunk=[action(k) for k in range(len(times))], align=align)


def _value(name: str, row: np.ndarray) -> object:
    if name == "orientation":
        x, y, z, w = row.tolist()
        return Orientation(w=w, x=x, y=y, z=z)
    return float(row[0]) if name == "gripper" else row


def _rows(name: str, values: ArrayLike | None, times: np.ndarray, width: int | None) -> np.ndarray | None:
    """Returns one row per time; refuses other shapes."""
    if values is None:
        return None
    rows = _numbers(name, values)
    if rows.ndim == 1 and width in (None, 1):
        rows = rows[:, np.newaxis]
    if rows.ndim != 2 or len(rows) != len(times) or (width is not None and rows.shape[1] != width):  # noqa: PLR2004
        detail = f"an array of shape {rows.shape}; give {len(times)} rows, one per action, of {width or 'n'} numbers"
        raise _refusal(name, detail)
    return rows


def _numbers(name: str, values: ArrayLike) -> np.ndarray:
    """Returns an array of finite numbers; refuses others, such as texts, ragged lists and complex numbers."""
    try:
        return finite_array(values)
    except ValueError as error:
        raise _refusal(name, str(error)) from error


def _refusal(name: str, detail: str) -> InvalidError:
    problem = Problem(type="/problems/invalid", title="Invalid field", status=422, detail=detail)
    return InvalidError(problem.model_copy(update={"pointer": f"/{name}"}))
