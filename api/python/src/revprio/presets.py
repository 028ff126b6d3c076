"""Tasks for common jobs, with gains from the stability analysis."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from revprio.connection import LOCAL
from revprio.errors import InvalidError
from revprio.models import (
    Axis,
    ConstantProfile,
    ContactLaw,
    ControllerTask,
    EnvironmentAxis,
    ForceLaw,
    Frame,
    Orientation,
    Pose,
    PoseLaw,
    Problem,
    SineProfile,
    StabilityAnswer,
    SurfaceFollowing,
)

AXES: tuple[Axis, ...] = get_args(Axis)

TRANSLATIONS = ("x", "y", "z")

SAFETY_FACTOR = 2.0
"""Factor between the damping of a force law and the ends of its stable interval; see docs/guides/choose-gains.md."""

NEGLIGIBLE = 1e-6
"""Fraction of the largest stable damping below which a tool in free space hardly ever comes to rest."""

LAG_S = 0.03
"""Lag of the arm's velocity loop, s: the default of `Controller(drive=…)`."""

DELAY_PERIODS = 2
"""Delay of a command, periods: the default of `Controller(drive=…)`."""

PREFERRED_LENGTH = {"position": 0.1, "balance": 1.0, "orientation": 2.0}
"""`characteristic_length_m` of an arm of about 1 m; see docs/guides/choose-damping.md."""

MOST_TILT_RAD = 1.4
"""Largest tilt of a surface that a law accepts, rad."""

LATEST_S = 1e6
"""Latest start of a motion, s."""

POSE_GAIN = 2.0
"""Largest gain of a pose law, 1/s. The joints of all built-in arms can follow it."""


def push(  # noqa: PLR0913
    axis: Axis,
    newtons: float,
    hold: Literal["rest"] | Sequence[Axis] | None = "rest",
    *,
    period_s: float = 0.001,
    lag_s: float = LAG_S,
    delay_periods: int = DELAY_PERIODS,
    approach_speed: float | None = None,
    stiffest: float | None = None,
    max_force: float | None = None,
) -> list[ControllerTask]:
    """Returns the tasks that press with a force along one axis, and hold other axes at their initial pose.

    The law `contact` presses on a surface whose stiffness nobody knows; see docs/contact.md.

    `axis`: axis of the base; `newtons`: target force on the environment, N (N·m for an axis of rotation). Its sign is
    the direction in which the tool presses.
    `hold`: axes of a second task, which has a lower priority; `"rest"`: all others; `None`: no second task.
    `period_s`, `lag_s`, `delay_periods`: period T, s, lag of the arm's velocity loop, s, and delay of a command,
    periods. They set the gain of the second task; the law reads those of the controller. The defaults are those of
    `Controller(drive=…)`.
    `approach_speed`: speed of the approach, m/s; default: the largest that keeps 1.2 times the force.
    `stiffest`: stiffness of the stiffest contact, N/m; default: 1e6.
    `max_force`: force at which the tool leaves, N; default: none.
    """
    law = _contact(newtons, approach_speed, stiffest, max_force)
    return _pushing(axis, law, hold, _time_to_rest(period_s, lag_s, delay_periods))


def wipe(  # noqa: PLR0913
    axis: Axis,
    newtons: float,
    along: Axis,
    *,
    stroke_m: float = 0.1,
    speed: float = 0.05,
    start_time_s: float = 0.0,
    frame: Frame = "base",
    max_tilt_rad: float | None = None,
    hold: Literal["rest"] | Sequence[Axis] | None = "rest",
    period_s: float = 0.001,
    lag_s: float = LAG_S,
    delay_periods: int = DELAY_PERIODS,
    approach_speed: float | None = None,
    stiffest: float | None = None,
    max_force: float | None = None,
) -> list[ControllerTask]:
    """Returns the tasks that press with a force along one axis and move back and forth along another one.

    The motion begins at `start_time_s`, also while the tool still approaches the surface. Friction at the surface
    does not change it.

    `axis`: axis along which the tool presses; `newtons`: target force on the environment, N. Its sign is the direction
    in which the tool presses.
    `along`: axis of the motion, x, y or z; `stroke_m`: way from the start along this axis and back, m, negative for the
    other direction; `speed`: largest speed, m/s.
    `start_time_s`: `time_s` of the states at which the motion begins; on the clock of Unix it counts from the first
    state. State it if the tasks replace others while the arm moves, or if the first state has another time than 0: the
    arm would else catch up with the motion, faster than `speed`.
    `frame`: axes of both, the base by default; a `Pose` for a tilted surface.
    `max_tilt_rad`: largest tilt of a surface of unknown direction, whose normal all these axes follow, rad; `None`:
    they stay. See docs/contact.md.
    `hold`: axes of the same frame that a third task holds; `"rest"`: all others; `None`: no third task.
    The other arguments are those of `push`.
    """
    if along not in TRANSLATIONS or along == axis:
        raise _invalid("/along", "give `x`, `y` or `z`, and another axis than the one along which the tool presses")
    if _finite("/stroke_m", stroke_m) == 0:
        raise _invalid("/stroke_m", "give a way; its sign is the direction in which the motion begins")
    if _finite("/speed", speed) <= 0:
        raise _invalid("/speed", "give a number above 0")
    if max_tilt_rad is not None and not 0 < _finite("/max_tilt_rad", max_tilt_rad) <= MOST_TILT_RAD:
        raise _invalid("/max_tilt_rad", f"give a number above 0, and at most {MOST_TILT_RAD}")
    gain = pose_gain(_time_to_rest(period_s, lag_s, delay_periods))
    half = stroke_m / 2
    rate = speed / abs(half)
    # From the start and back: half − half cos ω (t − t_0).
    if not abs(start_time_s) <= LATEST_S:
        detail = f"give up to {LATEST_S:g} s on the clock of the states; on that of Unix it counts from the first state"
        raise _invalid("/start_time_s", detail)
    phase = -math.pi / 2 - rate * start_time_s
    way = SineProfile(
        offset=half,
        amplitude=half,
        angular_frequency_rad_s=rate,
        phase_rad=phase,
        start_time_s=start_time_s or None,
    )
    law = _contact(newtons, approach_speed, stiffest, max_force)
    if max_tilt_rad is not None:
        law = law.model_copy(update={"surface": SurfaceFollowing(max_tilt_rad=max_tilt_rad)})
    sweep = PoseLaw(gain=gain, target_displacement=way)
    held = _held(hold, (axis, along))
    tasks = [
        ControllerTask(name="push", axes=axis, frame=frame, law=law),
        ControllerTask(name="wipe", axes=along, frame=frame, law=sweep),
    ]
    if held:
        tasks.append(ControllerTask(name="hold", axes=held, frame=frame, law=PoseLaw(gain=gain)))
    return tasks


