"""placo with the settings of its documentation for arms."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import placo

from behaviour import arm as model
from behaviour.controllers.base import ControllerError, Setting
from behaviour.families import PERIOD_S, Target
from behaviour.rotations import Array


class Placo:
    """Inverse kinematics by weighted tasks in one quadratic program."""

    def __init__(self, urdf: Path, gain: float) -> None:
        """Loads the arm. `gain`: part of an error that is removed in one period."""
        self._gain = gain
        limits = model.load()
        self._names, self._lower, self._upper = limits.names, limits.lower, limits.upper
        self._robot = placo.RobotWrapper(str(urdf), placo.Flags.ignore_collisions)
        self._set(model.HOME)
        self._solver = placo.KinematicsSolver(self._robot)
        self._solver.mask_fbase(True)
        self._solver.enable_joint_limits(True)
        self._solver.enable_velocity_limits(True)
        self._solver.dt = PERIOD_S
        self._target = self._robot.get_T_world_frame(model.TIP)
        self._frame = self._solver.add_frame_task(model.TIP, self._target)
        self._frame.configure("tool", "soft", 1.0, 1.0)
        self._solver.add_regularization_task(1e-4)
        # The weight is a hundredth of the regularization, so the posture moves at 1 % per period.
        posture = self._solver.add_joints_task()
        posture.set_joints(dict(zip(self._names, model.HOME, strict=True)))
        posture.configure("posture", "soft", 1e-6)

    def _set(self, position: Array) -> None:
        """Sets the joints of the model."""
        for name, angle in zip(self._names, position, strict=True):
            self._robot.set_joint(name, float(angle))
        self._robot.update_kinematics()

    def tool(self, position: Array) -> Array:
        """Returns the pose of the tool, 4 × 4, m."""
        self._set(position)
        return np.asarray(self._robot.get_T_world_frame(model.TIP))

    def step(self, time_s: float, position: Array, new: Target | None) -> Array:  # noqa: ARG002
        """Returns the joint velocities, n, rad/s."""
        if new is not None:
            self._target = new.pose
        self._set(np.clip(position, self._lower, self._upper))
        # placo's tasks have no gain, so the target is a point on the way.
        tool = self._robot.get_T_world_frame(model.TIP)
        self._frame.T_world_frame = placo.interpolate_frames(tool, self._target, self._gain)
        try:
            displacement = self._solver.solve(False)
        except RuntimeError as error:
            raise ControllerError(str(error)) from error
        return np.asarray(displacement[-len(self._names) :] / PERIOD_S)

    def close(self) -> None:
        """Does nothing."""


def make(urdf: Path, setting: Setting) -> Placo:
    """Loads placo."""
    return Placo(urdf, setting.gain())
