"""ROS 2 messages to the bodies of revprio and back.

Nothing here needs ROS: whatever has the fields of the message will do, which is how the tests call it.
"""

from math import copysign, inf, isfinite

AXES = ("x", "y", "z")


class NotFresh(ValueError):
    """No state to send: a message is missing, late, or without what is needed."""


def seconds(stamp):
    """builtin_interfaces/Time in s."""
    return stamp.sec + 1e-9 * stamp.nanosec


def by_name(joint_state, field, joints):
    """A field of sensor_msgs/JointState as {name: value} for these joints alone; None where the message has no such values.

    Names come in any order, and with those of other joints, of a gripper say; a driver that does not measure a quantity
    leaves the field empty or fills it with NaN.
    """
    values = dict(zip(joint_state.name, getattr(joint_state, field)))
    chosen = {joint: values.get(joint, float("nan")) for joint in joints}
    return chosen if all(map(isfinite, chosen.values())) else None


def vector(xyz):
    """geometry_msgs/Vector3 as a list."""
    return [getattr(xyz, axis) for axis in AXES]


def rotated(q, v):
    """A vector (list) turned by a geometry_msgs/Quaternion of unit length: v + 2w (u × v) + 2u × (u × v)."""
    u = vector(q)
    once = cross(u, v)
    twice = cross(u, once)
    return [a + 2 * q.w * b + 2 * c for a, b, c in zip(v, once, twice)]


def cross(a, b):
    """a × b."""
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def wrench(message, transform=None):
    """geometry_msgs/Wrench as `wrench` of a state, N and N·m.

    `transform` (geometry_msgs/Transform) leads from the frame that the message is in to the one that the controller
    expects, as tf2's lookup_transform(target, source) gives it. The torque is moved to the new origin: τ' = R τ + p × R f.
    """
    force, torque = vector(message.force), vector(message.torque)
    if transform is not None:
        force, torque = rotated(transform.rotation, force), rotated(transform.rotation, torque)
        lever = cross(vector(transform.translation), force)
        torque = [a + b for a, b in zip(torque, lever)]
    return {"force": force, "torque": torque}


def state(joint_state, wrench_stamped, joints, *, sequence, start_s, now_s, max_age_s, transform=None):
    """sensor_msgs/JointState and geometry_msgs/WrenchStamped as a state.

    `time_s` counts from `start_s`, as the set-points of the controller do. Both messages must be younger than `max_age_s`.
    """
    for message in (joint_state, wrench_stamped):
        if message is None or abs(now_s - seconds(message.header.stamp)) > max_age_s:
            raise NotFresh(f"no joint state or wrench within {max_age_s} s of now")
    position = by_name(joint_state, "position", joints)
    if position is None:
        raise NotFresh(f"the joint state lacks a position of {', '.join(joints)}")
    body = {
        "sequence": sequence,
        "time_s": seconds(joint_state.header.stamp) - start_s,
        "joint_position": position,
        "wrench": wrench(wrench_stamped.wrench, transform),
    }
    velocity = by_name(joint_state, "velocity", joints)
    return body if velocity is None else body | {"joint_velocity": velocity}


def twist_problem(robot, joint_position, twist, period_s):
    """geometry_msgs/Twist of the tool, base axes, as a body of POST /v1/resolve: translation before rotation."""
    def task(name, axes, velocity):
        return {"name": name, "axes": axes, "velocity": vector(velocity)}

    tasks = [task("translation", ["x", "y", "z"], twist.linear), task("rotation", ["rx", "ry", "rz"], twist.angular)]
    damping = {"threshold": 0.05, "max_factor": 0.1}
    return {"robot": robot, "joint_position": joint_position, "tasks": tasks, "period_s": period_s, "damping": damping}


def in_order(velocity, joints, wanted):
    """Joint velocities of an answer, which follow `joints`, in the order of the controller that takes them."""
    speed = dict(zip(joints, velocity, strict=True))
    return [speed[joint] for joint in wanted]


def trajectory_point(position, velocity, period_s):
    """positions, velocities and time_from_start (sec, nanosec) of a JointTrajectoryPoint one period ahead."""
    sec, nanosec = divmod(round(1e9 * period_s), 10**9)
    return [q + period_s * v for q, v in zip(position, velocity, strict=True)], list(velocity), (sec, nanosec)


class Watchdog:
    """What the arm is told each period: the last answer while it is valid, then the way to rest at `acceleration`.

    A joint whose acceleration is None, as the service says where the robot's description has no limit, rests at once.
    """

    def __init__(self, acceleration, period_s):
        self.most = [inf if a is None else a * period_s for a in acceleration]
        self.velocity = [0.0] * len(acceleration)
        self.valid_until_s = float("-inf")

    def heard(self, answer, measured_s):
        """Takes an answer to the state that was measured at `measured_s`."""
        self.velocity = answer["joint_velocity"]
        self.valid_until_s = measured_s + answer["valid_for_ms"] / 1e3

    def command(self, now_s):
        """The velocity for this period, rad/s or m/s."""
        if now_s > self.valid_until_s:
            self.velocity = [copysign(max(0.0, abs(v) - most), v) for v, most in zip(self.velocity, self.most)]
        return self.velocity
