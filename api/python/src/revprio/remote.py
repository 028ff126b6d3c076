"""Controllers that a service computes: sessions, streams and stateless controllers."""

from __future__ import annotations

import time
from abc import abstractmethod
from collections.abc import Mapping, Sequence
from contextlib import ExitStack, suppress
from types import TracebackType
from typing import Any, Self

from websockets.exceptions import ConnectionClosed, InvalidHandshake

from revprio import routes
from revprio.bodies import ArrayLike, JointVector
from revprio.controller import Controller, config_with
from revprio.errors import LateAnswerError, NoAnswerError, NotFoundError, RevprioError
from revprio.models import (
    ChannelInput,
    ControllerConfig,
    CreatedController,
    Memory,
    ObstacleState,
    SessionStatus,
    State,
    StepAnswer,
    StepRequest,
    StreamedTarget,
    TareAnswer,
    TareRequest,
    Wrench,
)
from revprio.reported import log_warnings
from revprio.states import StateNumbering
from revprio.streaming import ReplyMatcher, receive, refused_handshake
from revprio.transport import Caller, Connector
from revprio.typed import fields_of


class RemoteController(Controller):
    """A controller that a service computes."""

    def __init__(self, config: ControllerConfig, numbering: StateNumbering | None = None) -> None:
        """`config`: the controller; `numbering`: gives each state its sequence number, default: from 0."""
        self.config = config
        self.period_s = config.period_s
        self._numbering = numbering or StateNumbering(config.period_s)

    def step(  # noqa: PLR0913 - the parts of a state, by name
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
        return self.step_state(state)

    @abstractmethod
    def step_state(self, state: State) -> StepAnswer:
        """Runs one control period with a state that has its own sequence number. Sequence numbers must increase."""

    def _replace(self, config: ControllerConfig) -> None:
        raise NotImplementedError

    def _open(self) -> None:
        """Starts the controller."""

    def close(self) -> None:
        """Ends the controller."""

    def __enter__(self) -> Self:
        """Returns this object."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Ends the controller.

        An error of the block has precedence over an error of `close`. The service ends an idle session itself.
        """
        try:
            self.close()
        except Exception:
            if error is None:
                raise


class Session(RemoteController):
    """A controller whose memory the service keeps."""

    created: CreatedController
    """The answer of the service: session name, joint order, and warnings about unstable contacts."""

    def __init__(self, client: Connector, config: ControllerConfig) -> None:
        """`config`: the controller."""
        super().__init__(config)
        self._client = client
        self._open()

    def _open(self) -> None:
        """Opens the session."""
        self.created = self._client.call(routes.CREATE_CONTROLLER(body=self.config))
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

    def step_state(self, state: State) -> StepAnswer:
        """Runs one control period with a state that has its own sequence number. Sequence numbers must increase."""
        self._numbering.follow(state)
        return self._client.call(routes.STEP_CONTROLLER(self.id, body=state), self._client.step_timeout_s)

    def _replace(self, config: ControllerConfig) -> None:
        self.created = self._client.call(routes.REPLACE_CONTROLLER(self.id, body=config))
        log_warnings(self.created.warnings)
        self.config = config

    def status(self) -> SessionStatus:
        """Returns the configuration, the last sequence number and counters."""
        return self._client.call(routes.SHOW_CONTROLLER(self.id))

    @fields_of(TareRequest)
    def tare(self, request: TareRequest) -> TareAnswer:
        """Tares the wrench sensor: `session.tare(readings=[…])`, with 20 readings or more.

        The arm must rest and touch nothing. The stated payload counts, so the wrench stays right in every posture. The
        next state gets the bias, and `config` has it.
        """
        answer = self._client.call(routes.TARE_CONTROLLER(self.id, body=request))
        tared = self.status().controller
        sensors = {"wrench_sensor": tared.wrench_sensor, "wrench_sensors": tared.wrench_sensors}
        self.config = config_with(self.config, {name: value for name, value in sensors.items() if value})
        return answer

    def stream(self) -> Stream:
        """Opens a WebSocket to the same controller, for loops that are too fast for single requests.

        Closing the stream keeps the session.
        """
        return Stream(self._client, self)

    def close(self) -> None:
        """Ends the session; does nothing if it has already ended."""
        with suppress(NotFoundError):
            self._client.call(routes.DELETE_CONTROLLER(self.id))


class Stateless(RemoteController):
    """A controller that sends its memory with each request, so that any replica of the service can answer it."""

    def __init__(self, client: Caller, config: ControllerConfig) -> None:
        """Starts without memory."""
        super().__init__(config)
        self._client = client
        self.memory: Memory | None = None
        """The controller memory of the last answer, for the next request. It may be stored and set again."""

    def step_state(self, state: State) -> StepAnswer:
        """Runs one control period with a state that has its own sequence number. Sequence numbers must increase."""
        self._numbering.follow(state)
        request = StepRequest(controller=self.config, state=state, memory=self.memory)
        answer = self._client.call(routes.STEP(body=request), self._client.step_timeout_s)
        self.memory = answer.memory
        return answer

    def _replace(self, config: ControllerConfig) -> None:  # noqa: ARG002
        message = "a stateless controller cannot change while the arm moves; use `Client.session`"
        raise RevprioError(message)

    def close(self) -> None:
        """Does nothing, because the service stores nothing."""


class Stream(RemoteController):
    """A session over a WebSocket."""

    def __init__(self, client: Connector, session: Session) -> None:
        """`session`: the controller that the stream steps."""
        super().__init__(session.config, session._numbering)
        self._client, self._session = client, session
        self._replies = ReplyMatcher(client.url)
        self._exit = ExitStack()
        self._open()

    def _open(self) -> None:
        """Opens the connection."""
        url = self._client.url
        try:
            socket = self._client.connect(routes.STREAM_CONTROLLER.format(self._session.id))
            self._socket = self._exit.enter_context(socket)
        except InvalidHandshake as error:
            raise refused_handshake(url, error) from error
        except OSError as error:
            raise NoAnswerError(url, error) from error

    def step_state(self, state: State) -> StepAnswer:
        """Runs one control period with a state that has its own sequence number. Sequence numbers must increase."""
        self._numbering.follow(state)
        limit_s = self._client.step_timeout_s
        end_s = time.monotonic() + limit_s
        try:
            self._socket.send(self._replies.encode(state))
            while True:
                answer = self._replies.decode(receive(self._socket, end_s))
                if answer is not None:
                    return answer
        except TimeoutError as error:
            raise LateAnswerError(self._client.url, f"no reply within {limit_s} s") from error
        except ConnectionClosed as error:
            raise NoAnswerError(self._client.url, error) from error

    def change(self, **fields: Any) -> None:  # noqa: ANN401 - the types are those of the fields
        """Changes fields of the controller of the session, as `Session.change`, from what it has now."""
        self._session.change(**fields)
        self.config = self._session.config

    def close(self) -> None:
        """Closes the connection. The session stays open."""
        self._exit.close()
