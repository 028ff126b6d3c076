"""The routes of the service as data: how to build a request and how to read its answer. Performs no network access."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from typing import Any, Generic, TypeVar
from urllib.parse import quote
from uuid import uuid4

import httpx
import numpy as np
from numpy.typing import NDArray
from pydantic import TypeAdapter

from revprio.bodies import Body
from revprio.errors import ForeignAnswerError, problem_error
from revprio.models import (
    BatchAnswer,
    CreatedController,
    KinematicsAnswer,
    PayloadAnswer,
    Problem,
    ResolveAnswer,
    Robot,
    RobotList,
    Scenario,
    ScenarioList,
    SessionList,
    SessionStatus,
    Simulation,
    StabilityAnswer,
    StepAnswer,
    StepRequest,
    TareAnswer,
)

A = TypeVar("A")


class Route(Generic[A]):
    """An HTTP method, a path with a placeholder `{}` for each name, and the type of the answer."""

    accept = "application/json"

    def __init__(
        self, method: str, path: str, answer: type[A], *, repeatable: bool = True, keyed: bool = False
    ) -> None:
        """`repeatable`: whether a request may be sent again when it is unknown if the service received it.

        `keyed`: whether each call has an idempotency key, with which the service recognises a repeated request.
        """
        self.method, self.path, self.answer, self.repeatable, self.keyed = method, path, answer, repeatable, keyed
        self._adapter: TypeAdapter[A] = TypeAdapter(answer)

    def __call__(self, *names: str, body: Body | None = None) -> Call[A]:
        """Returns the call with these names in its path."""
        key = str(uuid4()) if self.keyed else None
        return Call(self, self.path.format(*(quote(name, safe="") for name in names)), body, key)

    def read(self, response: httpx.Response) -> A:
        """Returns the answer of a successful response; raises a `ProblemError` otherwise."""
        try:
            if response.is_success:
                return self.parse(response.content)
            problem = Problem.model_validate_json(response.content)
        except ValueError as error:  # includes pydantic.ValidationError
            cause = str(error).partition("\n")[0]
            raise ForeignAnswerError(str(response.url), response.status_code, cause) from error
        raise problem_error(problem, _seconds(response.headers.get("retry-after")))

    def parse(self, content: bytes) -> A:
        """Parses the body of a successful response."""
        return self._adapter.validate_json(content or b"null")


Trace = dict[str, NDArray[Any]]
"""Columns by name; each array has one entry per control period."""


class TraceRoute(Route[Trace]):
    """A route whose answer is a table in CSV."""

    accept = "text/csv"

    def parse(self, content: bytes) -> Trace:
        """Parses columns of numbers, with nan for empty fields, and columns of text."""
        header, *rows = csv.reader(content.decode().splitlines())
        return {name: _column(list(entries)) for name, entries in zip(header, zip(*rows, strict=True), strict=True)}


def _column(entries: list[str]) -> NDArray[Any]:
    try:
        return np.array([float(entry or "nan") for entry in entries])
    except ValueError:
        return np.array(entries)


def _seconds(header: str | None) -> float | None:
    return float(header) if header is not None and header.isdecimal() else None


@dataclass(frozen=True)
class Call(Generic[A]):
    """A request to one route."""

    route: Route[A]
    path: str
    body: Body | None
    key: str | None = None

    def request(self, http: httpx.Client | httpx.AsyncClient, timeout_s: float) -> httpx.Request:
        """Returns the HTTP request."""
        content = None if self.body is None else self.body.json_bytes()
        headers = {"accept": self.route.accept}
        if content is not None:
            headers["content-type"] = "application/json"
        if self.key is not None:
            headers["idempotency-key"] = self.key
        return http.build_request(self.route.method, self.path, content=content, headers=headers, timeout=timeout_s)


def request_headers(token: str | None, owner: str | None) -> dict[str, str]:
    """Returns the headers of all requests of a client; `owner`: owner token of its sessions, default: a random one."""
    headers = {"revprio-owner": owner or str(uuid4())}
    # The file of a token ends with a line break.
    token = (token or "").strip()
    if not token:
        return headers
    if not (token.isascii() and token.isprintable()):
        message = "the token has characters that cannot be sent; give the content of the file of `--token-file`"
        raise ValueError(message)
    return headers | {"authorization": f"Bearer {token}"}


RESOLVE = Route("POST", "/v1/resolve", ResolveAnswer)
RESOLVE_BATCH = Route("POST", "/v1/resolve/batch", BatchAnswer)
KINEMATICS = Route("POST", "/v1/kinematics", KinematicsAnswer)
STABILITY = Route("POST", "/v1/stability", StabilityAnswer)
PAYLOAD = Route("POST", "/v1/payload", PayloadAnswer)
STEP = Route("POST", "/v1/step", StepAnswer)

# Repeatable: the request has an idempotency key.
CREATE_CONTROLLER = Route("POST", "/v1/controllers", CreatedController, keyed=True)
LIST_CONTROLLERS = Route("GET", "/v1/controllers", SessionList)
SHOW_CONTROLLER = Route("GET", "/v1/controllers/{}", SessionStatus)
REPLACE_CONTROLLER = Route("PUT", "/v1/controllers/{}", CreatedController)
DELETE_CONTROLLER = Route("DELETE", "/v1/controllers/{}", type(None))
# Repeatable: the service does not run the same sequence number twice.
STEP_CONTROLLER = Route("POST", "/v1/controllers/{}/step", StepAnswer)
# Repeatable: the same readings give the same bias.
TARE_CONTROLLER = Route("POST", "/v1/controllers/{}/tare", TareAnswer)
STREAM_CONTROLLER = "/v1/controllers/{}/stream"

ROBOTS = Route("GET", "/v1/robots", RobotList)
ROBOT = Route("GET", "/v1/robots/{}", Robot)
REGISTER_ROBOT = Route("POST", "/v1/robots", Robot, repeatable=False)
DELETE_ROBOT = Route("DELETE", "/v1/robots/{}", type(None))

SCENARIOS = Route("GET", "/v1/scenarios", ScenarioList)
SCENARIO = Route("GET", "/v1/scenarios/{}", Scenario)

CREATE_SIMULATION = Route("POST", "/v1/simulations", Simulation, repeatable=False)
SIMULATION = Route("GET", "/v1/simulations/{}", Simulation)
# Not repeatable: the command can be to advance by a number of periods.
CONTROL_SIMULATION = Route("POST", "/v1/simulations/{}/control", Simulation, repeatable=False)
CYCLE = Route("GET", "/v1/simulations/{}/cycle", StepRequest)
DELETE_SIMULATION = Route("DELETE", "/v1/simulations/{}", type(None))
TRACE = TraceRoute("GET", "/v1/simulations/{}/trace", dict)
