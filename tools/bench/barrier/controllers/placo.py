"""placo with the settings of its example of collisions, `kinematics/humanoid_collisions.py` of placo-examples."""

from __future__ import annotations

import json

import numpy as np
import placo
from behaviour.rotations import Array

from barrier.controllers.base import Answer, Task
from barrier.scenes import MIN_DISTANCE_M, OBSTACLE, PERIOD_S

TRIGGER = 3.0
"""Distance at which a pair is considered, as a multiple of the distance to keep; that of the example."""


class Placo:
    """Inverse kinematics by weighted tasks in one quadratic program."""

    def __init__(self, task: Task) -> None:
        """Loads the arm."""
        scene, urdf = task.scene, task.scene.urdf_file(task.folder / "placo")
        self._scene, self._part = scene, task.part()
        (urdf.parent / "collisions.json").write_text(json.dumps([[link, OBSTACLE] for link in scene.shapes]))
        self._lower, self._upper = scene.limits("lower"), scene.limits("upper")
        self._robot = placo.RobotWrapper(str(urdf))
        self._set(scene.home)
        self._solver = placo.KinematicsSolver(self._robot)
        self._solver.mask_fbase(True)
        self._solver.enable_joint_limits(True)
        self._solver.enable_velocity_limits(True)
        self._solver.dt = PERIOD_S
        if scene.has_orientation:
            self._frame = self._solver.add_frame_task(scene.tip, self._robot.get_T_world_frame(scene.tip))
            self._frame.configure("tool", "soft", 1.0, 1.0)
            # The weight is a hundredth of the regularization, so the posture moves at 1 % per period.
            posture = self._solver.add_joints_task()
            posture.set_joints(dict(zip(scene.names, scene.home, strict=True)))
            posture.configure("posture", "soft", 1e-6)
        else:
            self._frame = self._solver.add_position_task(scene.tip, np.zeros(3))
            self._frame.configure("tool", "soft", 1.0)
        self._solver.add_regularization_task(1e-4)
        avoid = self._solver.add_avoid_self_collisions_constraint()
        avoid.configure("avoid", "hard", 1.0)
        avoid.self_collisions_margin = MIN_DISTANCE_M
        avoid.self_collisions_trigger = TRIGGER * MIN_DISTANCE_M

    def _set(self, position: Array) -> None:
        """Sets the joints of the model."""
        for name, coordinate in zip(self._scene.names, position, strict=True):
            self._robot.set_joint(name, float(coordinate))
        self._robot.update_kinematics()

    def tool(self, position: Array) -> Array:
        """Returns the position of the tool, 3, m."""
        self._set(position)
        return np.asarray(self._robot.get_T_world_frame(self._scene.tip))[:3, 3]

    def step(self, position: Array, last: Array, target: Array) -> Answer:  # noqa: ARG002
        """Computes one period."""
        self._set(np.clip(position, self._lower, self._upper))
        # placo's tasks have no gain, so the target is a point on the way.
        tool = self._robot.get_T_world_frame(self._scene.tip)
        part = placo.interpolate_frames(tool, target, self._part)
        if self._scene.has_orientation:
            self._frame.T_world_frame = part
        else:
            self._frame.target_world = part[:3, 3]
        try:
            displacement = self._solver.solve(False)
        except RuntimeError as error:
            return Answer(None, str(error))
        return Answer(np.asarray(displacement[-len(position) :] / PERIOD_S))

    def close(self) -> None:
        """Does nothing."""


def make(task: Task) -> Placo:
    """Loads placo."""
    return Placo(task)
