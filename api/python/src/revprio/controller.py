"""A running controller: once per period, a measured state goes in and joint velocities come out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import TracebackType
from typing import Any, Self

from revprio import native
from revprio._native import RefusedError
from revprio.bodies import ArrayLike, JointVector
from revprio.models import ChannelInput, ControllerConfig, ObstacleState, State, StepAnswer, StreamedTarget, Wrench
from revprio.native import LazyStepAnswer, set_fields
from revprio.reported import log_warnings
from revprio.typed import fields_of

new = object.__new__


class Controller:
    """A running controller: once per period, a measured state goes in and joint velocities come out.

    `Controller(robot=…, period_s=…, tasks=[…])` computes in this process, without a server. `Client.session` and
    `Client.stateless` return controllers with the same methods that a service computes.

    Threads: use one controller in one thread. Different controllers run in parallel in different threads, because
    `step` computes without the lock of the interpreter. Two threads that step the same controller mix their states.

    Processes: after `os.fork`, parent and child have a controller each, which do not know of each other: let one of
    them move the arm. If another thread computes a step while the process forks, the child's controller raises a
    `RuntimeError`. A controller cannot be pickled; create one in the other process, from `config`.
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
        log_warnings(self.warnings)

    @property
    def joints(self) -> list[str]:
        """Names of the joints, in the order of all arrays."""
        return self._native.joints

    @property
    def warnings(self) -> list[str]:
        """What the controller may do wrong: unstable loops, numbers in wrong units, gains that are too high.

        The logger `revprio` prints them when the controller is created or changed.
        """
        return self._native.warnings

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
        """Runs one control period.

        `joint_position`: q, n, rad or m, as an array in the robot's joint order or a mapping by joint name.
        `joint_velocity`: q̇, n, rad/s or m/s; default: the last commanded velocity.
        `wrench`: force (N) and torque (N·m), 6, as the controller's `wrench_convention` and `wrench_frame` define.
        `time_s`: time t of the set-point profiles, s; default: the sequence number times the period.
        `targets`: new targets by task name, as in teleoperation; default: none. The service interpolates between them.
        `obstacles`: where the moving obstacles of the controller are; each must be named. Default: none.
        `wrenches`: those of other tips than the tool, by the name of the tip. Default: none.
        `channels`: what arrived for channels besides the joints, such as a gripper, by name. Default: nothing.

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
        moved = None if obstacles is None else native.obstacles_json(obstacles)
        others = None if wrenches is None else native.wrenches_json(wrenches)
        besides = None if channels is None else native.channels_json(channels)
        try:
            arrived = (sent, moved, others, besides)
            fields = self._native.step(sequence, time_s, joint_position, joint_velocity, wrench, arrived)
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
        log_warnings(self.warnings)

    def step_state(self, state: State) -> StepAnswer:
        """Runs one control period with a state that has its own sequence number. Sequence numbers must increase."""
        following, self._next = self._next, state.sequence
        try:
            return Controller.step(
                self,
                state.joint_position,
                joint_velocity=state.joint_velocity,
                wrench=state.wrench,
                time_s=state.time_s,
                targets=state.targets,
                obstacles=state.obstacles,
                wrenches=state.wrenches,
                channels=state.channels,
            )
        finally:
            self._next = max(following, self._next)

    def __reduce__(self) -> str:
        """Refuses to copy a controller: two copies of one memory would move one arm."""
        message = "a running controller cannot be copied or pickled; create another one from its `config`"
        raise TypeError(message)

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
