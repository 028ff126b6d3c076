"""Conversion between ROS 2 messages and the JSON bodies of revprio.

This module does not import ROS. It accepts any object with the fields of the message; the tests use this.
"""

from math import copysign, inf, isfinite

AXES = ("x", "y", "z")


class NotFresh(ValueError):
    """No state can be sent: a message is missing, too old, or lacks a joint position."""


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
    """Converts geometry_msgs/Wrench to the `wrench` of a state, N and N·m.

    `transform` (geometry_msgs/Transform) maps the frame of the message to the frame that the controller expects, as
    tf2's lookup_transform(target, source) returns it. The torque is moved to the new origin: τ' = R τ + p × R f.
    """
    force, torque = vector(message.force), vector(message.torque)
    if transform is not None:
        force, torque = rotated(transform.rotation, force), rotated(transform.rotation, torque)
        lever = cross(vector(transform.translation), force)
        torque = [a + b for a, b in zip(torque, lever)]
    return {"force": force, "torque": torque}


def state(joint_state, wrench_stamped, joints, *, sequence, start_s, now_s, max_age_s, transform=None):
    """Converts sensor_msgs/JointState and geometry_msgs/WrenchStamped to a state.

    `time_s` and the set-points of the controller count from `start_s`. Both messages must be within `max_age_s` of now.
    """
    for message in (joint_state, wrench_stamped):
        if message is None or abs(now_s - seconds(message.header.stamp)) > max_age_s:
            raise NotFresh(f"no joint state or wrench within {max_age_s} s of now")
    position = by_name(joint_state, "position", joints)
    if position is None:
        raise NotFresh(f"the joint state must have a position for each of {', '.join(joints)}")
    body = {
        "sequence": sequence,
        "time_s": seconds(joint_state.header.stamp) - start_s,
        "joint_position": position,
        "wrench": wrench(wrench_stamped.wrench, transform),
    }
    velocity = by_name(joint_state, "velocity", joints)
    return body if velocity is None else body | {"joint_velocity": velocity}


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


class Watchdog:
    """Computes the command of each period: the last answer while it is valid, then a ramp to rest.

    Each joint brakes at the answer's `braking_deceleration`. If the controller's limits include positions, it then stops
    inside its range. `acceleration`: deceleration for answers without one; None: such a joint stops at once.
    """

    def __init__(self, acceleration, period_s):
        self.acceleration, self.period_s = acceleration, period_s
        self.deceleration = acceleration
        self.velocity = [0.0] * len(acceleration)
        self.valid_until_s = float("-inf")

    def update(self, answer, measured_s):
        """Stores an answer to the state that was measured at `measured_s`."""
        self.velocity = answer["joint_velocity"]
        self.valid_until_s = measured_s + answer["valid_for_ms"] / 1e3
        given = answer.get("braking_deceleration") or self.acceleration
        self.deceleration = [own if a is None else a for a, own in zip(given, self.acceleration, strict=True)]

    def command(self, now_s):
        """Returns the joint velocities for this period, rad/s or m/s: those at its end, because the arm keeps them."""
        late_s = now_s + self.period_s - self.valid_until_s
        if late_s <= 1e-9:  # sums of periods are not exact
            return self.velocity
        speeds = [max(0.0, abs(v) - (inf if a is None else a) * late_s) for v, a in zip(self.velocity, self.deceleration)]
        return [copysign(speed, v) for speed, v in zip(speeds, self.velocity)]
