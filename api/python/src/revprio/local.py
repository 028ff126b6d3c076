"""The service in this process, without a server."""

from __future__ import annotations

import math
from types import TracebackType
from typing import Self, TypeVar

from revprio import native, routes
from revprio.calls import Calls
from revprio.controller import Controller
from revprio.models import ControllerConfig, ResolveAnswer, ResolveRequest
from revprio.typed import fields_of

A = TypeVar("A")


class Local(Calls):
    """The service in this process: the methods of `Client` that need no server.

    `revprio.connect()` returns it, and the functions of the package are its methods. All objects share the robots that
    the process registers. Simulations, scenarios and streams need a server: `revprio.serve`.
    """

    step_timeout_s = math.inf

    def call(self, call: routes.Call[A], timeout_s: float | None = None) -> A:  # noqa: ARG002 - nothing waits here
        """Makes a call of `revprio.routes` and returns its answer."""
        body = b"" if call.body is None else call.body.json_bytes()
        return call.route.parse(native.call(call.route.method, call.path, body))

    @fields_of(ResolveRequest)
    def resolve(self, request: ResolveRequest) -> ResolveAnswer:
        """Computes joint velocities for tasks: `revprio.resolve(robot=…, joint_position=…, tasks=[…])`.

        In the answer, `joint_velocity` has n numbers, rad/s or m/s; `tasks` has the result of each task, highest
        priority first.
        """
        return native.resolve(request.json_bytes())

    @fields_of(ControllerConfig)
    def session(self, config: ControllerConfig) -> Controller:
        """Starts a controller: `revprio.session(robot=…, period_s=…, tasks=[…])`, the same as `revprio.Controller`."""
        return Controller(**{name: getattr(config, name) for name in config.model_fields_set})

    Controller = session

    def close(self) -> None:
        """Does nothing."""

    def __enter__(self) -> Self:
        """Returns this object."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Does nothing."""
