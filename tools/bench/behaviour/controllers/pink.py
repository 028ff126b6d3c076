"""pink with the settings of its Panda example."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pink
import pinocchio as pin
from pink.limits import AccelerationLimit
from pink.tasks import DampingTask, FrameTask, PostureTask

from behaviour import arm as model
from behaviour.controllers.base import ControllerError, Setting
from behaviour.families import PERIOD_S, Target
from behaviour.plant import brake
from behaviour.rotations import Array


class Pink:
    """Differential inverse kinematics by weighted tasks in one quadratic program."""

    def __init__(self, urdf: Path, gain: float, *, limit_acceleration: bool) -> None:
        """Loads the arm.

        `gain`: part of an error that is removed in one period.
        `limit_acceleration`: adds pink's `AccelerationLimit`, which its examples do not use.
        """
        self._model = pin.buildModelFromUrdf(str(urdf))
        self._configuration = pink.Configuration(self._model, self._model.createData(), model.HOME)
        self._frame = FrameTask(model.TIP, position_cost=1.0, orientation_cost=1.0, lm_damping=1.0, gain=gain)
        posture = PostureTask(cost=1e-3, gain=gain)
        self._tasks = [self._frame, posture, DampingTask(cost=1e-3)]
        for task in (self._frame, posture):
            task.set_target_from_configuration(self._configuration)
        self._last = np.zeros(self._model.nv)
        self._acceleration: AccelerationLimit | None = None
        self._limits = None
        if limit_acceleration:
            self._acceleration = AccelerationLimit(self._model, model.load().acceleration)
            self._limits = [self._model.configuration_limit, self._model.velocity_limit, self._acceleration]

    def tool(self, position: Array) -> Array:
        """Returns the pose of the tool, 4 × 4, m."""
        self._configuration.update(position)
        return np.asarray(self._configuration.get_transform_frame_to_world(model.TIP).np)

    def step(self, time_s: float, position: Array, new: Target | None) -> Array:  # noqa: ARG002
        """Returns the joint velocities, n, rad/s."""
        if new is not None:
            self._frame.set_target(pin.SE3(new.pose))
        # pink refuses positions outside the limits, so noise at a limit must not reach it.
        self._configuration.update(np.clip(position, self._model.lowerPositionLimit, self._model.upperPositionLimit))
        try:
            velocity = pink.solve_ik(self._configuration, self._tasks, PERIOD_S, solver="daqp", limits=self._limits)
        except pink.exceptions.PinkError as error:
            self._remember(brake(self._last))
            raise ControllerError(str(error)) from error
        self._remember(velocity)
        return np.asarray(velocity)

    def _remember(self, velocity: Array) -> None:
        """Keeps the command for the acceleration limit of the next period."""
        self._last = velocity
        if self._acceleration is not None:
            self._acceleration.set_last_integration(velocity, PERIOD_S)

    def close(self) -> None:
        """Does nothing."""


def make(urdf: Path, setting: Setting) -> Pink:
    """Loads pink with its default limits."""
    return Pink(urdf, setting.gain(), limit_acceleration=False)
