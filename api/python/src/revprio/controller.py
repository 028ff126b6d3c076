"""Running controllers: once per period, a measured state goes in and joint velocities come out."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from contextlib import ExitStack, suppress
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

from websockets.exceptions import ConnectionClosed, InvalidHandshake

from revprio import native, routes
from revprio._native import RefusedError
from revprio.bodies import ArrayLike, JointVector
from revprio.errors import LateAnswerError, NoAnswerError, NotFoundError, RevprioError
from revprio.models import (
    ControllerConfig,
    CreatedController,
    Memory,
    SessionStatus,
    State,
    StepAnswer,
    StepRequest,
    StreamedTarget,
    Wrench,
)
from revprio.native import LazyStepAnswer, set_fields
from revprio.states import StateNumbering
from revprio.streaming import ReplyMatcher, refused_handshake
from revprio.typed import fields_of

if TYPE_CHECKING:
    from revprio.calls import Calls
    from revprio.client import Client

new = object.__new__


class Controller:
    """A running controller: once per period, a measured state goes in and joint velocities come out.

    `Controller(robot=…, period_s=…, tasks=[…])` computes in this process, without a server. `Client.session` and
    `Client.stateless` return controllers with the same methods that a service computes. Different controllers may run
    in different threads: `step` computes without the lock of the interpreter.
    """

    @fields_of(ControllerConfig)
    def __init__(self, config: ControllerConfig) -> None:
        """Starts a controller in this process. Raises an `InvalidError` that names the wrong field."""
        self.period_s: float = config.period_s
        """Control period T, s."""
        self.config = config
        """The fields of the controller that were given."""
        self._native = native.controller(config.json_bytes())
        self._next = 0

    @property
    def joints(self) -> list[str]:
        """Names of the joints, in the order of all arrays."""
        return self._native.joints

    @property
    def warnings(self) -> list[str]:
        """Warnings: unstable loops, in free space and with the `environment`, and gains that are too high."""
        return self._native.warnings

    def step(
        self,
        joint_position: JointVector,
        *,
        joint_velocity: JointVector | None = None,
        wrench: Wrench | ArrayLike | None = None,
        time_s: float | None = None,
        targets: Mapping[str, StreamedTarget] | None = None,
    ) -> StepAnswer:
        """Runs one control period.

        `joint_position`: q, n, rad or m, as an array in the robot's joint order or a mapping by joint name.
        `joint_velocity`: q̇, n, rad/s or m/s; default: the last commanded velocity.
        `wrench`: force (N) and torque (N·m), 6, as the controller's `wrench_convention` and `wrench_frame` define.
        `time_s`: time t of the set-point profiles, s; default: the sequence number times the period.
        `targets`: new targets by task name, as in teleoperation; default: none. The service interpolates between them.

        Returns `joint_velocity`, n, rad/s or m/s. It is valid for `valid_for_ms` from the moment of measurement; see
        `Watchdog`. With a service: if an answer is lost, the client sends the state again with the same sequence
        number; the service never runs the same number twice.
        """
        # Every call here counts: the whole method costs less than a microsecond besides the step.
        sequence = self._next
        self._next = sequence + 1
        if time_s is None:
            time_s = sequence * self.period_s
        sent = None if targets is None else native.targets_json(targets)
        try:
            fields = self._native.step(sequence, time_s, joint_position, joint_velocity, wrench, sent)
        except RefusedError as refusal:
            raise native.problem(refusal) from None
        answer = new(LazyStepAnswer)
        set_fields(answer, fields)
        return answer

    def change(self, **fields: Any) -> None:  # noqa: ANN401 - the types are those of the fields
        """Changes fields of the controller while the arm moves: `controller.change(tasks=[…])`.

        Other fields stay. Tasks can be added, removed, reordered and changed; no joint exceeds its acceleration limit
        in the transition. Robot, period and drive cannot change.
        """
        config = config_with(self.config, fields)
        self._replace(config)
        self.config = config

    def _replace(self, config: ControllerConfig) -> None:
        native.replace(self._native, config.json_bytes())

    def step_state(self, state: State) -> StepAnswer:
        """Runs one control period with a state that has its own sequence number. Sequence numbers must increase."""
        self._next = state.sequence
        return Controller.step(
            self,
            state.joint_position,
            joint_velocity=state.joint_velocity,
            wrench=state.wrench,
            time_s=state.time_s,
            targets=state.targets,
        )

    def close(self) -> None:
        """Ends the controller."""

    def __enter__(self) -> Self:
        """Returns this object."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Ends the controller."""
        self.close()


def config_with(config: ControllerConfig, fields: Mapping[str, Any]) -> ControllerConfig:
    """Returns a controller with these fields changed; raises an `InvalidError` that names the wrong field."""
    given = {name: getattr(config, name) for name in config.model_fields_set}
    return ControllerConfig(**{**given, **fields})


def stateless_change() -> RevprioError:
    """Returns the error of a change of a stateless controller."""
    return RevprioError("a stateless controller cannot change while the arm moves; use `Client.session`")


