"""Conversion between ROS 2 messages and the values of revprio.

This module does not import ROS. It accepts any object with the fields of the message; the tests use this.
"""

from math import isfinite, sqrt

AXES = ("x", "y", "z")


class NotUsable(ValueError):
    """A message cannot be used: it is missing or too old, or a value is missing or not finite."""


def seconds(stamp):
    """Converts builtin_interfaces/Time to seconds."""
    return stamp.sec + 1e-9 * stamp.nanosec


def by_name(joint_state, field, joints):
    """Returns a field of sensor_msgs/JointState as {name: value} for `joints`, or None if a value is missing.

    The message can list joints in any order and can include other joints, for example of a gripper. A driver that does
    not measure a quantity leaves the field empty or fills it with NaN.
    """
    values = dict(zip(joint_state.name, getattr(joint_state, field)))
    chosen = {joint: values.get(joint, float("nan")) for joint in joints}
    return chosen if all(map(isfinite, chosen.values())) else None


def vector(xyz):
    """Converts geometry_msgs/Vector3 to a list."""
    return [getattr(xyz, axis) for axis in AXES]


def rotated(q, v):
    """Rotates a vector (list) by a geometry_msgs/Quaternion of unit length: v + 2w (u × v) + 2u × (u × v)."""
    u = vector(q)
    once = cross(u, v)
    twice = cross(u, once)
    return [a + 2 * q.w * b + 2 * c for a, b, c in zip(v, once, twice)]


def cross(a, b):
    """Returns a × b."""
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def wrench(message, transform=None):
    """Converts geometry_msgs/Wrench to the `wrench` of a state: six numbers, force (N), then torque (N·m).

    `transform` (geometry_msgs/Transform) maps the frame of the message to the frame that the controller expects, as
    tf2's lookup_transform(target, source) returns it. The torque is moved to the new origin: τ' = R τ + p × R f.
    """
    force, torque = vector(message.force), vector(message.torque)
    if transform is not None:
        force, torque = rotated(transform.rotation, force), rotated(transform.rotation, torque)
        lever = cross(vector(transform.translation), force)
        torque = [a + b for a, b in zip(torque, lever)]
    return force + torque


def measurement(joint_state, wrench_stamped, joints, transform=None):
    """Converts sensor_msgs/JointState and geometry_msgs/WrenchStamped to the arguments of `revprio.Controller.step`.

    `wrench_stamped` is None for a controller that uses no wrench. Raises a `NotUsable` if a value is missing or NaN.
    """
    missing = [joint for joint in joints if joint not in joint_state.name]
    if missing:
        raise NotUsable(
            f"`joint_states` lacks {', '.join(missing)} and has {', '.join(joint_state.name) or 'no joints'}; give the "
            "service the URDF of the driver, or let the driver publish all joints in one message"
        )
    position = by_name(joint_state, "position", joints)
    if position is None:
        raise NotUsable("`joint_states` has a joint position that is missing or not finite; check the driver")
    velocity = by_name(joint_state, "velocity", joints)
    arguments = {"joint_position": position} | ({} if velocity is None else {"joint_velocity": velocity})
    if wrench_stamped is None:
        return arguments
    measured = wrench(wrench_stamped.wrench, transform)
    if not all(map(isfinite, measured)):
        raise NotUsable("`wrench` has a value that is not finite; check the sensor")
    return arguments | {"wrench": measured}


def twist_problem(robot, joint_position, twist, period_s):
    """Converts geometry_msgs/Twist of the tool, base axes, to a body of POST /v1/resolve.

    Translation is the task of higher priority, rotation the task of lower priority.
    """

    def task(name, axes, velocity):
        return {"name": name, "axes": axes, "velocity": vector(velocity)}

    tasks = [task("translation", ["x", "y", "z"], twist.linear), task("rotation", ["rx", "ry", "rz"], twist.angular)]
    damping = {"threshold": 0.05, "max_factor": 0.1}
    return {"robot": robot, "joint_position": joint_position, "tasks": tasks, "period_s": period_s, "damping": damping}


def in_order(velocity, joints, wanted):
    """Reorders joint velocities from the order `joints` of an answer to the order `wanted` of a ROS controller."""
    speed = dict(zip(joints, velocity, strict=True))
    return [speed[joint] for joint in wanted]


def trajectory_point(position, velocity, period_s):
    """Returns positions, velocities and time_from_start (sec, nanosec) of a JointTrajectoryPoint one period ahead."""
    sec, nanosec = divmod(round(1e9 * period_s), 10**9)
    return [q + period_s * v for q, v in zip(position, velocity, strict=True)], list(velocity), (sec, nanosec)


def twist_rows(twist, axes):
    """Converts geometry_msgs/Twist to one velocity per row of a task with these axes."""
    six = dict(zip((*AXES, "rx", "ry", "rz"), vector(twist.linear) + vector(twist.angular)))
    velocity = [six[axis] for axis in axes]
    if not all(map(isfinite, velocity)):
        raise NotUsable("the twist has a value that is not finite")
    return velocity


def pose(message):
    """Converts geometry_msgs/Pose to position (3) and orientation ({w, x, y, z} of unit length)."""
    position, q = vector(message.position), message.orientation
    length = sqrt(q.w**2 + q.x**2 + q.y**2 + q.z**2)
    if not all(map(isfinite, position)) or not abs(length - 1) < 1e-3:
        raise NotUsable("the pose has a value that is not finite, or an orientation that is not of unit length")
    return position, {name: getattr(q, name) / length for name in "wxyz"}


def trajectory_actions(message, joints):
    """Converts trajectory_msgs/JointTrajectory to actions: (seconds after the stamp, {"joint_position": by name})."""
    missing = [joint for joint in joints if joint not in message.joint_names]
    if missing:
        raise NotUsable(f"the trajectory lacks {', '.join(missing)} and has {', '.join(message.joint_names)}")
    actions = []
    for point in message.points:
        if len(point.positions) != len(message.joint_names) or not all(map(isfinite, point.positions)):
            raise NotUsable("a point of the trajectory has not one finite position per joint")
        position = dict(zip(message.joint_names, point.positions, strict=True))
        actions.append(
            (seconds(point.time_from_start), {"joint_position": {joint: position[joint] for joint in joints}})
        )
    return actions


def pose_actions(message, interval_s):
    """Converts geometry_msgs/PoseArray to actions `interval_s` apart: (s after the stamp, position, orientation)."""
    values = [pose(entry) for entry in message.poses]
    keys = ("position", "orientation")
    return [(k * interval_s, dict(zip(keys, value, strict=True))) for k, value in enumerate(values)]