def _contact(
    newtons: float, approach_speed: float | None, stiffest: float | None, max_force: float | None
) -> ContactLaw:
    """Returns the law that presses; refuses numbers without a meaning."""
    if _finite("/newtons", newtons) == 0:
        raise _invalid("/newtons", "give a force; its sign is the direction in which the tool presses")
    for field, value in (("approach_speed", approach_speed), ("stiffest", stiffest), ("max_force", max_force)):
        if value is not None and _finite(f"/{field}", value) <= 0:
            raise _invalid(f"/{field}", "give a number above 0")
    return ContactLaw(
        target_force=ConstantProfile(value=newtons),
        approach_speed=approach_speed,
        stiffest=stiffest,
        max_force=max_force,
    )


def _held(hold: Literal["rest"] | Sequence[Axis] | None, moved: Sequence[Axis]) -> list[Axis]:
    """Returns the axes to hold; refuses those that other tasks move."""
    if hold == "rest":
        return [axis for axis in AXES if axis not in moved]
    held = list(hold or [])
    for index, axis in enumerate(held):
        if axis in moved:
            raise _invalid("/hold", f"leave out `{axis}`, which presses or moves already")
        if axis in held[:index]:
            raise _invalid("/hold", f"give `{axis}` once")
    return held


def _pushing(
    axis: Axis, law: ContactLaw | ForceLaw, hold: Literal["rest"] | Sequence[Axis] | None, to_rest_s: float
) -> list[ControllerTask]:
    """Returns the task with the law, and a second one that holds axes of an arm with this lag and delay together, s."""
    held = _held(hold, (axis,))
    tasks = [ControllerTask(name="push", axes=axis, law=law)]
    if held:
        tasks.append(ControllerTask(name="hold", axes=held, law=PoseLaw(gain=pose_gain(to_rest_s))))
    return tasks


def push_with_damping(  # noqa: PLR0913
    axis: Axis,
    newtons: float,
    hold: Literal["rest"] | Sequence[Axis] | None = "rest",
    *,
    period_s: float = 0.001,
    environment_stiffness: float = 1e4,
    lag_s: float = LAG_S,
    delay_periods: int = DELAY_PERIODS,
    velocity_measured: bool = True,
    inertia: float = 15.0,
    approach_speed: float = 0.1,
) -> list[ControllerTask]:
    """Returns the tasks that push with the law `force`, which must be told the stiffness of the contact.

    Prefer `push`: it needs no stiffness. The law `force` is that of the paper.

    `axis`: axis of the base; `newtons`: target force on the environment, N (N·m for an axis of rotation).
    `hold`: axes of a second task, which has a lower priority; `"rest"`: all others; `None`: no second task.
    `period_s`: the controller's period T, s.
    `environment_stiffness`: stiffness of the stiffest contact, that of object and tool together, N/m. The default is a
    compliant tool or object; steel has 1e5 N/m, and needs an arm that follows faster than the default.
    `lag_s`: lag of the arm's velocity loop, s; `delay_periods`: delay of a command, periods. The defaults are those of
    `Controller(drive=…)`. If your arm is faster, give both the same values.
    `velocity_measured`: whether states contain the measured joint velocity.
    `inertia`: inertia of the force law, kg.
    `approach_speed`: maximum speed in free space, m/s.

    The damping is stable in this contact and in free space, and so large that the tool approaches at `approach_speed`
    at most. It keeps a factor of two from both ends of the stable interval; if the interval is narrower than a
    factor of four, it is the geometric mean of the ends. Raises an `InvalidError` if no damping is stable, or if only
    an unstable one keeps `approach_speed`.
    """
    force = abs(_finite("/newtons", newtons))
    if _finite("/approach_speed", approach_speed) <= 0:
        raise _invalid("/approach_speed", "give a speed above 0 m/s")

    def margin(damping: float, stiffness: float) -> StabilityAnswer:
        return LOCAL.stability(
            inertia=inertia,
            damping=damping,
            environment=EnvironmentAxis(stiffness=stiffness),
            period_s=period_s,
            lag_s=lag_s,
            delay_periods=delay_periods,
            velocity_measured=velocity_measured,
        )

    contact, free = margin(0.0, environment_stiffness), margin(0.0, 0.0)
    damping = _damping(contact, free, force / approach_speed)
    if not all(margin(damping, stiffness).stable for stiffness in (environment_stiffness, 0.0)):
        raise _unstable()
    law = ForceLaw(inertia=inertia, damping=damping, target_force=ConstantProfile(value=newtons))
    return _pushing(axis, law, hold, lag_s + delay_periods * period_s)


