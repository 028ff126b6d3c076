"""Where the moving obstacles of the controller are: one topic for each."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import isfinite
from typing import Any

import revprio
from geometry_msgs.msg import PoseStamped
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data

from revprio_ros.conversion import NotUsable, vector
from revprio_ros.loop_clock import LoopClock
from revprio_ros.parameters import ParameterError, Settings, topic


@dataclass(frozen=True)
class Seen:
    """A position of an obstacle, m, its stamp, ns, and its time on the loop's clock, s."""

    position: list[float]
    stamp_ns: int
    at_s: float


class Obstacles:
    """Receives a pose for each obstacle that moves. Its velocity is that between its two newest poses."""

    def __init__(self, node: Node, clock: LoopClock, settings: Settings) -> None:
        """Subscribes to the topics. Raises a `ParameterError` if two obstacles would have the same topic."""
        self._clock, self._settings = clock, settings
        self._newest: dict[str, list[Seen]] = {}
        self._topics: dict[str, str] = {}
        self._refusals: dict[str, str] = {}
        collisions = settings.config.collisions
        for obstacle in (collisions.obstacles if collisions else None) or []:
            if not obstacle.moves:
                continue
            name = f"obstacles/{topic(obstacle.name)}"
            if name in self._topics.values():
                raise ParameterError(f"parameter `controller`: two obstacles have the topic {name}; rename one of them")
            receive = self._receiver(obstacle.name)
            subscription = node.create_subscription(PoseStamped, name, receive, qos_profile_sensor_data)
            self._topics[obstacle.name], self._newest[obstacle.name] = subscription.topic_name, []

    def _receiver(self, name: str) -> Callable[[Any], None]:
        def receive(message: PoseStamped) -> None:
            position = vector(message.pose.position)
            if message.header.frame_id != self._settings.base_frame:
                frame = self._settings.base_frame
                self._refusals[name] = f"its frame is `{message.header.frame_id}`; transform it to `{frame}`"
            elif not all(map(isfinite, position)):
                self._refusals[name] = "its position is not finite"
            else:
                self._refusals.pop(name, None)
                stamp = message.header.stamp
                seen = Seen(position, nanoseconds(stamp), self._clock.now_s() - self._clock.age_s(stamp))
                self._newest[name] = with_newer(self._newest[name], seen, self._settings.max_age_s)

        return receive

    def check_fresh(self) -> None:
        """Raises a `NotUsable` that names an obstacle without a fresh pose."""
        now_s, limit_s = self._clock.now_s(), self._settings.max_age_s
        for name, topic_name in self._topics.items():
            if name in self._refusals:
                raise NotUsable(f"`{topic_name}` is not used: {self._refusals[name]}")
            if not self._newest[name]:
                raise NotUsable(f"no message on `{topic_name}` yet; start what tracks the obstacle, or remap the topic")
            age_s = now_s - self._newest[name][-1].at_s
            if abs(age_s) > limit_s:
                raise NotUsable(
                    f"`{topic_name}` is stale: its newest stamp is {age_s:.3f} s old, more than {limit_s} s"
                )

    def current(self) -> list[revprio.ObstacleState]:
        """Returns where all moving obstacles are. Raises a `NotUsable` as `check_fresh`."""
        self.check_fresh()
        return [state(name, seen) for name, seen in self._newest.items()]


def nanoseconds(stamp: Any) -> int:
    """Returns a stamp in ns. As seconds, it would be rounded."""
    return int(stamp.sec) * 10**9 + int(stamp.nanosec)


def with_newer(seen: list[Seen], new: Seen, max_age_s: float) -> list[Seen]:
    """Returns the two newest poses, or one after a jump of the clock. A repeated or late one is no motion."""
    if not seen or new.stamp_ns > seen[-1].stamp_ns:
        return [*seen[-1:], new]
    has_jumped = seen[-1].stamp_ns - new.stamp_ns > 1e9 * max_age_s
    return [new] if has_jumped else seen


def state(name: str, seen: list[Seen]) -> revprio.ObstacleState:
    """Returns the newest position of an obstacle, with the velocity from the one before; at rest if there is none."""
    newest = seen[-1]
    velocity = [0.0, 0.0, 0.0]
    if len(seen) > 1:
        elapsed_s = 1e-9 * (newest.stamp_ns - seen[0].stamp_ns)
        velocity = [(b - a) / elapsed_s for a, b in zip(seen[0].position, newest.position, strict=True)]
    return revprio.ObstacleState(name=name, position=newest.position, velocity=velocity)
