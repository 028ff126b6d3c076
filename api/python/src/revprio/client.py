"""The blocking HTTP client."""

from __future__ import annotations

import os
import ssl
import time
from contextlib import AbstractContextManager
from types import TracebackType
from typing import Self, TypeVar

import httpx
from websockets.sync.client import ClientConnection, connect

from revprio import routes
from revprio.calls import Calls
from revprio.errors import RevprioError
from revprio.models import (
    ControllerConfig,
    Scenario,
    ScenarioEntry,
    SessionEntry,
    SimulationRequest,
)
from revprio.remote import Session
from revprio.retry import RetryBudget, no_answer
from revprio.simulations import SimulationRun
from revprio.streaming import SUBPROTOCOL, websocket_url
from revprio.typed import fields_of
from revprio.url import service_url

A = TypeVar("A")


class Client(Calls):
    """A client of one service. It keeps its connections open between calls: use it in a `with` block, or call `close`.

    Every method raises a `RevprioError` if no answer comes or the service refuses the request; see `revprio.errors`.

    Several threads may use one client. After `os.fork`, a client opens new connections in the child.
    """

    def __init__(  # noqa: PLR0913
        self,
        url: str = "http://127.0.0.1:8080",
        *,
        token: str | None = None,
        timeout_s: float = 10.0,
        step_timeout_s: float = 1.0,
        retries: int = 2,
        tls: ssl.SSLContext | None = None,
        owner: str | None = None,
    ) -> None:
        """Creates the client; nothing is sent before the first call.

        `url`: base address of the service; `http://` may be left out.
        `token`: the content of the service's `--token-file`.
        `timeout_s`: time limit of a call including its retries, s; `step_timeout_s`: the same for a control period.
        `retries`: maximum number of retries of a call. Only calls that are safe to repeat are retried.
        `tls`: TLS settings for `https://` with a certificate that the system does not trust.
        `owner`: owner token of the sessions that this client opens; default: a random one. Other clients cannot step
        these sessions. Clients with the same token can.
        """
        self.url = service_url(url)
        self.step_timeout_s = step_timeout_s
        self._timeout_s, self._retries, self._tls = timeout_s, retries, tls
        self._headers = routes.request_headers(token, owner)
        self._http = httpx.Client(base_url=self.url, headers=self._headers, verify=tls or True)
        self._process = os.getpid()

    def call(self, call: routes.Call[A], timeout_s: float | None = None) -> A:
        """Sends a call of `revprio.routes`, retries it where that is safe, and returns its answer."""
        budget = RetryBudget(
            repeatable=call.route.repeatable, retries=self._retries, timeout_s=timeout_s or self._timeout_s
        )
        while True:
            try:
                return call.route.read(self._send(call.request(self._connections(), budget.remaining_s())))
            except RevprioError as failure:
                time.sleep(budget.pause_s(failure))

    def _connections(self) -> httpx.Client:
        """Returns connections of this process: after a fork, parent and child would read each other's answers."""
        if os.getpid() != self._process:
            self._http = httpx.Client(base_url=self.url, headers=self._headers, verify=self._tls or True)
            self._process = os.getpid()
        return self._http

    def _send(self, request: httpx.Request) -> httpx.Response:
        try:
            return self._http.send(request)
        except httpx.TransportError as error:
            raise no_answer(self.url, error) from error

    def connect(self, path: str) -> AbstractContextManager[ClientConnection]:
        """Returns a context manager that opens a WebSocket to a path of the service."""
        return connect(
            websocket_url(self.url, path),
            additional_headers=self._headers,
            subprotocols=[SUBPROTOCOL],
            ssl=self._tls,
            open_timeout=self._timeout_s,
            proxy=None,
        )

    @fields_of(ControllerConfig)
    def session(self, config: ControllerConfig) -> Session:
        """Opens a controller whose memory the service keeps: `client.session(robot=…, period_s=…, tasks=[…])`."""
        return Session(self, config)

    Controller = session  # as `revprio.Controller`

    def sessions(self) -> list[SessionEntry]:
        """Lists the open sessions of all clients."""
        return self.call(routes.LIST_CONTROLLERS()).controllers

    def scenarios(self) -> list[ScenarioEntry]:
        """Lists the scenarios that ship with the service."""
        return self.call(routes.SCENARIOS()).scenarios

    def scenario(self, name: str) -> Scenario:
        """Returns the scenario of this name."""
        return self.call(routes.SCENARIO(name))

    @fields_of(SimulationRequest)
    def simulate(self, request: SimulationRequest) -> SimulationRun:
        """Starts a simulation of a scenario, by name or your own.

        `result()` waits for its end; `trace()` returns every control period.
        """
        return SimulationRun(self, self.call(routes.CREATE_SIMULATION(body=request)).id)

    def is_ready(self) -> bool:
        """Returns whether the service can be reached and accepts requests."""
        try:
            return self._send(self._connections().build_request("GET", "/readyz")).is_success
        except RevprioError:
            return False

    def close(self) -> None:
        """Closes the connections."""
        self._http.close()

    def __enter__(self) -> Self:
        """Returns this object."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Closes the connections."""
        self.close()
