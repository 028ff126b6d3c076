"""Exceptions of the client."""

from __future__ import annotations

from typing import Any

from revprio.problem import REMEDIES, Problem

__all__ = [
    "AddressError", "ConflictError", "ForeignAnswerError", "InvalidError", "LateAnswerError", "NoAnswerError",
    "NotFoundError", "ProblemError", "RevprioError", "UnauthorizedError", "UnavailableError",
]  # fmt: skip


class RevprioError(Exception):
    """Base class of all errors that concern the service."""

    is_silence: bool = False
    """Whether a later call may succeed: the service cannot be reached, is late, or is overloaded."""

    def __reduce__(self) -> tuple[Any, ...]:
        """Copies and pickles the error, whatever its class takes to create it: other processes return errors so."""
        return _restored, (type(self), self.args, vars(self))


def _restored(kind: type[RevprioError], args: tuple[object, ...], fields: dict[str, object]) -> RevprioError:
    """Returns an error with these arguments of the exception and these fields."""
    error = kind.__new__(kind, *args)
    vars(error).update(fields)
    return error


class NoAnswerError(RevprioError):
    """The service cannot be reached, or the connection was lost."""

    is_silence = True

    def __init__(self, url: str, cause: object) -> None:
        """`url`: address of the service; `cause`: reason of the failure."""
        super().__init__(f"no answer from {url}: {cause}; is the service running there?")
        self.url = url


class LateAnswerError(NoAnswerError):
    """The service did not answer in time."""


class ForeignAnswerError(RevprioError):
    """The answer is not one of a revprio service of this version."""

    def __init__(self, url: str, status: int, cause: object) -> None:
        """`url`: address that answered; `status`: HTTP status of the answer; `cause`: why it cannot be read."""
        super().__init__(f"the answer of {url} (status {status}) is not from a revprio service: {cause}")
        self.url, self.status = url, status
        self.is_silence = status >= 500  # noqa: PLR2004


class AddressError(RevprioError, ValueError):
    """The address of a service is not an address of HTTP."""

    def __init__(self, url: str) -> None:
        """`url`: the wrong address."""
        super().__init__(f"`{url}` is not the address of a service; give one such as http://127.0.0.1:8080")
        self.url = url


class ProblemError(RevprioError):
    """The service refused a request; the fields give the reason (RFC 9457, `application/problem+json`)."""

    def __init__(self, problem: Problem, retry_after_s: float | None = None) -> None:
        """`retry_after_s`: value of the header `Retry-After`, s."""
        self.problem = problem
        self.type = problem.type
        """Stable identifier of the kind of problem."""
        self.status = problem.status
        """HTTP status."""
        self.detail = problem.detail
        """Description of the problem."""
        self.pointer = problem.pointer
        """JSON pointer of the invalid field, if there is one."""
        self.candidates = problem.candidates or []
        """Possible values of that field, best first, if the service can list them: links for `base` and `tip`."""
        self.remedy = REMEDIES.get(problem.type, problem.title)
        """What to do about the problem."""
        self.retry_after_s = retry_after_s
        place = f" at {problem.pointer}" if problem.pointer else ""
        super().__init__(f"{problem.detail} ({problem.status} {problem.type}{place}). {self.remedy}")
        self.is_silence = problem.status in (408, 429) or problem.status >= 500  # noqa: PLR2004


class InvalidError(ProblemError, ValueError):
    """400, 413, 415, 422: the request is malformed, too large or invalid; `pointer` names the field.

    The client raises it too, for a body that it can refuse itself.
    """


class UnauthorizedError(ProblemError):
    """401, 403: the token is missing or wrong, or the request is forbidden."""


class NotFoundError(ProblemError):
    """404: no such robot, controller, scenario or simulation; also a session that has ended."""


class ConflictError(ProblemError):
    """409: a sequence number does not increase, a name is already used, or a trace is not ready yet."""


class UnavailableError(ProblemError):
    """429, 503: the service is overloaded, full or shutting down; retry after `retry_after_s`."""


_ERROR_BY_STATUS: dict[int, type[ProblemError]] = {
    **dict.fromkeys((400, 413, 415, 422), InvalidError),
    **dict.fromkeys((401, 403), UnauthorizedError),
    404: NotFoundError,
    409: ConflictError,
    **dict.fromkeys((429, 503), UnavailableError),
}


def pointer_to(*parts: int | str) -> str:
    """Returns the JSON pointer to a field, in which `~` and `/` of a name are escaped (RFC 6901)."""
    return "".join("/" + str(part).replace("~", "~0").replace("/", "~1") for part in parts)


def problem_error(problem: Problem, retry_after_s: float | None = None) -> ProblemError:
    """Returns the exception class that matches the status of a problem."""
    return _ERROR_BY_STATUS.get(problem.status, ProblemError)(problem, retry_after_s)
