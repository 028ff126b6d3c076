"""The newest measurements, and whether they are fresh."""

from __future__ import annotations

from typing import Any

from geometry_msgs.msg import WrenchStamped
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import JointState

from revprio_ros import conversion
from revprio_ros.conversion import NotUsable
from revprio_ros.loop_clock import LoopClock
from revprio_ros.parameters import Settings


class Inputs:
    """Receives joint states and wrenches."""

    def __init__(self, node: Node, clock: LoopClock, settings: Settings) -> None:
        """Subscribes to the topics."""
        self._clock, self._settings = clock, settings
        self._newest: dict[str, tuple[Any, float] | None] = {}
        self._names: dict[str, str] = {}
        kinds = {"joint_states": JointState} | ({"wrench": WrenchStamped} if settings.use_wrench else {})
        for topic, kind in kinds.items():
            subscription = node.create_subscription(kind, topic, self._receiver(topic), qos_profile_sensor_data)
            self._newest[topic], self._names[topic] = None, subscription.topic_name

    def _receiver(self, topic: str) -> Any:
        def receive(message: Any) -> None:
            # Converted once, so that a repeated measurement keeps its time.
            self._newest[topic] = message, self._clock.now_s() - self._clock.age_s(message.header.stamp)

        return receive

    def check_fresh(self) -> None:
        """Raises a `NotUsable` that names a topic without a fresh message."""
        for topic, newest in self._newest.items():
            name = self._names[topic]
            if newest is None:
                raise NotUsable(f"no message on `{name}` yet; start the driver, or remap the topic")
            age_s, limit_s = self._clock.now_s() - newest[1], self._settings.max_age_s
            if age_s > limit_s:
                raise NotUsable(f"`{name}` is stale: its newest stamp is {age_s:.3f} s old, more than {limit_s} s")
            if age_s < -limit_s:
                raise NotUsable(f"`{name}` has a stamp {-age_s:.3f} s in the future; synchronise the clocks")

    def position(self, joints: list[str]) -> tuple[dict[str, float], float] | None:
        """Returns the measured positions and their age, s; None if they are not fresh."""
        newest = self._newest["joint_states"]
        if newest is None:
            return None
        age_s = abs(self._clock.now_s() - newest[1])
        try:
            position = conversion.measurement(newest[0], None, joints, None)["joint_position"]
        except NotUsable:
            return None
        return (position, age_s) if age_s <= self._settings.max_age_s else None

    def measurement(self, joints: list[str]) -> tuple[dict[str, Any], float]:
        """Returns the arguments of `revprio.Controller.step`, and the time of the measurement on the loop's clock."""
        self.check_fresh()
        joint_state, measured_s = self._newest["joint_states"]
        wrench, _ = self._newest.get("wrench", (None, 0.0))
        arguments = conversion.measurement(joint_state, wrench, joints, self._settings.sensor_transform)
        return arguments, min(measured_s, self._clock.now_s())