class RemoteController(Controller):
    """A controller that a service computes."""

    def __init__(self, config: ControllerConfig) -> None:
        """`config`: the controller."""
        self.config = config
        self.period_s = config.period_s
        self._numbering = StateNumbering(config.period_s)

    def step(
        self,
        joint_position: JointVector,
        *,
        joint_velocity: JointVector | None = None,
        wrench: Wrench | ArrayLike | None = None,
        time_s: float | None = None,
        targets: Mapping[str, StreamedTarget] | None = None,
    ) -> StepAnswer:
        """As `Controller.step`."""
        return self.step_state(self._numbering.state(joint_position, joint_velocity, wrench, time_s, targets))

    @abstractmethod
    def step_state(self, state: State) -> StepAnswer:
        """Runs one control period with a state that has its own sequence number. Sequence numbers must increase."""


class Session(RemoteController):
    """A controller whose memory the service keeps."""

    def __init__(self, client: Client, config: ControllerConfig) -> None:
        """Opens the session."""
        super().__init__(config)
        self._client = client
        self.created: CreatedController = client.call(routes.CREATE_CONTROLLER(body=config))
        """The answer of the service: session name, joint order, and warnings about unstable contacts."""

    @property
    def joints(self) -> list[str]:
        """Names of the joints, in the order of all arrays."""
        return self.created.joints

    @property
    def warnings(self) -> list[str]:
        """Warnings: unstable loops, in free space and with the `environment`, and gains that are too high."""
        return self.created.warnings

    @property
    def id(self) -> str:
        """Name of the session."""
        return self.created.id

    def step_state(self, state: State) -> StepAnswer:
        """Runs one control period with a state that has its own sequence number. Sequence numbers must increase."""
        return self._client.call(routes.STEP_CONTROLLER(self.id, body=state), self._client.step_timeout_s)

    def _replace(self, config: ControllerConfig) -> None:
        self.created = self._client.call(routes.REPLACE_CONTROLLER(self.id, body=config))
        self.config = config

    def status(self) -> SessionStatus:
        """Returns the configuration, the last sequence number and counters."""
        return self._client.call(routes.SHOW_CONTROLLER(self.id))

    def stream(self) -> Stream:
        """Opens a WebSocket to the same controller, for loops that are too fast for single requests.

        Closing the stream keeps the session.
        """
        return Stream(self._client, self)

    def close(self) -> None:
        """Ends the session; does nothing if it has already ended."""
        with suppress(NotFoundError):
            self._client.call(routes.DELETE_CONTROLLER(self.id))

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Ends the session.

        An error of the block has precedence over an error of `close`. The service ends an idle session itself.
        """
        try:
            self.close()
        except Exception:
            if error is None:
                raise


class Stateless(RemoteController):
    """A controller that sends its memory with each request, so that any replica of the service can answer it."""

    def __init__(self, client: Calls, config: ControllerConfig) -> None:
        """Starts without memory."""
        super().__init__(config)
        self._client = client
        self.memory: Memory | None = None
        """The controller memory of the last answer, for the next request. It may be stored and set again."""

    def step_state(self, state: State) -> StepAnswer:
        """Runs one control period with a state that has its own sequence number. Sequence numbers must increase."""
        request = StepRequest(controller=self.config, state=state, memory=self.memory)
        answer = self._client.call(routes.STEP(body=request), self._client.step_timeout_s)
        self.memory = answer.memory
        return answer

    def _replace(self, config: ControllerConfig) -> None:  # noqa: ARG002
        raise stateless_change()

    def close(self) -> None:
        """Does nothing, because the service stores nothing."""


class Stream(RemoteController):
    """A session over a WebSocket."""

    def __init__(self, client: Client, session: Session) -> None:
        """Opens the connection."""
        super().__init__(session.config)
        self._session, self._numbering = session, session._numbering
        self._url, self._timeout_s = client.url, client.step_timeout_s
        self._replies = ReplyMatcher(client.url)
        self._exit = ExitStack()
        try:
            self._socket = self._exit.enter_context(client.connect(routes.STREAM_CONTROLLER.format(session.id)))
        except InvalidHandshake as error:
            raise refused_handshake(client.url, error) from error
        except OSError as error:
            raise NoAnswerError(client.url, error) from error

    def step_state(self, state: State) -> StepAnswer:
        """Runs one control period with a state that has its own sequence number. Sequence numbers must increase."""
        try:
            self._socket.send(self._replies.encode(state))
            while True:
                answer = self._replies.decode(self._socket.recv(self._timeout_s))
                if answer is not None:
                    return answer
        except TimeoutError as error:
            raise LateAnswerError(self._url, f"no reply within {self._timeout_s} s") from error
        except ConnectionClosed as error:
            raise NoAnswerError(self._url, error) from error

    def _replace(self, config: ControllerConfig) -> None:
        self._session._replace(config)

    def close(self) -> None:
        """Closes the connection. The session stays open."""
        self._exit.close()
