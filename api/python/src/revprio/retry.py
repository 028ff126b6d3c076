"""Rules for sending a call again."""

from __future__ import annotations

import time

import httpx

from revprio.errors import LateAnswerError, NoAnswerError, RevprioError, UnavailableError

FIRST_PAUSE_S = 0.02
"""Pause before the first retry if the answer has no `Retry-After`, s; doubled for each further retry."""


class RetryBudget:
    """Remaining retries and remaining time of one call.

    A call is sent again in two cases: the service did not process it (no connection, 429 or 503); or the connection
    was lost and the call may be processed twice without harm. A call that timed out is not sent again.
    """

    def __init__(self, *, repeatable: bool, retries: int, timeout_s: float) -> None:
        """`retries`: maximum number of retries; `timeout_s`: time limit of all attempts and pauses together, s."""
        self._repeatable, self._retries = repeatable, retries
        self._pause_s = FIRST_PAUSE_S
        self._end_s = time.monotonic() + timeout_s

    def remaining_s(self) -> float:
        """Returns the remaining time, s."""
        return max(self._end_s - time.monotonic(), 1e-3)

    def pause_s(self, failure: RevprioError) -> float:
        """Returns the pause before the next attempt, s; raises the failure if there is no further attempt."""
        pause_s = self._pause_s
        if isinstance(failure, UnavailableError) and failure.retry_after_s is not None:
            pause_s = failure.retry_after_s
        if self._retries == 0 or not self._may_repeat(failure) or pause_s >= self.remaining_s():
            raise failure
        self._retries -= 1
        self._pause_s *= 2
        return pause_s

    def _may_repeat(self, failure: RevprioError) -> bool:
        if isinstance(failure, UnavailableError) or isinstance(failure.__cause__, httpx.ConnectError):
            return True
        return self._repeatable and isinstance(failure, NoAnswerError) and not isinstance(failure, LateAnswerError)


def no_answer(url: str, error: httpx.TransportError) -> NoAnswerError:
    """Returns the exception for a transport failure."""
    kind = LateAnswerError if isinstance(error, httpx.TimeoutException) else NoAnswerError
    failure = kind(url, str(error) or type(error).__name__)
    failure.__cause__ = error
    return failure
