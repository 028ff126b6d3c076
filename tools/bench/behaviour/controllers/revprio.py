"""revprio with its defaults; the drive of the joints and one gain are stated."""

from __future__ import annotations

import json
import os
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np
from revprio import (
    Client,
    ConstantProfile,
    ControllerConfig,
    ControllerTask,
    PoseLaw,
    PostureLaw,
    StepAnswer,
    StreamedPose,
    StreamedTarget,
)
from revprio.errors import RevprioError
from revprio.models import JointDrive, Orientation, TargetAhead

from behaviour import arm as model
from behaviour.controllers.base import ControllerError, Setting
from behaviour.families import GAIN, PERIOD_S, Target
from behaviour.plant import Condition
from behaviour.rotations import Array, from_quaternion, to_quaternion

URL = os.environ.get("REVPRIO_URL", "http://127.0.0.1:8080")
CHANGES = json.loads(os.environ.get("REVPRIO_CHANGES", "{}"))
"""Fields of the controller that differ from the defaults, for experiments."""
AXES = ["x", "y", "z", "rx", "ry", "rz"]
POSTURE_GAIN = 1.0
"""Gain of the posture, 1/s; that of the teleoperation example."""


def controller(drive: Condition, changes: dict[str, Any]) -> ControllerConfig:
    """Returns the controller: the tool follows streamed targets, and the joints stay near their start."""
    fields = {
        "robot": "panda",
        "period_s": PERIOD_S,
        "drive": JointDrive(lag_s=drive.lag_s, delay_periods=drive.delay_periods),
        "tasks": tasks(),
    }
    return ControllerConfig(**(fields | changes))


def tasks() -> list[ControllerTask]:
    """Returns the task of the tool and that of the posture below it."""
    posture = PostureLaw(gain=POSTURE_GAIN, target_position=ConstantProfile(value=list(model.HOME)))
    return [
        ControllerTask(name="tool", axes=AXES, law=PoseLaw(gain=GAIN)),
        ControllerTask(name="posture", law=posture),
    ]


class Revprio:
    """Strict reverse priority within the limits of position, velocity and acceleration."""

    def __init__(self, url: str, drive: Condition, changes: dict[str, Any]) -> None:
        """Opens a session. `changes`: fields of the controller that differ from the defaults."""
        self._exit = ExitStack()
        self._client = self._exit.enter_context(Client(url, timeout_s=60, step_timeout_s=60))
        config = controller(drive, changes)
        fields = {name: getattr(config, name) for name in config.model_fields_set}
        session = self._exit.enter_context(self._client.session(**fields))
        self._stream = self._exit.enter_context(session.stream())

    def tool(self, position: Array) -> Array:
        """Returns the pose of the tool, 4 × 4, m."""
        pose = self._client.kinematics(robot="panda", joint_position=position).pose
        turn = pose.orientation
        result = np.eye(4)
        result[:3, :3] = from_quaternion(turn.w, turn.x, turn.y, turn.z)
        result[:3, 3] = pose.position
        return result

    def _answer(self, time_s: float, position: Array, targets: dict[str, StreamedTarget] | None) -> StepAnswer:
        """Runs one period. This is the only place that knows how the program is reached."""
        return self._stream.step(position, time_s=time_s, targets=targets)

    def step(self, time_s: float, position: Array, new: Target | None) -> Array:
        """Returns the joint velocities, n, rad/s."""
        targets = None if new is None else {"tool": streamed(new)}
        try:
            answer = self._answer(time_s, position, targets)
        except RevprioError as error:
            raise ControllerError(str(error)) from error
        return np.asarray(answer.joint_velocity, dtype=float)

    def close(self) -> None:
        """Ends the session."""
        self._exit.close()


def streamed(target: Target) -> StreamedTarget:
    """Returns a target as a state carries it."""
    ahead = [TargetAhead(after_s=after_s, pose=streamed_pose(pose)) for after_s, pose in target.ahead]
    return StreamedTarget(time_s=target.measured_s, pose=streamed_pose(target.pose), ahead=ahead)


def streamed_pose(pose: Array) -> StreamedPose:
    """Returns a pose as a state carries it."""
    w, x, y, z = to_quaternion(pose[:3, :3])
    return StreamedPose(position=pose[:3, 3], orientation=Orientation(w=w, x=x, y=y, z=z))


def make(urdf: Path, setting: Setting) -> Revprio:
    """Opens a session; the program ships the same robot description."""
    del urdf
    return Revprio(URL, setting.drive(), CHANGES)
