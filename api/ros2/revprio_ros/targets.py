"""Streamed targets: twists and poses for the tasks of the controller."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import revprio
from geometry_msgs.msg import PoseStamped, TwistStamped
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data

from revprio_ros import conversion
from revprio_ros.conversion import NotUsable, seconds
from revprio_ros.loop_clock import LoopClock
from revprio_ros.parameters import ParameterError, Settings, topic

MAX_AGE_S = 1.0
"""Older targets are not used, s. The task brakes long before."""


class Targets:
    """Receives a twist for each task with the law `velocity`, and a pose for `pose`, `impedance` and `hybrid`.

    The topics are `targets/TASK`. The frame of a target must be that of the task, see `target_frame`. Tasks in a frame
    of their own pose have no topic.
    """

    def __init__(self, node: Node, clock: LoopClock, settings: Settings) -> None:
        """Subscribes to the topics. Raises a `ParameterError` if two tasks would have the same topic."""
        self._clock, self._settings = clock, settings
        self._newest: dict[str, tuple[float, Any]] = {}
        self.refusals: dict[str, str] = {}
        """Why the newest target of a task was not used, by task."""
        self.topics: dict[str, str] = {}
        """Task by topic."""
        for task in settings.config.tasks:
            kind = getattr(task.law, "kind", None)
            message = {"velocity": TwistStamped}.get(kind) or PoseStamped
            if kind not in ("velocity", "pose", "impedance", "hybrid") or not isinstance(task.frame or "base", str):
                continue
            name = f"targets/{topic(task.name)}"
            if name in self.topics:
                raise ParameterError(f"parameter `controller`: two tasks have the topic {name}; rename one of them")
            self.topics[name] = task.name
            node.create_subscription(message, name, self._receiver(task), qos_profile_sensor_data)

    def current(self, start_s: float) -> dict[str, revprio.StreamedTarget]:
        """Returns the newest target of each task; their times count from `start_s` on the loop's clock."""
        now_s = self._clock.now_s()
        # After a jump of the clock, a target can lie in the future.
        recent = {name: given for name, given in self._newest.items() if abs(now_s - given[0]) <= MAX_AGE_S}
        return {name: target.model_copy(update={"time_s": at_s - start_s}) for name, (at_s, target) in recent.items()}

    def _receiver(self, task: revprio.ControllerTask) -> Callable[[Any], None]:
        convert = twist if task.law.kind == "velocity" else pose
        frame = target_frame(task, self._settings)

        def receive(message: Any) -> None:
            try:
                at_s = self._time_s(message.header.stamp)
                check_frame(message.header.frame_id, frame)
                self._newest[task.name] = (at_s, convert(message, task))
                self.refusals.pop(task.name, None)
            except NotUsable as error:
                self.refusals[task.name] = str(error)

        return receive

    def _time_s(self, stamp: Any) -> float:
        """Returns the time of a target on the loop's clock, s. A stamp of zero means the time of its arrival."""
        age_s = self._clock.age_s(stamp) if seconds(stamp) else 0.0
        if not -self._settings.max_age_s <= age_s <= MAX_AGE_S:
            raise NotUsable(f"its stamp is {age_s:.3f} s old; synchronise the clock of the sender")
        return self._clock.now_s() - age_s


def target_frame(task: revprio.ControllerTask, settings: Settings) -> str:
    """Returns the frame in which the service reads the targets of a task: a tip or link has its name as `frame_id`."""
    if task.law.kind == "velocity" and task.frame == "tool":
        return task.link or settings.tool_frame
    return task.relative_to or settings.base_frame


def check_frame(given: str, expected: str) -> None:
    """Refuses a target in another frame."""
    if given != expected:
        raise NotUsable(f"its frame is `{given}`; transform it to `{expected}`")


def twist(message: TwistStamped, task: revprio.ControllerTask) -> revprio.StreamedTarget:
    """Converts a twist to one velocity per row of a task."""
    axes = [task.axes] if isinstance(task.axes, str) else task.axes
    if axes is None:
        raise NotUsable("the task has a jacobian instead of axes, so a twist does not fit")
    return revprio.StreamedTarget(velocity=conversion.twist_rows(message.twist, axes))


def pose(message: PoseStamped, _task: revprio.ControllerTask) -> revprio.StreamedTarget:
    """Converts a pose."""
    position, orientation = conversion.pose(message.pose)
    streamed = revprio.StreamedPose(position=position, orientation=revprio.Orientation(**orientation))
    return revprio.StreamedTarget(pose=streamed)
