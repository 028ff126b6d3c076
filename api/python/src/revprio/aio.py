"""The client for asyncio: `async with AsyncClient(url) as client: answer = await client.resolve(…)`."""

from __future__ import annotations

import asyncio
import math
import ssl
from abc import ABC, abstractmethod
from collections.abc import Awaitable, Callable, Mapping, Sequence
from contextlib import AbstractAsyncContextManager, AsyncExitStack, suppress
from types import TracebackType
from typing import Any, Self, TypeVar

import httpx
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, InvalidHandshake

from revprio import routes
from revprio.bodies import ArrayLike, FloatArray, JointVector
from revprio.controller import config_with, stateless_change
from revprio.drive import LoopState, Measurement, ramp_to_rest, ticks
from revprio.errors import LateAnswerError, NoAnswerError, NotFoundError, RevprioError
from revprio.models import (
    BatchItem,
    BatchRequest,
    ControllerConfig,
    KinematicsAnswer,
    KinematicsRequest,
    Memory,
    ResolveAnswer,
    ResolveRequest,
    Robot,
    RobotRegistration,
    Scenario,
    ScenarioEntry,
    SessionEntry,
    SessionStatus,
    Simulation,
    SimulationControl,
    SimulationRequest,
    StabilityAnswer,
    StabilityRequest,
    State,
    StepAnswer,
    StepRequest,
    StreamedTarget,
    Wrench,
)
from revprio.pace import Drive
from revprio.retry import RetryBudget, no_answer
from revprio.simulations import POLL_S, has_ended
from revprio.states import StateNumbering
from revprio.streaming import SUBPROTOCOL, ReplyMatcher, refused_handshake, websocket_url
from revprio.typed import fields_of
from revprio.url import service_url
from revprio.watchdog import Watchdog

A = TypeVar("A")


