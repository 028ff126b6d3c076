"""The client for asyncio: `async with AsyncClient(url) as client: answer = await client.resolve(…)`.

Generated from the blocking client by `generate_aio.py`; do not edit.
"""

from __future__ import annotations
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractAsyncContextManager, AsyncExitStack, suppress
from revprio import routes
from revprio.async_drive import drive
from revprio.bodies import ArrayLike, JointVector
from revprio.controller import config_with
from revprio.errors import LateAnswerError, NoAnswerError, NotFoundError, RevprioError
from revprio.models import (
    BatchItem,
    BatchRequest,
    ChannelInput,
    ControllerConfig,
    CreatedController,
    KinematicsAnswer,
    KinematicsRequest,
    Memory,
    ObstacleState,
    PayloadAnswer,
    PayloadRequest,
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
    TareAnswer,
    TareRequest,
    Wrench,
)
from revprio.reported import log_warnings
from revprio.retry import RetryBudget, no_answer
from revprio.simulations import POLL_S, has_ended
from revprio.states import StateNumbering
from revprio.streaming import ReplyMatcher, SUBPROTOCOL, receive_async, refused_handshake, websocket_url
from revprio.typed import fields_of
from revprio.url import service_url
from types import TracebackType
from typing import Any, Self
from typing import TypeVar
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, InvalidHandshake
import asyncio
import httpx
import os
import ssl
import time

__all__ = [
    "AsyncClient",
    "AsyncController",
    "AsyncSession",
    "AsyncSimulationRun",
    "AsyncStateless",
    "AsyncStream",
    "drive",
]
A = TypeVar("A")


