"""Statistics of a control loop, and the warning when it cannot keep its period."""

import asyncio
import importlib
import math
import re
import time
import warnings
from collections.abc import Callable, Iterable
from concurrent.futures import Future
from types import SimpleNamespace
from typing import Any, Self

import numpy as np
import pytest
from conftest import example
from numpy.typing import NDArray

from revprio import ControllerConfig, Drive, Measurement, SlowLoopWarning, StepAnswer, Watchdog, aio, drive
from revprio.models import State
from revprio.pace import Pace
from revprio.remote import RemoteController

ANSWER = StepAnswer.model_validate({**example("answers/step"), "joint_velocity": [0.0] * 7, "valid_for_ms": 100})
CONFIG = ControllerConfig.model_validate(example("controller"))
FAST = CONFIG.model_copy(update={"period_s": 0.001})
SLOW_ANSWER_S = 0.005
FIGURES = re.compile(r"The loop reached (\d+) of (\d+) periods in the last ([\d.]+) s; answers took ([\d.]+) ms\. ")


def simulate(period_s: float, answers_s: Iterable[float]) -> tuple[Pace, list[str]]:
    """Returns the statistics and warnings of a loop whose answers take these times."""
    pace = Pace(period_s, 0.0)
    begun: list[str | None] = []
    number = 0
    for answer_s in answers_s:
        begun.append(pace.begin(number, number * period_s))
        pace.answer(number * period_s, number * period_s + answer_s, in_time=answer_s <= period_s)
        following = number + math.ceil(answer_s / period_s)
        begun += [pace.begin(waiting, waiting * period_s) for waiting in range(number + 1, following)]
        number = following
    return pace, [warning for warning in begun if warning is not None]


def test_answers_of_two_periods_give_one_warning_per_second_with_figures_and_remedy() -> None:
    pace, found = simulate(0.001, [0.0019] * 1600)
    assert len(found) == 3
    expected = (
        "The loop reached 500 of 1000 periods in the last 1.0 s; answers took 1.9 ms. Use a longer period, a stream"
    )
    assert all(warning.startswith(expected) for warning in found)
    report = pace.report
    assert (report.steps, report.answered, report.skipped) == (1600, 0, 0)
    assert report.achieved_period_s == pytest.approx(0.002)
    assert report.longest_period_s == pytest.approx(0.002)


@pytest.mark.parametrize("period_s", [0.001, 0.01, 0.05, 1.0])
def test_single_late_answers_give_no_warning(period_s: float) -> None:
    answers = ([0.2 * period_s] * 49 + [2.5 * period_s]) * 100
    pace, found = simulate(period_s, answers)
    assert found == []
    assert pace.report.answered == 49 * 100
    assert pace.report.achieved_period_s == pytest.approx(52 / 50 * period_s, rel=1e-3)
    assert pace.report.longest_period_s == pytest.approx(3 * period_s)


def test_skipped_periods_are_counted_and_have_another_remedy() -> None:
    pace = Pace(0.01, 5.0)
    found = []
    for number in range(0, 202, 2):
        found.append(pace.begin(number, 5.0 + 0.01 * number))
        pace.answer(5.0 + 0.01 * number, 5.001 + 0.01 * number, in_time=True)
    first, second = (warning for warning in found if warning is not None)
    assert first == second
    assert first.startswith(
        "The loop reached 50 of 100 periods in the last 1.0 s; answers took 1.0 ms. The loop itself"
    )
    assert pace.report.skipped == 100
    assert pace.report.achieved_period_s == pytest.approx(0.02)


def test_a_loop_without_answers_says_so() -> None:
    pace = Pace(0.01, 0.0)
    found = [pace.begin(number, 0.01 * number) for number in range(101)]
    assert "reached 0 of 100 periods in the last 1.0 s; no valid answer came." in str(found[-1])
    assert pace.report == Drive(steps=0, skipped=0, achieved_period_s=math.inf, longest_period_s=0.0)


class Slow(RemoteController):
    """A controller that answers late."""

    def step_state(self, state: State) -> StepAnswer:  # noqa: ARG002
        time.sleep(SLOW_ANSWER_S)
        return ANSWER


class AsyncSlow(aio.AsyncController):
    """A controller that answers late."""

    async def step_state(self, state: State) -> StepAnswer:  # noqa: ARG002
        await asyncio.sleep(SLOW_ANSWER_S)
        return ANSWER

    async def _replace(self, config: ControllerConfig) -> None:
        raise NotImplementedError

    async def open(self) -> None:
        """Does nothing."""

    async def close(self) -> None:
        """Does nothing."""


