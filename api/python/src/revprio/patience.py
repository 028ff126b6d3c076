"""When a call is sent again."""

from __future__ import annotations

import time

import httpx

from revprio.errors import LateAnswerError, NoAnswerError, RevprioError, UnavailableError

FIRST_PAUSE_S = 0.02
"""Before the first repetition where the service names no time; doubled each time."""


class Patience:
    """How often and how long one call is tried.

    Sent again is what the service has certainly not taken (no connection, 429 or 503), and after a broken connection
    what does no harm when it is taken twice. An answer that is late is not waited for a second time.
    """

    def __init__(self, *, repeatable: bool, retries: int, timeout_s: float) -> None:
        """`retries`: repetitions at most; `timeout_s`: for all attempts and pauses together, s."""
        self._repeatable, self._retries = repeatable, retries
        self._pause_s = FIRST_PAUSE_S
        self._end_s = time.monotonic() + timeout_s

    def left_s(self) -> float:
        """Time that is left, s."""
        return max(self._end_s - time.monotonic(), 1e-3)

    def pause_s(self, failure: RevprioError) -> float:
        """How long to wait before the next attempt, s; raises the failure if there shall be none."""
        pause_s = self._pause_s
        if isinstance(failure, UnavailableError) and failure.retry_after_s is not None:
            pause_s = failure.retry_after_s
        if self._retries == 0 or not self._may_repeat(failure) or pause_s >= self.left_s():
            raise failure
        self._retries -= 1
        self._pause_s *= 2
        return pause_s

    def _may_repeat(self, failure: RevprioError) -> bool:
        if isinstance(failure, UnavailableError) or isinstance(failure.__cause__, httpx.ConnectError):
            return True
        return self._repeatable and isinstance(failure, NoAnswerError) and not isinstance(failure, LateAnswerError)


def no_answer(url: str, error: httpx.TransportError) -> NoAnswerError:
    """The exception for a failure on the way."""
    kind = LateAnswerError if isinstance(error, httpx.TimeoutException) else NoAnswerError
    failure = kind(url, str(error) or type(error).__name__)
    failure.__cause__ = error
    return failure
