"""Tasks for common jobs, with gains from the stability analysis."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from revprio.connection import LOCAL
from revprio.errors import InvalidError
from revprio.models import (
    Axis,
    ConstantProfile,
    ControllerTask,
    EnvironmentAxis,
    ForceLaw,
    Orientation,
    Pose,
    PoseLaw,
    Problem,
)

AXES: tuple[Axis, ...] = get_args(Axis)

SAFETY_FACTOR = 2.0
"""Factor between the damping of a force law and the smallest stable one. docs/guides/choose-gains.md explains it."""

POSE_GAIN = 2.0
"""Largest gain of a pose law, 1/s. The joints of all built-in arms can follow it."""


def push(  # noqa: PLR0913
    axis: Axis,
    newtons: float,
    hold: Literal["rest"] | Sequence[Axis] | None = "rest",
    *,
    period_s: float = 0.001,
    environment_stiffness: float = 1e5,
    lag_s: float = 0.005,
    delay_periods: int = 0,
    velocity_measured: bool = True,
    inertia: float = 15.0,
    approach_speed: float = 0.1,
) -> list[ControllerTask]:
    """Returns the tasks that push with a force along one axis, and hold other axes at their initial pose.

    `axis`: axis of the base; `newtons`: target force on the environment, N (N·m for an axis of rotation).
    `hold`: axes of a second task, which has a lower priority; `"rest"`: all others; `None`: no second task.
    `period_s`: the controller's period T, s.
    `environment_stiffness`: stiffness of the stiffest object that the tool may touch, N/m; the default is steel.
    `lag_s`: lag of the arm's velocity loop, s; `delay_periods`: delay of a command, periods.
    `velocity_measured`: whether states contain the measured joint velocity.
    `inertia`: inertia of the force law, kg.
    `approach_speed`: maximum speed in free space, m/s.

    The damping is twice the smallest damping at which the contact is stable, and so large that the tool approaches at
    `approach_speed` at most. Raises an `InvalidError` if no damping makes the contact stable.
    """
    margin = LOCAL.stability(
        inertia=inertia,
        damping=0.0,
        environment=EnvironmentAxis(stiffness=environment_stiffness),
        period_s=period_s,
        lag_s=lag_s,
        delay_periods=delay_periods,
        velocity_measured=velocity_measured,
    )
    if margin.smallest_damping is None:
        raise _unstable()
    damping = max(SAFETY_FACTOR * margin.smallest_damping, abs(newtons) / approach_speed)
    law = ForceLaw(inertia=inertia, damping=damping, target_force=ConstantProfile(value=newtons))
    held = [other for other in AXES if other != axis] if hold == "rest" else list(hold or [])
    tasks = [ControllerTask(name="push", axes=axis, law=law)]
    if held:
        gain = pose_gain(lag_s + delay_periods * period_s)
        tasks.append(ControllerTask(name="hold", axes=held, law=PoseLaw(gain=gain)))
    return tasks


def follow(
    pose: Pose | ArrayLike, *, period_s: float = 0.001, lag_s: float = 0.005, delay_periods: int = 0
) -> list[ControllerTask]:
    """Returns the task that moves the tool to a pose.

    `pose`: tool pose in the base frame, as a `Pose` or a homogeneous matrix, 4 × 4, m.
    `period_s`: the controller's period T, s; `lag_s`: lag of the arm's velocity loop, s; `delay_periods`: delay of a
    command, periods.

    The gain is half of the one at which lag and delay cause overshoot, and at most 2 1/s.
    """
    target = pose if isinstance(pose, Pose) else _pose(pose)
    law = PoseLaw(gain=pose_gain(lag_s + delay_periods * period_s), target_pose=target)
    return [ControllerTask(name="follow", axes=list(AXES), law=law)]


def pose_gain(lag_s: float) -> float:
    """Returns the gain of a pose law, 1/s, for an arm with this lag and delay together, s."""
    return POSE_GAIN if lag_s <= 0 else min(POSE_GAIN, 1 / (8 * lag_s))


def _pose(matrix: ArrayLike) -> Pose:
    transform = np.asarray(matrix, dtype=np.float64)
    if transform.shape != (4, 4) or not np.allclose(transform[3], [0, 0, 0, 1]):
        raise _invalid("/pose", "give a `Pose` or a homogeneous matrix, 4 × 4")
    rotation = transform[:3, :3]
    if not np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-6) or np.linalg.det(rotation) < 0:
        raise _invalid("/pose", "the upper left 3 × 3 part of the matrix is not a rotation")
    return Pose(position=transform[:3, 3], orientation=_quaternion(rotation))


def _quaternion(rotation: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> Orientation:
    """Returns the unit quaternion of a rotation matrix: an eigenvector of the largest eigenvalue (Bar-Itzhack)."""
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = rotation
    k = np.array(
        [
            [xx - yy - zz, yx + xy, zx + xz, zy - yz],
            [yx + xy, yy - xx - zz, zy + yz, xz - zx],
            [zx + xz, zy + yz, zz - xx - yy, yx - xy],
            [zy - yz, xz - zx, yx - xy, xx + yy + zz],
        ]
    )
    x, y, z, w = np.linalg.eigh(k)[1][:, -1]
    return Orientation(w=w, x=x, y=y, z=z)


def _unstable() -> InvalidError:
    return _invalid(
        "/environment_stiffness",
        "no damping makes this contact stable; reduce lag or delay, increase `inertia`, or soften the tool with a pad",
    )


def _invalid(pointer: str, detail: str) -> InvalidError:
    problem = Problem(type="/problems/invalid", title="Invalid field", status=422, detail=detail)
    return InvalidError(problem.model_copy(update={"pointer": pointer}))
