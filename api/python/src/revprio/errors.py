"""What can go wrong, each with what to do about it."""

from __future__ import annotations

from revprio.models import REMEDIES, Problem, Simulation

__all__ = [
    "ConflictError", "ForeignAnswerError", "InvalidError", "LateAnswerError", "NoAnswerError", "NotFoundError",
    "ProblemError", "RevprioError", "SimulationError", "UnauthorizedError", "UnavailableError",
]  # fmt: skip


class RevprioError(Exception):
    """Anything that this package raises about the service."""

    is_silence: bool = False
    """Whether a later call may succeed: the service cannot be reached, is late, or has no time."""


class NoAnswerError(RevprioError):
    """The service cannot be reached, or the connection broke."""

    is_silence = True

    def __init__(self, url: str, cause: object) -> None:
        """`url`: who was asked; `cause`: what happened."""
        super().__init__(f"no answer from {url}: {cause}; is the service running there?")
        self.url = url


class LateAnswerError(NoAnswerError):
    """The service did not answer in time."""


class ForeignAnswerError(RevprioError):
    """Something answered, but not as a revprio service of this version does."""

    def __init__(self, url: str, status: int, cause: object) -> None:
        """`status`: HTTP status of the answer."""
        super().__init__(f"{url} answered with status {status}, but not as a revprio service does: {cause}")
        self.url, self.status = url, status
        self.is_silence = status >= 500  # noqa: PLR2004


class SimulationError(RevprioError):
    """An experiment failed or was cancelled."""

    def __init__(self, simulation: Simulation) -> None:
        """`simulation`: what the service says of it."""
        super().__init__(f"simulation {simulation.id} {simulation.state}: {simulation.error or 'see who deleted it'}")
        self.simulation = simulation


class ProblemError(RevprioError):
    """The service refused a request and says why (RFC 9457, `application/problem+json`)."""

    def __init__(self, problem: Problem, retry_after_s: float | None = None) -> None:
        """`retry_after_s`: what the header `Retry-After` asks for, s."""
        self.problem = problem
        self.type = problem.type
        """Stable identifier of the kind of problem."""
        self.status = problem.status
        """HTTP status."""
        self.detail = problem.detail
        """What is wrong, in words."""
        self.pointer = problem.pointer
        """JSON pointer of the offending field, if there is one."""
        self.remedy = REMEDIES.get(problem.type, problem.title)
        """What to do about it."""
        self.retry_after_s = retry_after_s
        place = f" at {problem.pointer}" if problem.pointer else ""
        super().__init__(f"{problem.detail} ({problem.status} {problem.type}{place}). {self.remedy}")
        self.is_silence = problem.status in (408, 429) or problem.status >= 500  # noqa: PLR2004


class InvalidError(ProblemError):
    """400, 413, 415, 422: the request is malformed, too large or wrong; `pointer` says where."""


class UnauthorizedError(ProblemError):
    """401, 403: no token, another one, or what no token allows."""


class NotFoundError(ProblemError):
    """404: no such robot, controller, scenario or simulation; a session that ended is one."""


class ConflictError(ProblemError):
    """409: a sequence number that does not grow, a name that is taken, a trace that is not there yet."""


class UnavailableError(ProblemError):
    """429, 503: overloaded, full or about to end; `retry_after_s` says when to try again."""


_KINDS: dict[int, type[ProblemError]] = {
    **dict.fromkeys((400, 413, 415, 422), InvalidError),
    **dict.fromkeys((401, 403), UnauthorizedError),
    404: NotFoundError,
    409: ConflictError,
    **dict.fromkeys((429, 503), UnavailableError),
}


def problem_error(problem: Problem, retry_after_s: float | None = None) -> ProblemError:
    """The exception of a problem."""
    return _KINDS.get(problem.status, ProblemError)(problem, retry_after_s)
