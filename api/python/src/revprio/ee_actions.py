"""Kinematics and end-effector actions with the names and units of LeRobot: degrees and 4 × 4 matrices.

`revprio.lerobot` has them for users.
"""

from __future__ import annotations

import itertools
import math
import re
import weakref
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np
from numpy.typing import ArrayLike, NDArray

from revprio.connection import LOCAL
from revprio.models import Damping, ExplicitLimits, ResolveTask, StatedLimits

Array = NDArray[np.float64]

SPEED_RAD_S = 6.0
"""Speed limit of joints whose file states none, rad/s; the inverse kinematics does not use it."""

STEPS = 50
"""Largest number of steps of the inverse kinematics."""

TRUST_RAD = 0.3
"""Largest motion of a joint in a step, rad: farther, the Jacobian is another one."""

ARRIVED_RAD = 1e-7
"""A step below this ends the iteration, rad."""

ROTATION_ERROR = 1e-3
"""Largest error of an entry of R Rᵀ for a rotation matrix R: poses may be rounded."""

LARGEST = 1e6
"""Errors of the position count as at most this, m; an action with a larger number holds the last one, m or rad."""

_numbers = itertools.count()


class RobotKinematics:
    """Forward and inverse kinematics of the chain from the root of a URDF file to a frame, in degrees.

    Joints that are not in the chain, such as that of a gripper, keep their values.
    """

    def __init__(
        self,
        urdf_path: str,
        target_frame_name: str = "gripper_frame_link",
        joint_names: list[str] | None = None,
    ) -> None:
        """`joint_names`: the joints of all arrays, in their order; default: those of the chain, then the others."""
        text = Path(urdf_path).read_text(encoding="utf-8")
        name = f"lerobot-{re.sub('[^A-Za-z0-9_.-]', '-', Path(urdf_path).stem)[:32]}-{next(_numbers)}"
        joints = _moving_joints(text)
        slow = {joint: StatedLimits(velocity=SPEED_RAD_S) for joint in _without_speed(text)}
        robot = LOCAL.register_robot(name=name, urdf=text, tip=target_frame_name, limits=slow or None)
        finalizer = weakref.finalize(self, LOCAL.delete_robot, robot.name)
        finalizer.atexit = False
        self.urdf_path, self.target_frame_name = str(urdf_path), target_frame_name
        self._robot = robot.name
        # The joints that move the frame, from the root on.
        self.chain = [joint.name for joint in robot.joints]
        self.joint_names = joint_names or [*self.chain, *(joint for joint in joints if joint not in self.chain)]
        _refuse_repeated("joint_names", self.joint_names)
        sliding = [joint for joint in self.chain if joints.get(joint) == "prismatic"]
        if sliding:
            message = f"{', '.join(sliding)} slides; positions are degrees, so joints that move the frame must turn"
            raise ValueError(message)
        missing = [joint for joint in self.chain if joint not in self.joint_names]
        if missing:
            message = f"`joint_names` lacks {', '.join(missing)}; give all joints that move `{target_frame_name}`"
            raise ValueError(message)
        unlimited = np.array([-np.inf, np.inf])
        ranges = [unlimited if joint.position_limit is None else joint.position_limit for joint in robot.joints]
        self._ranges = np.array(ranges)

    def forward_kinematics(self, joint_pos_deg: ArrayLike) -> Array:
        """Returns the pose of the frame in the root frame, 4 × 4, m, from joint positions in degrees."""
        return self._pose(self._radians(np.asarray(joint_pos_deg, dtype=float)))

    def inverse_kinematics(
        self,
        current_joint_pos: ArrayLike,
        desired_ee_pose: ArrayLike,
        position_weight: float = 1.0,
        orientation_weight: float = 0.01,
    ) -> Array:
        """Returns joint positions in degrees that reach a pose (4 × 4, m), or come near to it.

        The iteration goes downhill from where it starts. From far away it may end where every small motion leads away
        from the pose: compare `forward_kinematics` of the result with the pose.

        `current_joint_pos`: where the iteration starts, degrees; more entries than joints, such as a gripper, keep
        their values. The weights weigh metres against radians as in LeRobot. Numbers that are not finite change
        nothing. Raises `ValueError` for a pose whose rotation is none, and for weights below 0.
        """
        current, desired = np.asarray(current_joint_pos, dtype=float), np.asarray(desired_ee_pose, dtype=float)
        result = current.copy()
        if not (np.isfinite(desired).all() and np.isfinite(current).all()):
            return result
        rotation = desired[:3, :3]
        if np.abs(rotation @ rotation.T - np.eye(3)).max() > ROTATION_ERROR or np.linalg.det(rotation) < 0:
            raise ValueError("desired_ee_pose has no rotation matrix in its first three rows and columns")
        if not (position_weight >= 0 and orientation_weight >= 0):
            message = f"give weights of at least 0, not {position_weight!r} and {orientation_weight!r}"
            raise ValueError(message)
        q = np.clip(self._radians(current), self._ranges[:, 0], self._ranges[:, 1])
        weights = np.sqrt([position_weight] * 3 + [orientation_weight] * 3)
        for _ in range(STEPS):
            step = self._step(q, desired, weights)
            q = q + step
            if np.abs(step).max() < ARRIVED_RAD:
                break
        for joint, value in zip(self.chain, np.rad2deg(q), strict=True):
            result[self.joint_names.index(joint)] = value
        return result

    def _step(self, q: Array, desired: Array, weights: Array) -> Array:
        """Returns one step of the weighted least-squares problem within the ranges, rad."""
        answer = LOCAL.kinematics(robot=self._robot, joint_position=q)
        pose = _matrix(answer.pose)
        distance = desired[:3, 3] - pose[:3, 3]
        distance *= LARGEST / max(LARGEST, np.abs(distance).max())
        error = np.concatenate([distance, _rotation_vector(desired[:3, :3] @ pose[:3, :3].T)])
        rows = [k for k in range(6) if weights[k] > 0]
        task = ResolveTask(
            jacobian=(weights[:, np.newaxis] * np.asarray(answer.jacobian))[rows], velocity=(weights * error)[rows]
        )
        lower = np.maximum(self._ranges[:, 0] - q, -TRUST_RAD)
        upper = np.minimum(self._ranges[:, 1] - q, TRUST_RAD)
        box = ExplicitLimits(lower=np.minimum(lower, 0.0), upper=np.maximum(upper, 0.0))
        damping = Damping(threshold=0.02, max_factor=0.02)
        resolved = LOCAL.resolve(tasks=[task], limits=box, damping=damping)
        return np.asarray(resolved.joint_velocity)

    def _pose(self, q: Array) -> Array:
        return _matrix(LOCAL.kinematics(robot=self._robot, joint_position=q).pose)

    def _radians(self, degrees: Array) -> Array:
        """Returns the positions of the chain, rad."""
        return np.deg2rad([degrees[self.joint_names.index(joint)] for joint in self.chain])