class AsyncClient:
    """The asyncio version of `Client`, with the same methods and arguments."""

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
        """As `Client`."""
        self.url = service_url(url)
        self.step_timeout_s = step_timeout_s
        self._timeout_s, self._retries, self._tls = timeout_s, retries, tls
        self._headers = routes.request_headers(token, owner)
        self._http = httpx.AsyncClient(base_url=self.url, headers=self._headers, verify=tls or True)

    async def call(self, call: routes.Call[A], timeout_s: float | None = None) -> A:
        """As `Client.call`."""
        budget = RetryBudget(
            repeatable=call.route.repeatable, retries=self._retries, timeout_s=timeout_s or self._timeout_s
        )
        while True:
            try:
                return call.route.read(await self._send(call.request(self._http, budget.remaining_s())))
            except RevprioError as failure:
                await asyncio.sleep(budget.pause_s(failure))

    async def _send(self, request: httpx.Request) -> httpx.Response:
        try:
            return await self._http.send(request)
        except httpx.TransportError as error:
            raise no_answer(self.url, error) from error

    def connect(self, path: str) -> AbstractAsyncContextManager[ClientConnection]:
        """As `Client.connect`."""
        return connect(
            websocket_url(self.url, path),
            additional_headers=self._headers,
            subprotocols=[SUBPROTOCOL],  # type: ignore[list-item]
            ssl=self._tls,
            open_timeout=self._timeout_s,
            proxy=None,
        )

    @fields_of(ResolveRequest)
    async def resolve(self, request: ResolveRequest) -> ResolveAnswer:
        """As `Client.resolve`."""
        return await self.call(routes.RESOLVE(body=request))

    async def resolve_batch(self, items: Sequence[ResolveRequest]) -> list[BatchItem]:
        """As `Client.resolve_batch`."""
        return (await self.call(routes.RESOLVE_BATCH(body=BatchRequest(items=list(items))))).items

    @fields_of(KinematicsRequest)
    async def kinematics(self, request: KinematicsRequest) -> KinematicsAnswer:
        """As `Client.kinematics`."""
        return await self.call(routes.KINEMATICS(body=request))

    @fields_of(StabilityRequest)
    async def stability(self, request: StabilityRequest) -> StabilityAnswer:
        """As `Client.stability`."""
        return await self.call(routes.STABILITY(body=request))

    @fields_of(StepRequest)
    async def step(self, request: StepRequest) -> StepAnswer:
        """As `Client.step`."""
        return await self.call(routes.STEP(body=request), self.step_timeout_s)

    @fields_of(ControllerConfig)
    def session(self, config: ControllerConfig) -> AsyncSession:
        """As `Client.session`; `async with` opens it."""
        return AsyncSession(self, config)

    Controller = session  # as `revprio.Controller`

    async def sessions(self) -> list[SessionEntry]:
        """As `Client.sessions`."""
        return (await self.call(routes.LIST_CONTROLLERS())).controllers

    @fields_of(ControllerConfig)
    def stateless(self, config: ControllerConfig) -> AsyncStateless:
        """As `Client.stateless`."""
        return AsyncStateless(self, config)

    async def robots(self) -> list[Robot]:
        """As `Client.robots`."""
        return (await self.call(routes.ROBOTS())).robots

    async def robot(self, name: str) -> Robot:
        """As `Client.robot`."""
        return await self.call(routes.ROBOT(name))

    @fields_of(RobotRegistration)
    async def register_robot(self, registration: RobotRegistration) -> Robot:
        """As `Client.register_robot`."""
        return await self.call(routes.REGISTER_ROBOT(body=registration))

    async def delete_robot(self, name: str) -> None:
        """As `Client.delete_robot`."""
        await self.call(routes.DELETE_ROBOT(name))

    async def scenarios(self) -> list[ScenarioEntry]:
        """As `Client.scenarios`."""
        return (await self.call(routes.SCENARIOS())).scenarios

    async def scenario(self, name: str) -> Scenario:
        """As `Client.scenario`."""
        return await self.call(routes.SCENARIO(name))

    @fields_of(SimulationRequest)
    async def simulate(self, request: SimulationRequest) -> AsyncSimulationRun:
        """As `Client.simulate`."""
        return AsyncSimulationRun(self, (await self.call(routes.CREATE_SIMULATION(body=request))).id)

    async def is_ready(self) -> bool:
        """As `Client.is_ready`."""
        try:
            return (await self._send(self._http.build_request("GET", "/readyz"))).is_success
        except RevprioError:
            return False

    async def close(self) -> None:
        """Closes the connection."""
        await self._http.aclose()

    async def __aenter__(self) -> Self:
        """Returns this object."""
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Closes the connection."""
        await self.close()


class AsyncController(ABC):
    """The asyncio version of `Controller`."""

    def __init__(self, config: ControllerConfig, numbering: StateNumbering | None = None) -> None:
        """`config`: the controller; `numbering`: gives each state its sequence number, default: from 0."""
        self.config = config
        self.period_s = config.period_s
        self._numbering = numbering or StateNumbering(config.period_s)

    async def step(
        self,
        joint_position: JointVector,
        *,
        joint_velocity: JointVector | None = None,
        wrench: Wrench | ArrayLike | None = None,
        time_s: float | None = None,
        targets: Mapping[str, StreamedTarget] | None = None,
    ) -> StepAnswer:
        """As `Controller.step`."""
        return await self.step_state(self._numbering.state(joint_position, joint_velocity, wrench, time_s, targets))

    @abstractmethod
    async def step_state(self, state: State) -> StepAnswer:
        """As `Controller.step_state`."""

    async def change(self, **fields: Any) -> None:  # noqa: ANN401 - the types are those of the fields
        """As `Controller.change`."""
        config = config_with(self.config, fields)
        await self._replace(config)
        self.config = config

    @abstractmethod
    async def _replace(self, config: ControllerConfig) -> None:
        pass

    @abstractmethod
    async def open(self) -> None:
        """Starts the controller; `async with` calls this."""

    @abstractmethod
    async def close(self) -> None:
        """Ends the controller."""

    async def __aenter__(self) -> Self:
        """Starts the controller."""
        await self.open()
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Ends the controller.

        An error of the block has precedence over an error of `close`. The service ends an idle session itself.
        """
        try:
            await self.close()
        except RevprioError:
            if error is None:
                raise


class AsyncSession(AsyncController):
    """The asyncio version of `Session`."""

    def __init__(self, client: AsyncClient, config: ControllerConfig) -> None:
        """Stores the configuration; `open` opens the session."""
        super().__init__(config)
        self._client = client
        self.id = ""

    async def open(self) -> None:
        """Opens the session."""
        self.created = await self._client.call(routes.CREATE_CONTROLLER(body=self.config))
        self.id = self.created.id

    async def step_state(self, state: State) -> StepAnswer:
        """As `Controller.step_state`."""
        return await self._client.call(routes.STEP_CONTROLLER(self.id, body=state), self._client.step_timeout_s)

    async def _replace(self, config: ControllerConfig) -> None:
        self.created = await self._client.call(routes.REPLACE_CONTROLLER(self.id, body=config))
        self.config = config

    async def status(self) -> SessionStatus:
        """As `Session.status`."""
        return await self._client.call(routes.SHOW_CONTROLLER(self.id))

    def stream(self) -> AsyncStream:
        """As `Session.stream`; `async with` connects it."""
        return AsyncStream(self._client, self)

    async def close(self) -> None:
        """As `Session.close`."""
        with suppress(NotFoundError):
            await self._client.call(routes.DELETE_CONTROLLER(self.id))


