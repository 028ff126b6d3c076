"""Chunks of actions: trajectories of joints and arrays of poses for the tasks of the controller."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import revprio
from geometry_msgs.msg import PoseArray
from rclpy.node import Node
from trajectory_msgs.msg import JointTrajectory

from revprio_ros import conversion
from revprio_ros.conversion import NotUsable, seconds
from revprio_ros.loop_clock import LoopClock
from revprio_ros.parameters import ParameterError, Settings, topic
from revprio_ros.targets import check_frame, target_frame

MAX_AGE_S = 1.0
"""Chunks with an older stamp are not used, s."""

Chunk = tuple[float, list[tuple[float, dict[str, Any]]]]
"""Time of the stamp on the loop's clock, s; times from it, s, and values of the actions."""


class Chunks:
    """Receives a `JointTrajectory` for each task with the law `posture`, and a `PoseArray` for the laws of poses.

    The laws of poses are `pose`, `impedance` and `hybrid`. The topics are `chunks/TASK`. The stamp is the time of
    the first action; zero means the time of arrival.
    """

    def __init__(self, node: Node, clock: LoopClock, settings: Settings) -> None:
        """Subscribes to the topics. Raises a `ParameterError` if two tasks would have the same topic."""
        self._clock, self._settings = clock, settings
        self._arrived: dict[str, Chunk] = {}
        self._sent: dict[str, Chunk] = {}
        self._settled = 0
        self.refusals: dict[str, str] = {}
        """Why the newest chunk of a task was not used, by task."""
        topics: set[str] = set()
        for task in settings.config.tasks:
            kind = getattr(task.law, "kind", None)
            name = f"chunks/{topic(task.name)}"
            if kind == "posture" and getattr(task.law, "joints", None):
                message = JointTrajectory
            elif kind in ("pose", "impedance", "hybrid") and isinstance(task.frame or "base", str):
                message = PoseArray
            else:
                continue
            if name in topics:
                raise ParameterError(f"parameter `controller`: two tasks have the topic {name}; rename one of them")
            topics.add(name)
            node.create_subscription(message, name, self._receiver(task), 10)

    def current(self, start_s: float, settled: int) -> dict[str, revprio.StreamedTarget]:
        """Returns the chunks for the next state: those that no state has brought which was answered or refused.

        Their times count from `start_s` on the loop's clock. `settled`: number of such states so far.
        """
        if settled > self._settled:
            self._arrived = {name: chunk for name, chunk in self._arrived.items() if self._sent.get(name) is not chunk}
        self._sent, self._settled = dict(self._arrived), settled
        return {name: target(at_s - start_s, actions) for name, (at_s, actions) in self._arrived.items()}

    def _receiver(self, task: revprio.ControllerTask) -> Callable[[Any], None]:
        def receive(message: Any) -> None:
            try:
                self._arrived[task.name] = self._time_s(message.header.stamp), self._actions(message, task)
                self.refusals.pop(task.name, None)
            except NotUsable as error:
                self.refusals[task.name] = f"chunk: {error}"

        return receive

    def _actions(self, message: Any, task: revprio.ControllerTask) -> list[tuple[float, dict[str, Any]]]:
        if task.law.kind == "posture":
            actions = conversion.trajectory_actions(message, list(task.law.joints))
        else:
            check_frame(message.header.frame_id, target_frame(task, self._settings))
            actions = conversion.pose_actions(message, self._settings.chunk_interval_s)
        if not actions:
            raise NotUsable("it has no actions")
        return actions

    def _time_s(self, stamp: Any) -> float:
        """Returns the time of the first action on the loop's clock, s."""
        age_s = self._clock.age_s(stamp) if seconds(stamp) else 0.0
        if not abs(age_s) <= MAX_AGE_S:
            raise NotUsable(f"its stamp is {age_s:.3f} s old; synchronise the clock of the sender")
        return self._clock.now_s() - age_s


def target(at_s: float, actions: list[tuple[float, dict[str, Any]]]) -> revprio.StreamedTarget:
    """Returns actions as a target; `at_s`: time of the stamp on the clock of the states."""
    chunk = [revprio.ChunkAction.model_validate({"time_s": at_s + after_s, **values}) for after_s, values in actions]
    return revprio.StreamedTarget(chunk=chunk)