@dataclass
class EEToJoints:
    """Turns end-effector actions into joint actions, as LeRobot's `InverseKinematicsEEToJoints`, and bounds them.

    An action has `ee.x` … `ee.z` (m), `ee.wx` … `ee.wz` (rotation vector, rad) and `ee.gripper_pos`; it becomes
    `NAME.pos` (degrees) of each motor. Motors with the names of the joints are those joints. With other names, the
    motors other than `gripper` are the joints that move the frame, in the order of `joint_names` of the kinematics;
    their numbers must be equal. Where a joint would move faster than allowed,
    all joints move by the same, smaller part of the way: the direction stays, and nothing is raised. The next actions
    make up for it. An action that lacks numbers, or has some that are not finite or beyond a million, holds the last
    joint action.

    In a pipeline of LeRobot, use `revprio.lerobot_step.EEToJointsStep`.
    """

    kinematics: RobotKinematics
    motor_names: list[str]
    period_s: float = 1 / 30
    max_speed_deg_s: float | Mapping[str, float] = 120.0
    """Largest speed of each joint, degrees per second."""
    max_gripper_speed: float = 200.0
    """Largest speed of the gripper, units per second."""
    last: dict[str, float] | None = field(default=None, init=False)
    scale: float = field(default=1.0, init=False)
    """Part of the way that the last action was allowed to go, 0 to 1."""

    def __post_init__(self) -> None:
        """Raises `ValueError` for a period or speed that is no positive number, and if motors and joints do not match.

        NaN would bound nothing.
        """
        _refuse_repeated("motor_names", self.motor_names)
        missing = [joint for joint in self.kinematics.chain if joint not in self.motor_names]
        if 0 < len(missing) < len(self.kinematics.chain):
            raise ValueError(f"motor_names has some joints of the kinematics, but not {', '.join(missing)}")
        arm = self._arm()
        if missing and len(arm) != len(self.kinematics.chain):
            message = (
                f"motor_names has {len(arm)} motors other than `gripper`, but {len(self.kinematics.chain)} joints move "
                f"the frame; name the motors as these joints: {', '.join(self.kinematics.chain)}"
            )
            raise ValueError(message)
        speeds = {"max_speed_deg_s": self.max_speed_deg_s}
        if isinstance(self.max_speed_deg_s, Mapping):
            speeds = {f"max_speed_deg_s of {name}": self._speed(name) for name in self._arm()}
        for name, value in {"period_s": self.period_s, "max_gripper_speed": self.max_gripper_speed, **speeds}.items():
            if not 0 < _number(value) < math.inf:
                raise ValueError(f"{name} must be a positive number, not {value!r}")

    def process(self, action: Mapping[str, Any], observation: Mapping[str, Any]) -> dict[str, Any]:
        """Returns the joint action; `observation`: `NAME.pos` of each motor, the start of the first action.

        Raises `ValueError` if the observation of the first action lacks a position: nothing else says where the arm is.
        """
        kept = {key: value for key, value in action.items() if not key.startswith("ee.")}
        if self.last is None:
            self.last = {name: _observed(observation, name) for name in self.motor_names}
        wanted = self._wanted(action, self.last)
        self._move_towards(wanted)
        return {**kept, **{f"{name}.pos": self.last[name] for name in self.motor_names}}

    def reset(self) -> None:
        """Starts the next action from its observation."""
        self.last, self.scale = None, 1.0

    def _motors(self) -> dict[str, str]:
        """Returns the motor of each joint that moves the frame."""
        chain = [joint for joint in self.kinematics.joint_names if joint in self.kinematics.chain]
        if set(chain) <= set(self.motor_names):
            return {joint: joint for joint in chain}
        return dict(zip(chain, self._arm(), strict=True))

    def _wanted(self, action: Mapping[str, Any], last: Mapping[str, float]) -> dict[str, float]:
        names = ("ee.x", "ee.y", "ee.z", "ee.wx", "ee.wy", "ee.wz")
        numbers = [_number(action.get(name)) for name in names]
        wanted = dict(last)
        if all(abs(number) <= LARGEST for number in numbers):
            pose = np.eye(4)
            pose[:3, :3], pose[:3, 3] = _rotation(numbers[3:]), numbers[:3]
            motors, joints = self._motors(), self.kinematics.joint_names
            current = [last[motors[joint]] if joint in motors else 0.0 for joint in joints]
            solution = self.kinematics.inverse_kinematics(current, pose)
            found = dict(zip(joints, solution.tolist(), strict=True))
            wanted |= {motor: found[joint] for joint, motor in motors.items()}
        gripper = _number(action.get("ee.gripper_pos"))
        if "gripper" in wanted and math.isfinite(gripper):
            wanted["gripper"] = gripper
        return wanted

    def _move_towards(self, wanted: Mapping[str, float]) -> None:
        last = self.last or {}
        arm = self._arm()
        shares = [self._most(name) / abs(wanted[name] - last[name]) for name in arm if wanted[name] != last[name]]
        self.scale = min([1.0, *shares])
        moved = {name: last[name] + self.scale * (wanted[name] - last[name]) for name in arm}
        if "gripper" in wanted:
            most = self.max_gripper_speed * self.period_s
            moved["gripper"] = last["gripper"] + min(max(wanted["gripper"] - last["gripper"], -most), most)
        self.last = {name: moved[name] for name in self.motor_names}

    def _arm(self) -> list[str]:
        return [name for name in self.motor_names if name != "gripper"]

    def _most(self, name: str) -> float:
        return self.period_s * self._speed(name)

    def _speed(self, name: str) -> float:
        """Returns the largest speed of a motor, degrees per second; NaN: none is given."""
        speed = self.max_speed_deg_s
        return speed.get(name, math.nan) if isinstance(speed, Mapping) else speed


