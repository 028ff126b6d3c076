"""The commands: joint velocities, trajectory points, or both."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from builtin_interfaces.msg import Duration
from rclpy.node import Node
from std_msgs.msg import Float64MultiArray
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from revprio_ros import conversion
from revprio_ros.parameters import ParameterError, Settings

MAX_LEAD = 0.1
"""Largest distance from the measured to the commanded position of a trajectory, rad or m, and the way of its age."""


Measured = tuple[Mapping[str, float], float]
"""Measured positions by name, rad or m, and their age, s."""


class Outputs:
    """Publishes one command per period."""

    def __init__(self, node: Node, settings: Settings) -> None:
        """Creates the publishers."""
        self._wanted = settings.command_joints
        self._velocities = self._trajectories = None
        if settings.output != "trajectory":
            self._velocities = node.create_publisher(Float64MultiArray, "forward_velocity_controller/commands", 1)
        if settings.output != "velocity":
            name = "joint_trajectory_controller/joint_trajectory"
            self._trajectories = node.create_publisher(JointTrajectory, name, 1)
        self._reference: list[float] | None = None

    @property
    def has_points(self) -> bool:
        """Whether it publishes trajectory points."""
        return self._trajectories is not None

    def check(self, joints: Sequence[str]) -> None:
        """Refuses `command_joints` that are not the joints of the robot."""
        if self._wanted and sorted(self._wanted) != sorted(joints):
            raise ParameterError(f"parameter `command_joints`: give the joints {', '.join(joints)}, in any order")

    def publish(
        self, joints: Sequence[str], velocity: Sequence[float], position: Measured | None, period_s: float
    ) -> None:
        """Publishes a command for one period: joint velocities in the order of `joints`."""
        if self._velocities is not None:
            ordered = conversion.in_order(velocity, joints, self._wanted or joints)
            self._velocities.publish(Float64MultiArray(data=ordered))
        if self._trajectories is not None:
            self._publish_point(joints, velocity, position, period_s)

    def rest(self) -> None:
        """Ends the trajectory. The next one begins at the measured position."""
        self._reference = None

    def _publish_point(
        self, joints: Sequence[str], velocity: Sequence[float], position: Measured | None, period_s: float
    ) -> None:
        """Publishes the commanded position one period ahead: the integral of the velocities, near the measured one."""
        near = self._reference
        if position:
            positions, age_s = position
            measured = [positions[joint] for joint in joints]
            leads = [MAX_LEAD + abs(speed) * age_s for speed in velocity]
            near = [min(max(p, q - lead), q + lead) for p, q, lead in zip(near or measured, measured, leads)]
        if near is None:
            return
        self._reference, velocities, (sec, nanosec) = conversion.trajectory_point(near, velocity, period_s)
        duration = Duration(sec=sec, nanosec=nanosec)
        point = JointTrajectoryPoint(positions=self._reference, velocities=velocities, time_from_start=duration)
        self._trajectories.publish(JointTrajectory(joint_names=list(joints), points=[point]))