def _damping(contact: StabilityAnswer, free: StabilityAnswer, least: float) -> float:
    """Returns the damping of a push that both loops permit. `least`: for the approach speed, N·s/m."""
    low, high = contact.smallest_damping, min(_largest(contact), _largest(free))
    if low is None or free.smallest_damping is None or low >= high:
        raise _unstable()
    middle = math.sqrt(low * high)
    most = max(high / SAFETY_FACTOR, middle)
    if least > most:
        detail = f"this approach speed needs a damping of {least:.4g} N·s/m, and the loop permits {most:.4g} N·s/m"
        raise _invalid("/approach_speed", f"{detail}; increase `approach_speed` or `inertia`, or reduce lag or delay")
    damping = max(min(SAFETY_FACTOR * low, middle), least)
    if damping < NEGLIGIBLE * high:
        raise _invalid("/newtons", "this force is too small to choose a damping; write a `ForceLaw` with your own")
    return damping


def _largest(margin: StabilityAnswer) -> float:
    return math.inf if margin.largest_damping is None else margin.largest_damping


def follow(
    pose: Pose | ArrayLike, *, period_s: float = 0.001, lag_s: float = LAG_S, delay_periods: int = DELAY_PERIODS
) -> list[ControllerTask]:
    """Returns the task that moves the tool to a pose.

    `pose`: tool pose in the base frame, as a `Pose` or a homogeneous matrix, 4 × 4, m.
    `period_s`: the controller's period T, s; `lag_s`: lag of the arm's velocity loop, s; `delay_periods`: delay of a
    command, periods. The defaults are those of `Controller(drive=…)`.

    The gain is half of the one at which lag and delay cause overshoot, and at most 2 1/s.
    """
    target = pose if isinstance(pose, Pose) else _pose(pose)
    law = PoseLaw(gain=pose_gain(lag_s + delay_periods * period_s), target_pose=target)
    return [ControllerTask(name="follow", axes=list(AXES), law=law)]


def characteristic_length(prefer: Literal["position", "balance", "orientation"], *, reach_m: float = 1.0) -> float:
    """Returns the `characteristic_length_m` of a controller whose joints cannot give all that a pose task requests.

    `prefer`: what the rows of one task keep first. `"position"` suits tools that turn freely, `"orientation"` tools
    that must not tilt, `"balance"` others. For a strict order, use two tasks instead.
    `reach_m`: reach of the arm, m; 1 suits arms that reach 0.3 to 4 m.
    """
    if prefer not in PREFERRED_LENGTH:
        raise _invalid("/prefer", f"`{prefer}` is unknown; give `position`, `balance` or `orientation`")
    return PREFERRED_LENGTH[prefer] * reach_m


def _time_to_rest(period_s: float, lag_s: float, delay_periods: int) -> float:
    """Returns lag and delay together, s; refuses what the service refuses of a controller."""
    ranges = (("period_s", period_s, 1e-6, 10), ("lag_s", lag_s, 0, 1), ("delay_periods", delay_periods, 0, 64))
    for field, value, least, most in ranges:
        if not least <= value <= most:
            raise _invalid(f"/{field}", f"give a number from {least:g} to {most:g}")
    return lag_s + delay_periods * period_s


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


def _finite(pointer: str, value: float) -> float:
    if not math.isfinite(value):
        raise _invalid(pointer, "give a finite number")
    return value


def _unstable() -> InvalidError:
    return _invalid(
        "/environment_stiffness",
        "no damping makes this contact stable; reduce lag or delay, increase `inertia`, or soften the tool with a pad",
    )


def _invalid(pointer: str, detail: str) -> InvalidError:
    problem = Problem(type="/problems/invalid", title="Invalid field", status=422, detail=detail)
    return InvalidError(problem.model_copy(update={"pointer": pointer}))
