"""Timing of a control loop: statistics, and a warning while the loop cannot keep its period."""

from __future__ import annotations

import math
from dataclasses import dataclass

WINDOW_S = 1.0
"""Least time over which a loop is judged, s."""
WINDOW_PERIODS = 50
"""Least number of periods over which a loop is judged: a single late answer of a slow loop is no reason to warn."""
ALLOWED_SHARE = 0.05
"""Share of the periods that may be without an answer."""


class SlowLoopWarning(RuntimeWarning):
    """A control loop cannot keep its period."""


@dataclass
class Drive:
    """Statistics of a control loop."""

    periods: int = 0
    """Number of control periods in which the loop ran: each had a command."""
    answered: int = 0
    """Number of periods in which the answer to the period's own state came before its end."""
    steps: int = 0
    """Number of answered states, in time or late. While an answer is late, no other state is sent."""
    skipped: int = 0
    """Number of periods that passed while the loop was busy with an earlier one. They had no state and no command."""
    achieved_period_s: float = math.inf
    """Mean time between two answered states, s; infinite before the second one."""
    longest_period_s: float = 0.0
    """Longest time between two answered states, s; 0 before the second one."""


class Pace:
    """Updates the statistics of a loop. All times are arguments, in seconds of a monotonic clock."""

    def __init__(self, period_s: float, start_s: float) -> None:
        """`period_s`: control period T, s; `start_s`: start of the loop."""
        self.report = Drive()
        self._period_s = period_s
        self._number = -1
        self._window = Window(0, start_s)
        self._first_s = self._last_s = start_s

    def begin(self, number: int, now_s: float) -> str | None:
        """Starts a period, counted from 0; returns a warning if the loop was too slow in the window that ends here."""
        skipped = number - self._number - 1
        self._number = number
        self.report.skipped += skipped
        self._window.skipped += skipped
        if now_s - self._window.start_s < max(WINDOW_S, WINDOW_PERIODS * self._period_s):
            return None
        finished, self._window = self._window, Window(number, now_s)
        return finished.warning(number, now_s)

    def answer(self, measured_at_s: float, now_s: float, *, in_time: bool) -> None:
        """Counts the answer that came at `now_s` to a state; `in_time`: within the period of the state."""
        self._window.answers += 1
        self._window.waited_s += now_s - measured_at_s
        report = self.report
        report.answered += in_time
        report.steps += 1
        if report.steps == 1:
            self._first_s = measured_at_s
        else:
            report.achieved_period_s = (measured_at_s - self._first_s) / (report.steps - 1)
            report.longest_period_s = max(report.longest_period_s, measured_at_s - self._last_s)
        self._last_s = measured_at_s


@dataclass
class Window:
    """The periods of the last second or so."""

    first: int
    start_s: float
    answers: int = 0
    waited_s: float = 0.0
    skipped: int = 0

    def warning(self, end: int, now_s: float) -> str | None:
        """Returns a warning with figures and remedy if too many periods before period `end` were without an answer."""
        periods = end - self.first
        missing = periods - self.answers
        if missing <= ALLOWED_SHARE * periods:
            return None
        waits = f"answers took {1e3 * self.waited_s / self.answers:.1f} ms" if self.answers else "no valid answer came"
        if 2 * self.skipped > missing:
            remedy = (
                "The loop itself is late: make `read` and `write` faster, free the machine, or use a longer period."
            )
        else:
            remedy = "Use a longer period, a stream, or `revprio.Controller` in the process, which is the fastest."
        return (
            f"The loop reached {self.answers} of {periods} periods in the last {now_s - self.start_s:.1f} s; {waits}. "
            + remedy
        )
