"""A control loop in real time, with the watchdog in it."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor, wait
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Protocol

from revprio.bodies import ArrayLike, FloatArray, JointVector
from revprio.controller import Controller
from revprio.errors import RevprioError
from revprio.models import StepAnswer, Wrench
from revprio.watchdog import Watchdog


@dataclass(frozen=True)
class Measurement:
    """What an arm measures at one moment; units and shapes as in `Controller.step`."""

    joint_position: JointVector
    joint_velocity: JointVector | None = None
    wrench: Wrench | ArrayLike | None = None


@dataclass
class Drive:
    """How a loop went."""

    periods: int = 0
    """Control periods."""
    answered: int = 0
    """Periods with an answer to their own state before their end."""


def drive(
    controller: Controller,
    read: Callable[[], Measurement],
    write: Callable[[FloatArray], None],
    *,
    watchdog: Watchdog,
    duration_s: float = math.inf,
) -> Drive:
    """Runs a controller in real time: once per period `read`, call, `write` (n, rad/s or m/s).

    Calls run in a thread of their own, so that `write` is heard in every period, with what the watchdog allows,
    however late an answer is. While the service is silent the arm ramps to rest; if it answers before that, the loop
    goes on. It ends with the arm at rest: after `duration_s`; when silence has led to rest, with the last
    `NoAnswerError` or `UnavailableError`; when the service refuses a state, with that `ProblemError`; and when `read`
    fails or the program is interrupted.
    """
    report = Drive()
    hearing = Hearing(watchdog)
    pending: Future[StepAnswer] | None = None
    with ThreadPoolExecutor(1, "revprio") as caller, ramp_to_rest(watchdog, write, controller.period_s):
        for tick in ticks(controller.period_s, duration_s):
            now = read()
            is_own = pending is None
            if pending is None:
                pending = caller.submit(controller.step, **hearing.ask(now, tick))
            wait([pending], tick.left_s())
            if pending.done():
                report.answered += hearing.hear(pending) and is_own
                pending = None
            write(hearing.command())
            report.periods += 1
            time.sleep(tick.left_s())
    return report


@dataclass(frozen=True)
class Tick:
    """One period: its time since the start of the loop and the moment of its end, s."""

    time_s: float
    end_s: float

    def left_s(self) -> float:
        """Time until its end, s."""
        return max(self.end_s - time.monotonic(), 0.0)


def ticks(period_s: float, duration_s: float) -> Iterator[Tick]:
    """The periods of a loop; those that are over before they could begin are left out."""
    start_s = time.monotonic()
    number = 0
    while number * period_s < duration_s:
        yield Tick(number * period_s, start_s + (number + 1) * period_s)
        number = max(number + 1, int((time.monotonic() - start_s) / period_s))


@contextmanager
def ramp_to_rest(watchdog: Watchdog, write: Callable[[FloatArray], None], period_s: float) -> Iterator[None]:
    """Leaves the arm at rest, whatever ends the loop."""
    try:
        yield
    finally:
        watchdog.expire(time.monotonic())
        while not watchdog.is_at_rest(now_s := time.monotonic()):
            write(watchdog.command(now_s))
            time.sleep(period_s)
        write(watchdog.command(now_s))


class Outcome(Protocol):
    """A call that is over, of a thread or of asyncio."""

    def result(self) -> StepAnswer:
        """Its answer, or what it raised."""


class Hearing:
    """Tells answers from silence."""

    def __init__(self, watchdog: Watchdog) -> None:
        """With the watchdog that shall hear of answers."""
        self._watchdog = watchdog
        self._failure: RevprioError | None = None
        self._asked_at_s = -math.inf

    def ask(self, now: Measurement, tick: Tick) -> dict[str, Any]:
        """The arguments of a step with what was measured just now."""
        self._asked_at_s = time.monotonic()
        return {**vars(now), "time_s": tick.time_s}

    def hear(self, call: Outcome) -> bool:
        """Takes the outcome of a call that is over; whether it is an answer that counts. Raises refusals."""
        try:
            answer = call.result()
        except RevprioError as failure:
            if not failure.is_silence:
                raise
            self._failure = failure
            return False
        self._failure = None
        return self._watchdog.obey(answer, self._asked_at_s, time.monotonic())

    def command(self) -> FloatArray:
        """What to command now; raises the failure that has led to rest."""
        now_s = time.monotonic()
        if self._failure is not None and self._watchdog.is_at_rest(now_s):
            raise self._failure
        return self._watchdog.command(now_s)
