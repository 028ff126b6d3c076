"""The clock of the control loop."""

from __future__ import annotations

from rclpy.clock import Clock, ClockType
from rclpy.node import Node

from revprio_ros.conversion import seconds


class LoopClock:
    """The clock of the control loop: steady, so that a jump of the system's clock does not change the loop.

    The age of a message is the difference between the clock of ROS and its stamp. With `use_sim_time`, both clocks are
    `/clock`.
    """

    def __init__(self, node: Node) -> None:
        """Reads `use_sim_time` of the node."""
        self._ros = node.get_clock()
        is_simulated = node.get_parameter("use_sim_time").value
        self.is_steady = not is_simulated
        """Whether the clock cannot stand still."""
        self.clock = self._ros if is_simulated else Clock(clock_type=ClockType.STEADY_TIME)
        """The clock of the timer."""

    def now_s(self) -> float:
        """Returns the time of the loop, s."""
        return 1e-9 * self.clock.now().nanoseconds

    def age_s(self, stamp: object) -> float:
        """Returns the age of a stamp, s; negative for a stamp in the future."""
        return 1e-9 * self._ros.now().nanoseconds - seconds(stamp)