def _observed(observation: Mapping[str, Any], name: str) -> float:
    """Returns the observed position of a motor, degrees or units of the gripper."""
    position = _number(observation.get(f"{name}.pos"))
    if not math.isfinite(position):
        raise ValueError(
            f"the first action needs where the arm is, but its observation has no number {name}.pos; pass the "
            "observation of the robot with the action"
        )
    return position


def _number(value: object) -> float:
    try:
        return float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError, OverflowError):
        return math.nan


def _refuse_repeated(argument: str, names: Sequence[str]) -> None:
    repeated = sorted({name for name in names if names.count(name) > 1})
    if repeated:
        message = f"{argument} has {', '.join(repeated)} more than once"
        raise ValueError(message)


def _moving(urdf: str) -> list[ET.Element]:
    """Returns the joints that move by themselves."""
    return [
        joint
        for joint in ET.fromstring(urdf).iter("joint")
        if joint.get("type") in ("revolute", "continuous", "prismatic") and joint.find("mimic") is None
    ]


def _moving_joints(urdf: str) -> dict[str, str]:
    """Returns the names and types of the joints that move by themselves."""
    return {str(joint.get("name")): str(joint.get("type")) for joint in _moving(urdf)}


def _without_speed(urdf: str) -> list[str]:
    """Returns the joints that move by themselves and have no speed limit."""

    def has_speed(joint: ET.Element) -> bool:
        limit = joint.find("limit")
        return limit is not None and _number(limit.get("velocity")) > 0

    return [str(joint.get("name")) for joint in _moving(urdf) if not has_speed(joint)]