class AsyncStateless(AsyncController):
    """The asyncio version of `Stateless`."""

    def __init__(self, client: AsyncClient, config: ControllerConfig) -> None:
        """Starts without memory."""
        super().__init__(config)
        self._client = client
        self.memory: Memory | None = None

    async def step_state(self, state: State) -> StepAnswer:
        """As `Controller.step_state`."""
        request = StepRequest(controller=self.config, state=state, memory=self.memory)
        answer = await self._client.call(routes.STEP(body=request), self._client.step_timeout_s)
        self.memory = answer.memory
        return answer

    async def _replace(self, config: ControllerConfig) -> None:  # noqa: ARG002
        raise stateless_change()

    async def open(self) -> None:
        """Does nothing."""

    async def close(self) -> None:
        """Does nothing, because the service stores nothing."""


class AsyncStream(AsyncController):
    """The asyncio version of `Stream`."""

    def __init__(self, client: AsyncClient, session: AsyncSession) -> None:
        """Stores the session; `open` connects."""
        super().__init__(session.config, session._numbering)
        self._client, self._session = client, session
        self._replies = ReplyMatcher(client.url)
        self._exit = AsyncExitStack()

    async def open(self) -> None:
        """Opens the connection."""
        url = self._client.url
        try:
            socket = self._client.connect(routes.STREAM_CONTROLLER.format(self._session.id))
            self._socket = await self._exit.enter_async_context(socket)
        except InvalidHandshake as error:
            raise refused_handshake(url, error) from error
        except OSError as error:
            raise NoAnswerError(url, error) from error

    async def step_state(self, state: State) -> StepAnswer:
        """As `Controller.step_state`."""
        try:
            await self._socket.send(self._replies.encode(state))
            async with asyncio.timeout(self._client.step_timeout_s):
                while True:
                    answer = self._replies.decode(await self._socket.recv())
                    if answer is not None:
                        return answer
        except TimeoutError as error:
            raise LateAnswerError(self._client.url, f"no reply within {self._client.step_timeout_s} s") from error
        except ConnectionClosed as error:
            raise NoAnswerError(self._client.url, error) from error

    async def _replace(self, config: ControllerConfig) -> None:
        await self._session._replace(config)

    async def close(self) -> None:
        """Closes the connection. The session stays open."""
        await self._exit.aclose()


class AsyncSimulationRun:
    """The asyncio version of `SimulationRun`."""

    def __init__(self, client: AsyncClient, simulation_id: str) -> None:
        """`simulation_id`: identifier of a run that was started."""
        self._client, self.id = client, simulation_id

    async def status(self) -> Simulation:
        """As `SimulationRun.status`."""
        return await self._client.call(routes.SIMULATION(self.id))

    async def result(self, on_progress: Callable[[Simulation], object] = lambda _: None) -> Simulation:
        """As `SimulationRun.result`."""
        while not has_ended(status := await self.status()):
            on_progress(status)
            await asyncio.sleep(POLL_S)
        return status

    @fields_of(SimulationControl)
    async def control(self, command: SimulationControl) -> Simulation:
        """As `SimulationRun.control`."""
        return await self._client.call(routes.CONTROL_SIMULATION(self.id, body=command))

    async def cycle(self) -> StepRequest:
        """As `SimulationRun.cycle`."""
        return await self._client.call(routes.CYCLE(self.id))

    async def trace(self) -> routes.Trace:
        """As `SimulationRun.trace`."""
        return await self._client.call(routes.TRACE(self.id))

    async def cancel(self) -> None:
        """As `SimulationRun.cancel`."""
        await self._client.call(routes.DELETE_SIMULATION(self.id))


async def drive(
    controller: AsyncController,
    read: Callable[[], Awaitable[Measurement]],
    write: Callable[[FloatArray], None],
    *,
    watchdog: Watchdog,
    duration_s: float = math.inf,
) -> Drive:
    """As `revprio.drive`. The final ramp blocks the event loop until the arm is at rest."""
    state = LoopState(watchdog, controller.period_s)
    pending: asyncio.Task[StepAnswer] | None = None
    with ramp_to_rest(watchdog, write, controller.period_s):
        try:
            for tick in ticks(controller.period_s, duration_s):
                state.begin(tick)
                measurement = await read()
                if pending is None:
                    pending = asyncio.ensure_future(controller.step(**state.step_arguments(measurement, tick)))
                await asyncio.wait([pending], timeout=tick.remaining_s())
                if pending.done():
                    state.update(pending)
                    pending = None
                write(state.command())
                state.report.periods += 1
                await asyncio.sleep(tick.remaining_s())
        finally:
            if pending is not None:
                pending.cancel()
    return state.report
