"""revprio in this process, with its defaults; the drive of the joints, the distance and one gain are stated."""

from __future__ import annotations

from contextlib import ExitStack
from typing import Any

import numpy as np
import revprio
from behaviour.rotations import Array, to_quaternion
from revprio import Client, ConstantProfile, ControllerTask, Local, PoseLaw, PostureLaw, StreamedPose, StreamedTarget
from revprio.errors import RevprioError
from revprio.models import (
    Capsule,
    Collisions,
    JointDrive,
    LinkShape,
    Orientation,
    RoomObstacle,
    Sphere,
    StatedLimits,
)

from barrier import referee
from barrier.controllers.base import GAIN, Answer, Task
from barrier.scenes import MIN_DISTANCE_M, OBSTACLE, PERIOD_S, Scene

POSTURE_GAIN = 1.0
"""Gain of the posture, 1/s; that of the teleoperation example."""


def shape_of(shape: referee.Capsule) -> dict[str, Any]:
    """Returns the field of a shape: `sphere` or `capsule`."""
    if np.array_equal(shape.start, shape.end):
        return {"sphere": Sphere(center=list(shape.start), radius=shape.radius)}
    return {"capsule": Capsule(start=list(shape.start), end=list(shape.end), radius=shape.radius)}


def register(client: Client | Local, scene: Scene) -> str:
    """Registers the arm with its shapes and returns its name."""
    name = f"barrier-{scene.name}"
    if name not in [robot.name for robot in client.robots()]:
        limits = dict(zip(scene.names, scene.acceleration, strict=True))
        client.register_robot(
            name=name,
            urdf=scene.source,
            tip=scene.tip,
            limits={joint: StatedLimits(acceleration=limit) for joint, limit in limits.items()},
            shape_list=[LinkShape(link=link, **shape_of(shape)) for link, shape in scene.shapes.items()],
        )
    return name


def tasks(scene: Scene) -> list[ControllerTask]:
    """Returns the task of the tool, and that of the posture below it if there is one."""
    if not scene.has_orientation:
        return [ControllerTask(name="tool", axes=["x", "y"], law=PoseLaw(gain=GAIN))]
    posture = PostureLaw(gain=POSTURE_GAIN, target_position=ConstantProfile(value=list(scene.home)))
    return [
        ControllerTask(name="tool", axes=["x", "y", "z", "rx", "ry", "rz"], law=PoseLaw(gain=GAIN)),
        ControllerTask(name="posture", law=posture),
    ]


class Revprio:
    """Strict reverse priority within all limits, and commands whose stop is free."""

    def __init__(self, task: Task, client: Client | Local) -> None:
        """Starts a controller."""
        self._exit = ExitStack()
        self._client = client
        self._exit.callback(client.close)
        self._scene = task.scene
        self._robot = register(client, task.scene)
        obstacle = RoomObstacle(name=OBSTACLE, **shape_of(task.scene.obstacle))
        self._session = self._exit.enter_context(
            client.session(
                robot=self._robot,
                period_s=PERIOD_S,
                drive=JointDrive(lag_s=task.drive.lag_s, delay_periods=0),
                tasks=tasks(task.scene),
                limits="position_velocity_acceleration" if task.limits_acceleration else "position_velocity",
                collisions=Collisions(min_distance_m=MIN_DISTANCE_M, own_links=False, obstacles=[obstacle]),
            )
        )
        self._time_s = 0.0

    def tool(self, position: Array) -> Array:
        """Returns the position of the tool, 3, m."""
        return np.asarray(self._client.kinematics(robot=self._robot, joint_position=position).pose.position)

    def step(self, position: Array, last: Array, target: Array) -> Answer:  # noqa: ARG002
        """Computes one period."""
        w, x, y, z = to_quaternion(target[:3, :3])
        pose = StreamedPose(position=target[:3, 3], orientation=Orientation(w=w, x=x, y=y, z=z))
        targets = {"tool": StreamedTarget(time_s=self._time_s, pose=pose)}
        try:
            answer = self._session.step(position, time_s=self._time_s, targets=targets)
        except RevprioError as error:
            return Answer(None, str(error))
        self._time_s += PERIOD_S
        return Answer(np.asarray(answer.joint_velocity, dtype=float))

    def close(self) -> None:
        """Ends the session."""
        self._exit.close()


def make(task: Task) -> Revprio:
    """Starts a controller in this process."""
    return Revprio(task, revprio.connect())