def _matrix(pose: Any) -> Array:  # noqa: ANN401
    """Returns a pose as a 4 × 4 matrix, m."""
    q = pose.orientation
    matrix = np.eye(4)
    x, y, z, w = q.x, q.y, q.z, q.w
    matrix[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    matrix[:3, 3] = pose.position
    return matrix


def _rotation_vector(rotation: Array) -> Array:
    """Returns the rotation vector of a rotation matrix, rad, by its quaternion."""
    w = math.sqrt(max(0.0, 1.0 + rotation.trace())) / 2
    axis = np.array([rotation[2, 1] - rotation[1, 2], rotation[0, 2] - rotation[2, 0], rotation[1, 0] - rotation[0, 1]])
    sine = float(np.linalg.norm(axis)) / 2
    if sine > 1e-9:  # noqa: PLR2004
        return axis / (2 * sine) * math.atan2(sine, (rotation.trace() - 1) / 2)
    if w > 0.5:  # noqa: PLR2004
        return axis / 2
    # Half a turn: the axis is a column of (R + 1)/2.
    outer = (rotation + np.eye(3)) / 2
    column = outer[:, int(np.argmax(outer.diagonal()))]
    return math.pi * column / float(np.linalg.norm(column))


def _rotation(vector: Sequence[float]) -> Array:
    """Returns the rotation matrix of a rotation vector, rad."""
    angle = float(np.linalg.norm(vector))
    if angle < 1e-12:  # noqa: PLR2004
        return np.eye(3)
    x, y, z = np.asarray(vector) / angle
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    rotation: Array = np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * (cross @ cross)
    return rotation
