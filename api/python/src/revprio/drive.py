"""A real-time control loop with a watchdog."""

from __future__ import annotations

import math
import time
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor, wait
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Protocol

from revprio.bodies import ArrayLike, FloatArray, JointVector
from revprio.controller import Controller
from revprio.errors import RevprioError
from revprio.models import ChannelInput, ObstacleState, StepAnswer, StreamedTarget, Wrench
from revprio.pace import Drive, Pace, SlowLoopWarning
from revprio.watchdog import Watchdog


@dataclass(frozen=True)
class Measurement:
    """Measured values of an arm at one moment; units and shapes as in `Controller.step`."""

    joint_position: JointVector
    joint_velocity: JointVector | None = None
    wrench: Wrench | ArrayLike | None = None
    targets: Mapping[str, StreamedTarget] | None = None
    """The newest targets with their own `time_s`. Give them in every period: a measurement is not sent while an earlier
    one waits for its answer, and the service ignores a repeated target."""
    obstacles: Sequence[ObstacleState] | None = None
    """Where the moving obstacles of the controller are."""
    wrenches: Mapping[str, Wrench | ArrayLike] | None = None
    """The wrenches of other tips than the tool, by the name of the tip."""
    channels: Mapping[str, ChannelInput] | None = None
    """What arrived for channels besides the joints, by name."""
    measured_at_s: float | None = None
    """When the values were measured, s on the clock of `time.monotonic()`; default: when `read` returned."""


def drive(
    controller: Controller,
    read: Callable[[], Measurement],
    write: Callable[[FloatArray], None],
    *,
    watchdog: Watchdog,
    duration_s: float = math.inf,
) -> Drive:
    """Runs a controller in real time. In each period it calls `read`, the service, and `write` (n, rad/s or m/s).

    The service is called in a separate thread. `write` therefore receives a command in every period, however late an
    answer is; the watchdog decides which command is allowed. While no answers come, the arm slows down to rest. The
    loop continues if an answer comes before the arm is at rest.

    Let `read` and `write` return at once. While one of them waits, nothing brakes the arm. If states arrive as packets,
    receive them in a thread of your own, let `read` return the newest one, and give its `measured_at_s`.

    The arm is at rest when the loop ends. The loop ends

    - after `duration_s`;
    - when the arm has come to rest because no answers came: raises the last `NoAnswerError` or `UnavailableError`;
    - when the service refuses a state: raises that `ProblemError`;
    - when `read` fails or the program is interrupted.

    Emits a `SlowLoopWarning`, at most once per second, when more than 5 % of the periods were without an answer.
    """
    state = LoopState(watchdog, controller.period_s)
    pending: Future[StepAnswer] | None = None
    with ThreadPoolExecutor(1, "revprio") as caller, ramp_to_rest(watchdog, write, controller.period_s):
        for tick in ticks(controller.period_s, duration_s):
            state.begin(tick)
            measurement = read()
            if pending is None:
                pending = caller.submit(controller.step, **state.step_arguments(measurement, tick))
            wait([pending], tick.remaining_s())
            if pending.done():
                state.update(pending)
                pending = None
            write(state.command())
            state.report.periods += 1
            time.sleep(tick.remaining_s())
    return state.report


@dataclass(frozen=True)
class Tick:
    """One period: its number, its end and the start of the loop, s on the monotonic clock."""

    number: int
    loop_start_s: float
    end_s: float

    def remaining_s(self) -> float:
        """Returns the time until the end of the period, s."""
        return max(self.end_s - time.monotonic(), 0.0)


def ticks(period_s: float, duration_s: float) -> Iterator[Tick]:
    """Yields the periods of a loop. A period that is already over is skipped."""
    start_s = time.monotonic()
    number = 0
    while number * period_s < duration_s:
        yield Tick(number, start_s, start_s + (number + 1) * period_s)
        number = max(number + 1, int((time.monotonic() - start_s) / period_s))


@contextmanager
def ramp_to_rest(watchdog: Watchdog, write: Callable[[FloatArray], None], period_s: float) -> Iterator[None]:
    """Slows the arm down to rest when the block ends, also after an exception."""
    try:
        yield
    finally:
        watchdog.expire(time.monotonic())
        while not watchdog.is_at_rest(now_s := time.monotonic()):
            write(watchdog.command(now_s + period_s))
            time.sleep(period_s)
        write(watchdog.command(now_s))


class FinishedCall(Protocol):
    """A finished call of the service: a `concurrent.futures.Future` or an `asyncio.Task`."""

    def result(self) -> StepAnswer:
        """Returns the answer or raises the exception of the call."""


class LoopState:
    """State of a control loop between periods: watchdog, statistics, last failure and last measurement time."""

    def __init__(self, watchdog: Watchdog, period_s: float) -> None:
        """`watchdog`: receives the answers and limits the commands; `period_s`: time between two commands, s."""
        self._watchdog, self._period_s = watchdog, period_s
        self._pace = Pace(period_s, time.monotonic())
        self._failure: RevprioError | None = None
        self._measured_at_s = self._period_end_s = -math.inf

    @property
    def report(self) -> Drive:
        """The statistics."""
        return self._pace.report

    def begin(self, tick: Tick) -> None:
        """Starts a period. Warns if the loop cannot keep its period."""
        warning = self._pace.begin(tick.number, time.monotonic())
        if warning is not None:
            warnings.warn(warning, SlowLoopWarning, stacklevel=3)  # at the caller of `drive`

    def step_arguments(self, measurement: Measurement, tick: Tick) -> dict[str, Any]:
        """Returns the arguments of `Controller.step` and stores the time of the measurement."""
        now_s = time.monotonic()
        if not hasattr(measurement, "joint_position"):
            message = f"`read` returned {type(measurement).__name__}; return a `revprio.Measurement(joint_position=…)`"
            raise TypeError(message)
        arguments = dict(vars(measurement))
        stated_s = arguments.pop("measured_at_s", None)
        self._measured_at_s, self._period_end_s = now_s if stated_s is None else stated_s, tick.end_s
        # The start of the period is not the time of the measurement: `read` may have waited for it.
        return {**arguments, "time_s": self._measured_at_s - tick.loop_start_s}

    def update(self, call: FinishedCall) -> None:
        """Processes a finished call. Raises a refusal."""
        try:
            answer = call.result()
        except RevprioError as failure:
            if not failure.is_silence:
                raise
            self._failure = failure
            return
        self._failure = None
        now_s = time.monotonic()
        if self._watchdog.obey(answer, self._measured_at_s, now_s):
            self._pace.answer(self._measured_at_s, now_s, in_time=now_s <= self._period_end_s)

    def command(self) -> FloatArray:
        """Returns the joint velocities to command now; raises the last failure once it has brought the arm to rest."""
        now_s = time.monotonic()
        if self._failure is not None and self._watchdog.is_at_rest(now_s):
            raise self._failure
        return self._watchdog.command(now_s + self._period_s)