class AsyncClient:
    """The asyncio version of `Client`, with the same methods and arguments; use it with `async with`."""

    def __init__(
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
        self._timeout_s, self._retries, self._tls = (timeout_s, retries, tls)
        self._headers = routes.request_headers(token, owner)
        self._http = httpx.AsyncClient(base_url=self.url, headers=self._headers, verify=tls or True)
        self._process = os.getpid()

    async def call(self, call: routes.Call[A], timeout_s: float | None = None) -> A:
        """Sends a call of `revprio.routes`, retries it where that is safe, and returns its answer."""
        budget = RetryBudget(
            repeatable=call.route.repeatable, retries=self._retries, timeout_s=timeout_s or self._timeout_s
        )
        while True:
            try:
                return call.route.read(await self._send(call.request(self._connections(), budget.remaining_s())))
            except RevprioError as failure:
                await asyncio.sleep(budget.pause_s(failure))

    def _connections(self) -> httpx.AsyncClient:
        """Returns connections of this process: after a fork, parent and child would read each other's answers."""
        if os.getpid() != self._process:
            self._http = httpx.AsyncClient(base_url=self.url, headers=self._headers, verify=self._tls or True)
            self._process = os.getpid()
        return self._http

    async def _send(self, request: httpx.Request) -> httpx.Response:
        try:
            return await self._http.send(request)
        except httpx.TransportError as error:
            raise no_answer(self.url, error) from error

    def connect(self, path: str) -> AbstractAsyncContextManager[ClientConnection]:
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
    def session(self, config: ControllerConfig) -> AsyncSession:
        """Opens a controller whose memory the service keeps: `client.session(robot=…, period_s=…, tasks=[…])`."""
        return AsyncSession(self, config)

    Controller = session

    async def sessions(self) -> list[SessionEntry]:
        """Lists the open sessions of all clients."""
        return (await self.call(routes.LIST_CONTROLLERS())).controllers

    async def scenarios(self) -> list[ScenarioEntry]:
        """Lists the scenarios that ship with the service."""
        return (await self.call(routes.SCENARIOS())).scenarios

    async def scenario(self, name: str) -> Scenario:
        """Returns the scenario of this name."""
        return await self.call(routes.SCENARIO(name))

    @fields_of(SimulationRequest)
    async def simulate(self, request: SimulationRequest) -> AsyncSimulationRun:
        """Starts a simulation of a scenario, by name or your own.

        `result()` waits for its end; `trace()` returns every control period.
        """
        return AsyncSimulationRun(self, (await self.call(routes.CREATE_SIMULATION(body=request))).id)

    async def is_ready(self) -> bool:
        """Returns whether the service can be reached and accepts requests."""
        try:
            return (await self._send(self._connections().build_request("GET", "/readyz"))).is_success
        except RevprioError:
            return False

    async def close(self) -> None:
        """Closes the connections."""
        await self._http.aclose()

    async def __aenter__(self) -> Self:
        """Returns this object."""
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Closes the connections."""
        await self.close()

    step_timeout_s: float
    "Time limit of a control period, s."

    @fields_of(ResolveRequest)
    async def resolve(self, request: ResolveRequest) -> ResolveAnswer:
        """Computes joint velocities for tasks: `client.resolve(robot=…, joint_position=…, tasks=[…])`.

        In the answer, `joint_velocity` has n numbers, rad/s or m/s; `tasks` has the result of each task, highest
        priority first.
        """
        return await self.call(routes.RESOLVE(body=request))

    async def resolve_batch(self, items: Sequence[ResolveRequest]) -> list[BatchItem]:
        """Resolves many requests at once. Returns, in the same order, an answer or a `Problem` for each."""
        return (await self.call(routes.RESOLVE_BATCH(body=BatchRequest(items=list(items))))).items

    @fields_of(KinematicsRequest)
    async def kinematics(self, request: KinematicsRequest) -> KinematicsAnswer:
        """Returns tool pose (m), `jacobian` (6 × n, base axes, linear rows first), singular values and link frames."""
        return await self.call(routes.KINEMATICS(body=request))

    @fields_of(StabilityRequest)
    async def stability(self, request: StabilityRequest) -> StabilityAnswer:
        """Returns stability margins of one axis in contact: maximum lag (s) and delay (periods), minimum damping."""
        return await self.call(routes.STABILITY(body=request))

    @fields_of(PayloadRequest)
    async def payload(self, request: PayloadRequest) -> PayloadAnswer:
        """Identifies bias and payload of a wrist sensor from readings at rest in six postures or more.

        `bias` and `payload` of the answer fit into a `WrenchSensor`. Similar postures, a wrong sign and exchanged axes
        raise an `InvalidError` that says which posture to add, or what is exchanged.
        """
        return await self.call(routes.PAYLOAD(body=request))

    @fields_of(StepRequest)
    async def step(self, request: StepRequest) -> StepAnswer:
        """Runs one control period of a stateless controller; `stateless` keeps the memory between periods for you."""
        return await self.call(routes.STEP(body=request), self.step_timeout_s)

    @fields_of(ControllerConfig)
    def stateless(self, config: ControllerConfig) -> AsyncStateless:
        """Returns a controller that sends its memory with each request."""
        return AsyncStateless(self, config)

    async def robots(self) -> list[Robot]:
        """Lists the robots that requests can name, with limits and units of their joints."""
        return (await self.call(routes.ROBOTS())).robots

    async def robot(self, name: str) -> Robot:
        """Returns the robot of this name, with limits and units of its joints."""
        return await self.call(routes.ROBOT(name))

    @fields_of(RobotRegistration)
    async def register_robot(self, registration: RobotRegistration) -> Robot:
        """Registers a robot from the text of a URDF file. `tip` names the link of its tool."""
        return await self.call(routes.REGISTER_ROBOT(body=registration))

    async def delete_robot(self, name: str) -> None:
        """Deletes a registered robot."""
        await self.call(routes.DELETE_ROBOT(name))


class AsyncController(ABC):
    """The asyncio version of `Controller`, with the same methods and arguments; use it with `async with`."""

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
        obstacles: Sequence[ObstacleState] | None = None,
        wrenches: Mapping[str, Wrench | ArrayLike] | None = None,
        channels: Mapping[str, ChannelInput] | None = None,
    ) -> StepAnswer:
        """As `Controller.step`."""
        state = self._numbering.state(
            joint_position,
            joint_velocity,
            wrench,
            time_s,
            targets=targets,
            obstacles=obstacles,
            wrenches=wrenches,
            channels=channels,
        )
        return await self.step_state(state)

    @abstractmethod
    async def step_state(self, state: State) -> StepAnswer:
        """Runs one control period with a state that has its own sequence number. Sequence numbers must increase."""

    async def _replace(self, config: ControllerConfig) -> None:
        raise NotImplementedError

    async def open(self) -> None:
        """Starts the controller."""

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
        except Exception:
            if error is None:
                raise

    async def change(self, **fields: Any) -> None:
        """Changes fields of the controller while the arm moves: `controller.change(tasks=[…])`.

        Other fields stay. Tasks can be added, removed, reordered and changed; no joint exceeds its acceleration limit
        in the transition. Robot, period and drive cannot change.
        """
        config = config_with(self.config, fields)
        await self._replace(config)
        self.config = config


class AsyncSession(AsyncController):
    """The asyncio version of `Session`, with the same methods and arguments; use it with `async with`."""

    created: CreatedController
    "The answer of the service: session name, joint order, and warnings about unstable contacts."

    def __init__(self, client: AsyncClient, config: ControllerConfig) -> None:
        """`config`: the controller."""
        super().__init__(config)
        self._client = client

    async def open(self) -> None:
        """Opens the session."""
        self.created = await self._client.call(routes.CREATE_CONTROLLER(body=self.config))
        log_warnings(self.created.warnings)

    @property
    def joints(self) -> list[str]:
        """Names of the joints, in the order of all arrays."""
        return self.created.joints

    @property
    def warnings(self) -> list[str]:
        """What the controller may do wrong: unstable loops, numbers in wrong units, gains that are too high.

        The logger `revprio` prints them when the controller is created or changed.
        """
        return self.created.warnings

    @property
    def id(self) -> str:
        """Name of the session."""
        return self.created.id

    async def step_state(self, state: State) -> StepAnswer:
        """Runs one control period with a state that has its own sequence number. Sequence numbers must increase."""
        self._numbering.follow(state)
        return await self._client.call(routes.STEP_CONTROLLER(self.id, body=state), self._client.step_timeout_s)

    async def _replace(self, config: ControllerConfig) -> None:
        self.created = await self._client.call(routes.REPLACE_CONTROLLER(self.id, body=config))
        log_warnings(self.created.warnings)
        self.config = config

    async def status(self) -> SessionStatus:
        """Returns the configuration, the last sequence number and counters."""
        return await self._client.call(routes.SHOW_CONTROLLER(self.id))

    @fields_of(TareRequest)
    async def tare(self, request: TareRequest) -> TareAnswer:
        """Tares the wrench sensor: `session.tare(readings=[…])`, with 20 readings or more.

        The arm must rest and touch nothing. The stated payload counts, so the wrench stays right in every posture. The
        next state gets the bias, and `config` has it.
        """
        answer = await self._client.call(routes.TARE_CONTROLLER(self.id, body=request))
        tared = (await self.status()).controller
        sensors = {"wrench_sensor": tared.wrench_sensor, "wrench_sensors": tared.wrench_sensors}
        self.config = config_with(self.config, {name: value for name, value in sensors.items() if value})
        return answer

    def stream(self) -> AsyncStream:
        """Opens a WebSocket to the same controller, for loops that are too fast for single requests.

        Closing the stream keeps the session.
        """
        return AsyncStream(self._client, self)

    async def close(self) -> None:
        """Ends the session; does nothing if it has already ended."""
        with suppress(NotFoundError):
            await self._client.call(routes.DELETE_CONTROLLER(self.id))


class AsyncStateless(AsyncController):
    """The asyncio version of `Stateless`, with the same methods and arguments; use it with `async with`."""

    def __init__(self, client: AsyncClient, config: ControllerConfig) -> None:
        """Starts without memory."""
        super().__init__(config)
        self._client = client
        self.memory: Memory | None = None
        "The controller memory of the last answer, for the next request. It may be stored and set again."

    async def step_state(self, state: State) -> StepAnswer:
        """Runs one control period with a state that has its own sequence number. Sequence numbers must increase."""
        self._numbering.follow(state)
        request = StepRequest(controller=self.config, state=state, memory=self.memory)
        answer = await self._client.call(routes.STEP(body=request), self._client.step_timeout_s)
        self.memory = answer.memory
        return answer

    async def _replace(self, config: ControllerConfig) -> None:
        message = "a stateless controller cannot change while the arm moves; use `Client.session`"
        raise RevprioError(message)

    async def close(self) -> None:
        """Does nothing, because the service stores nothing."""


class AsyncStream(AsyncController):
    """The asyncio version of `Stream`, with the same methods and arguments; use it with `async with`."""

    def __init__(self, client: AsyncClient, session: AsyncSession) -> None:
        """`session`: the controller that the stream steps."""
        super().__init__(session.config, session._numbering)
        self._client, self._session = (client, session)
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
        """Runs one control period with a state that has its own sequence number. Sequence numbers must increase."""
        self._numbering.follow(state)
        limit_s = self._client.step_timeout_s
        end_s = time.monotonic() + limit_s
        try:
            await self._socket.send(self._replies.encode(state))
            while True:
                answer = self._replies.decode(await receive_async(self._socket, end_s))
                if answer is not None:
                    return answer
        except TimeoutError as error:
            raise LateAnswerError(self._client.url, f"no reply within {limit_s} s") from error
        except ConnectionClosed as error:
            raise NoAnswerError(self._client.url, error) from error

    async def change(self, **fields: Any) -> None:
        """Changes fields of the controller of the session, as `Session.change`, from what it has now."""
        await self._session.change(**fields)
        self.config = self._session.config

    async def close(self) -> None:
        """Closes the connection. The session stays open."""
        await self._exit.aclose()


class AsyncSimulationRun:
    """The asyncio version of `SimulationRun`, with the same methods and arguments; use it with `async with`."""

    def __init__(self, client: AsyncClient, simulation_id: str) -> None:
        """`simulation_id`: identifier of a run that was started."""
        self._client, self.id = (client, simulation_id)

    async def status(self) -> Simulation:
        """Returns state and progress (0 … 1); includes metrics once the simulation is finished."""
        return await self._client.call(routes.SIMULATION(self.id))

    async def result(self, on_progress: Callable[[Simulation], object] = lambda _: None) -> Simulation:
        """Waits for the end; raises `SimulationError` if the simulation failed or was cancelled."""
        while not has_ended((status := (await self.status()))):
            on_progress(status)
            await asyncio.sleep(POLL_S)
        return status

    @fields_of(SimulationControl)
    async def control(self, command: SimulationControl) -> Simulation:
        """Controls an interactive run: `run.control(paused=False, speed=0.5, external_force=[0, 20, 0])`."""
        return await self._client.call(routes.CONTROL_SIMULATION(self.id, body=command))

    async def cycle(self) -> StepRequest:
        """Returns the latest control period of an interactive run, as a request for `Client.step`."""
        return await self._client.call(routes.CYCLE(self.id))

    async def trace(self) -> routes.Trace:
        """Returns all control periods of a finished run: one array per column, as the service documents them."""
        return await self._client.call(routes.TRACE(self.id))

    async def cancel(self) -> None:
        """Cancels a running simulation; deletes a finished one."""
        await self._client.call(routes.DELETE_SIMULATION(self.id))
