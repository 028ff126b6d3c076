"""Controllers that run: a measured state in, joint velocities out, once per period."""

from __future__ import annotations

from abc import ABC, abstractmethod
from contextlib import ExitStack, suppress
from types import TracebackType
from typing import TYPE_CHECKING, Self

from websockets.exceptions import ConnectionClosed, InvalidHandshake

from revprio import routes
from revprio.bodies import ArrayLike, JointVector
from revprio.errors import LateAnswerError, NoAnswerError, NotFoundError
from revprio.models import (
    ControllerConfig,
    CreatedController,
    Memory,
    SessionStatus,
    State,
    StepAnswer,
    StepRequest,
    Wrench,
)
from revprio.states import Numbering
from revprio.streaming import Replies, refused_handshake

if TYPE_CHECKING:
    from revprio.client import Client


class Controller(ABC):
    """One controller; made by `Client.session` or `Client.stateless`. Use it in a `with` block."""

    def __init__(self, period_s: float) -> None:
        """`period_s`: T, s."""
        self.period_s = period_s
        self._numbering = Numbering(period_s)

    def step(
        self,
        joint_position: JointVector,
        *,
        joint_velocity: JointVector | None = None,
        wrench: Wrench | ArrayLike | None = None,
        time_s: float | None = None,
    ) -> StepAnswer:
        """One control period.

        `joint_position`: q, n, rad or m, as an array in the robot's joint order or a mapping by joint name.
        `joint_velocity`: q̇, n, rad/s or m/s; the last command stands for it if left out.
        `wrench`: force (N) and torque (N·m), 6, as the controller's `wrench_convention` and `wrench_frame` say.
        `time_s`: t of profiles, s; period by period from 0 if left out.

        Answers with `joint_velocity`, n, rad/s or m/s, good for `valid_for_ms` from the moment of measurement; see
        `Watchdog`. A state whose answer is lost on the way is sent again under the same number, which is never stepped
        twice.
        """
        return self.step_state(self._numbering.state(joint_position, joint_velocity, wrench, time_s))

    @abstractmethod
    def step_state(self, state: State) -> StepAnswer:
        """One control period with a state that has its own sequence number, which must grow."""

    @abstractmethod
    def close(self) -> None:
        """Ends it."""

    def __enter__(self) -> Self:
        """Itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Ends it."""
        self.close()


class Session(Controller):
    """A controller whose memory the service keeps."""

    def __init__(self, client: Client, config: ControllerConfig) -> None:
        """Opens the session."""
        super().__init__(config.period_s)
        self._client = client
        self.created: CreatedController = client.call(routes.CREATE_CONTROLLER(body=config))
        """Its name, the joint order, and warnings about contacts that would bounce."""

    @property
    def id(self) -> str:
        """Name of the session."""
        return self.created.id

    def step_state(self, state: State) -> StepAnswer:
        """One control period with a state that has its own sequence number, which must grow."""
        return self._client.call(routes.STEP_CONTROLLER(self.id, body=state), self._client.step_timeout_s)

    def status(self) -> SessionStatus:
        """Configuration, last sequence number and counters."""
        return self._client.call(routes.SHOW_CONTROLLER(self.id))

    def stream(self) -> Stream:
        """The same controller over a WebSocket, for loops faster than requests allow. Closing it keeps the session."""
        return Stream(self._client, self)

    def close(self) -> None:
        """Ends the session, if it has not ended by itself."""
        with suppress(NotFoundError):
            self._client.call(routes.DELETE_CONTROLLER(self.id))

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Ends the session; where that fails after another failure, the service ends it by itself when it is idle."""
        try:
            self.close()
        except Exception:
            if error is None:
                raise


class Stateless(Controller):
    """A controller whose memory travels with each request, so that any replica of the service answers any of them."""

    def __init__(self, client: Client, config: ControllerConfig) -> None:
        """Begins without memory."""
        super().__init__(config.period_s)
        self._client, self._config = client, config
        self.memory: Memory | None = None
        """What the last answer asked to be told; may be stored and put back."""

    def step_state(self, state: State) -> StepAnswer:
        """One control period with a state that has its own sequence number, which must grow."""
        request = StepRequest(controller=self._config, state=state, memory=self.memory)
        answer = self._client.call(routes.STEP(body=request), self._client.step_timeout_s)
        self.memory = answer.memory
        return answer

    def close(self) -> None:
        """Does nothing: the service keeps nothing of it."""


class Stream(Controller):
    """A session over a WebSocket."""

    def __init__(self, client: Client, session: Session) -> None:
        """Connects."""
        super().__init__(session.period_s)
        self._numbering = session._numbering
        self._url, self._timeout_s = client.url, client.step_timeout_s
        self._replies = Replies(client.url)
        self._exit = ExitStack()
        try:
            self._socket = self._exit.enter_context(client.connect(routes.STREAM_CONTROLLER.format(session.id)))
        except InvalidHandshake as error:
            raise refused_handshake(client.url, error) from error
        except OSError as error:
            raise NoAnswerError(client.url, error) from error

    def step_state(self, state: State) -> StepAnswer:
        """One control period with a state that has its own sequence number, which must grow."""
        try:
            self._socket.send(self._replies.ask(state))
            while True:
                answer = self._replies.hear(self._socket.recv(self._timeout_s))
                if answer is not None:
                    return answer
        except TimeoutError as error:
            raise LateAnswerError(self._url, f"nothing within {self._timeout_s} s") from error
        except ConnectionClosed as error:
            raise NoAnswerError(self._url, error) from error

    def close(self) -> None:
        """Ends the connection, not the session."""
        self._exit.close()
