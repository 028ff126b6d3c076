"""The blocking client."""

from __future__ import annotations

import ssl
import time
from collections.abc import Sequence
from contextlib import AbstractContextManager
from types import TracebackType
from typing import Self, TypeVar

import httpx
from websockets.sync.client import ClientConnection, connect

from revprio import routes
from revprio.controller import Session, Stateless
from revprio.errors import RevprioError
from revprio.models import (
    BatchItem,
    BatchRequest,
    ControllerConfig,
    KinematicsAnswer,
    KinematicsRequest,
    ResolveAnswer,
    ResolveRequest,
    Robot,
    RobotRegistration,
    Scenario,
    ScenarioEntry,
    SessionEntry,
    SimulationRequest,
    StabilityAnswer,
    StabilityRequest,
    StepAnswer,
    StepRequest,
)
from revprio.patience import Patience, no_answer
from revprio.simulations import SimulationRun
from revprio.streaming import SUBPROTOCOL, websocket_url
from revprio.typed import fields_of

A = TypeVar("A")


class Client:
    """A client of one service; keeps its connection open between calls. Use it in a `with` block, or `close` it.

    Every method raises a `RevprioError` where there is no answer or the service refuses; see `revprio.errors`.
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
    ) -> None:
        """`url`: base address of the service; nothing is sent before the first call.

        `token`: what the service was given as `--token-file`.
        `timeout_s`: longest time for a call with its repetitions, s; `step_timeout_s`: the same for a control period.
        `retries`: repetitions of a call at most, only where they cannot do harm.
        `tls`: for `https://` with a certificate that the system does not know.
        """
        self.url = url.rstrip("/")
        self.step_timeout_s = step_timeout_s
        self._timeout_s, self._retries, self._tls = timeout_s, retries, tls
        self._headers = {"authorization": f"Bearer {token}"} if token else {}
        self._http = httpx.Client(base_url=self.url, headers=self._headers, verify=tls or True)

    def call(self, call: routes.Call[A], timeout_s: float | None = None) -> A:
        """Sends a call of `revprio.routes`, again where that is safe, and reads its answer."""
        patience = Patience(
            repeatable=call.route.repeatable, retries=self._retries, timeout_s=timeout_s or self._timeout_s
        )
        while True:
            try:
                return call.route.read(self._send(call.request(self._http, patience.left_s())))
            except RevprioError as failure:
                time.sleep(patience.pause_s(failure))

    def _send(self, request: httpx.Request) -> httpx.Response:
        try:
            return self._http.send(request)
        except httpx.TransportError as error:
            raise no_answer(self.url, error) from error

    def connect(self, path: str) -> AbstractContextManager[ClientConnection]:
        """A WebSocket to a path of the service, for a `with` block."""
        return connect(
            websocket_url(self.url, path),
            additional_headers=self._headers,
            subprotocols=[SUBPROTOCOL],  # type: ignore[list-item]
            ssl=self._tls,
            open_timeout=self._timeout_s,
            proxy=None,
        )

    @fields_of(ResolveRequest)
    def resolve(self, request: ResolveRequest) -> ResolveAnswer:
        """Joint velocities for tasks at a posture: `client.resolve(robot=…, joint_position=…, tasks=[…])`.

        The answer's `joint_velocity`: n, rad/s or m/s; `tasks`: what became of each, highest priority first.
        """
        return self.call(routes.RESOLVE(body=request))

    def resolve_batch(self, items: Sequence[ResolveRequest]) -> list[BatchItem]:
        """Many questions at once: for each an answer or, where it is refused, a `Problem`, in the same order."""
        return self.call(routes.RESOLVE_BATCH(body=BatchRequest(items=list(items)))).items

    @fields_of(KinematicsRequest)
    def kinematics(self, request: KinematicsRequest) -> KinematicsAnswer:
        """Tool pose (m), `jacobian` (6 × n, base axes, linear rows first), singular values and link frames."""
        return self.call(routes.KINEMATICS(body=request))

    @fields_of(StabilityRequest)
    def stability(self, request: StabilityRequest) -> StabilityAnswer:
        """How much lag (s) and delay (periods) one axis in contact bears, and how little damping it needs."""
        return self.call(routes.STABILITY(body=request))

    @fields_of(StepRequest)
    def step(self, request: StepRequest) -> StepAnswer:
        """One stateless control period; `stateless` keeps the memory for you."""
        return self.call(routes.STEP(body=request), self.step_timeout_s)

    @fields_of(ControllerConfig)
    def session(self, config: ControllerConfig) -> Session:
        """Opens a controller whose memory the service keeps: `client.session(robot=…, period_s=…, tasks=[…])`."""
        return Session(self, config)

    def sessions(self) -> list[SessionEntry]:
        """The sessions of all clients that are open now."""
        return self.call(routes.LIST_CONTROLLERS()).controllers

    @fields_of(ControllerConfig)
    def stateless(self, config: ControllerConfig) -> Stateless:
        """A controller whose memory travels with each request."""
        return Stateless(self, config)

    def robots(self) -> list[Robot]:
        """The arms that requests can name, with limits and units of their joints."""
        return self.call(routes.ROBOTS()).robots

    def robot(self, name: str) -> Robot:
        """One of them."""
        return self.call(routes.ROBOT(name))

    @fields_of(RobotRegistration)
    def register_robot(self, registration: RobotRegistration) -> Robot:
        """Makes an arm known from the text of a URDF file, under a name, with `tip` the link of its tool."""
        return self.call(routes.REGISTER_ROBOT(body=registration))

    def delete_robot(self, name: str) -> None:
        """Forgets a registered arm."""
        self.call(routes.DELETE_ROBOT(name))

    def scenarios(self) -> list[ScenarioEntry]:
        """The experiments that ship with the service."""
        return self.call(routes.SCENARIOS()).scenarios

    def scenario(self, name: str) -> Scenario:
        """One of them."""
        return self.call(routes.SCENARIO(name))

    @fields_of(SimulationRequest)
    def simulate(self, request: SimulationRequest) -> SimulationRun:
        """Starts an experiment, by name or of your own; `result()` waits for its end, `trace()` has every period."""
        return SimulationRun(self, request)

    def is_ready(self) -> bool:
        """Whether the service can be reached and takes work."""
        try:
            return self._send(self._http.build_request("GET", "/readyz")).is_success
        except RevprioError:
            return False

    def close(self) -> None:
        """Closes the connection."""
        self._http.close()

    def __enter__(self) -> Self:
        """Itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Closes the connection."""
        self.close()