def read() -> Measurement:
    return Measurement(np.zeros(7))


async def read_async() -> Measurement:
    return read()


def write(_: NDArray[np.float64]) -> None:
    pass


def run_slow(how: str) -> Drive:
    watchdog = Watchdog(np.full(7, 8.0))
    if how == "blocking":
        return drive(Slow(FAST), read, write, watchdog=watchdog, duration_s=3)
    return asyncio.run(aio.drive(AsyncSlow(FAST), read_async, write, watchdog=watchdog, duration_s=3))


@pytest.mark.parametrize("how", ["blocking", "asynchronous"])
def test_a_loop_with_a_slow_controller_warns(how: str) -> None:
    with pytest.warns(SlowLoopWarning) as caught:
        report = run_slow(how)
    # A busy machine makes the loop slower, never faster.
    for warning in caught:
        figures = FIGURES.match(str(warning.message))
        assert figures is not None
        reached, periods, seconds, answer_ms = map(float, figures.groups())
        assert reached <= periods / 5 + 1
        assert periods == pytest.approx(1000 * seconds, abs=60)  # the seconds are rounded to tenths
        assert answer_ms >= 1e3 * SLOW_ANSWER_S
    assert report.answered == 0
    assert 0 < report.steps <= 3 / SLOW_ANSWER_S + 1
    assert 5 * (report.steps - 1) <= report.periods + report.skipped <= 3000
    assert report.longest_period_s >= report.achieved_period_s >= SLOW_ANSWER_S


def test_a_loop_that_keeps_its_period_does_not_warn(monkeypatch: pytest.MonkeyPatch) -> None:
    class Prompt(Slow):
        def step_state(self, state: State) -> StepAnswer:  # noqa: ARG002
            return ANSWER

    now_s = [100.0]

    def sleep(duration_s: float) -> None:
        now_s[0] += duration_s

    clock = SimpleNamespace(monotonic=lambda: now_s[0], sleep=sleep)
    monkeypatch.setattr(importlib.import_module("revprio.drive"), "time", clock)
    config = CONFIG.model_copy(update={"period_s": 1.0})
    with warnings.catch_warnings():
        warnings.simplefilter("error", SlowLoopWarning)
        report = drive(Prompt(config), read, write, watchdog=Watchdog(np.full(7, 8.0)), duration_s=110)
    assert report == Drive(periods=110, answered=110, steps=110, skipped=0, achieved_period_s=1.0, longest_period_s=1.0)


class AtOnce:
    """Makes each call at once, in the thread of the caller."""

    def __init__(self, *_: object) -> None:
        """Takes the arguments of a thread pool."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        """Does nothing."""

    def submit(self, call: Callable[..., StepAnswer], **fields: Any) -> Future[StepAnswer]:  # noqa: ANN401
        """Returns the finished call."""
        finished: Future[StepAnswer] = Future()
        finished.set_result(call(**fields))
        return finished


def test_a_state_has_the_time_at_which_it_was_read(monkeypatch: pytest.MonkeyPatch) -> None:
    times = []

    class Listening(Slow):
        def step_state(self, state: State) -> StepAnswer:
            times.append(state.time_s)
            return ANSWER

    now_s = [100.0]
    waits = iter([0.0, 2.5, 0.0, 0.25, 0.0])

    def sleep(duration_s: float) -> None:
        now_s[0] += duration_s

    def wait_for_a_packet() -> Measurement:
        now_s[0] += next(waits)
        measured_at_s = now_s[0] - 0.125 if now_s[0] > 104.0 else None
        return Measurement(np.zeros(7), measured_at_s=measured_at_s)

    loop = importlib.import_module("revprio.drive")
    monkeypatch.setattr(loop, "time", SimpleNamespace(monotonic=lambda: now_s[0], sleep=sleep))
    monkeypatch.setattr(loop, "ThreadPoolExecutor", AtOnce)
    config = CONFIG.model_copy(update={"period_s": 1.0})
    drive(Listening(config), wait_for_a_packet, write, watchdog=Watchdog(np.full(7, 8.0)), duration_s=6)
    # The second read waits from 1 s to 3.5 s; the third period begins late, at once.
    # From 4 s on, the program states the time.
    assert times == [0.0, 3.5, 3.5, 4.125, 4.875]
