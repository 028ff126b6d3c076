"""RoboPlan's solver Oink with the settings of its example, `roboplan_examples/python/example_oink.py`."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from roboplan.core import CartesianConfiguration, Scene, loadUrdfSceneDescriptionFromXml
from roboplan.filters import SE3LowPassFilter
from roboplan.optimal_ik import (
    AccelerationLimit,
    ConfigurationTask,
    ConfigurationTaskOptions,
    FrameTask,
    FrameTaskOptions,
    Oink,
    PositionLimit,
    VelocityLimit,
)

from behaviour import arm as model
from behaviour.controllers.base import ControllerError, Setting
from behaviour.families import PERIOD_S, Target
from behaviour.plant import brake
from behaviour.rotations import Array

BASE = "panda_link0"
REGULARIZATION = 1e-6
POSTURE_WEIGHT, POSTURE_GAIN = 0.05, 0.1
FILTER_S = 0.1
"""Time constant of the filter of the targets, s."""


class RoboPlan:
    """Inverse kinematics by weighted tasks in one quadratic program."""

    def __init__(self, urdf: Path, gain: float, *, filter_s: float, limit_acceleration: bool) -> None:
        """Loads the arm.

        `gain`: part of an error that is removed in one period.
        `filter_s`: time constant of the filter of the targets, s; 0: none.
        `limit_acceleration`: adds RoboPlan's `AccelerationLimit`, which the example does not use.
        """
        limits = model.load()
        self._lower, self._upper = limits.lower, limits.upper
        self._scene = Scene("panda", loadUrdfSceneDescriptionFromXml(urdf.read_text()))
        self._scene.setJointPositions(model.HOME)
        self._oink = Oink(self._scene)
        goal = CartesianConfiguration()
        goal.base_frame, goal.tip_frame = BASE, model.TIP
        options = FrameTaskOptions(position_cost=1.0, orientation_cost=0.1, task_gain=gain, lm_damping=0.01)
        self._frame = FrameTask(self._oink, self._scene, goal, options)
        weights = np.full(len(model.HOME), POSTURE_WEIGHT)
        lower = ConfigurationTaskOptions(task_gain=POSTURE_GAIN * gain, lm_damping=0.0)
        self._tasks = [self._frame, ConfigurationTask(self._oink, model.HOME, weights, lower)]
        self._limits = [PositionLimit(self._oink, gain=1.0), VelocityLimit(self._oink, PERIOD_S, limits.velocity)]
        self._acceleration: AccelerationLimit | None = None
        if limit_acceleration:
            self._acceleration = AccelerationLimit(self._oink, PERIOD_S, limits.acceleration)
            self._limits.append(self._acceleration)
        self._filter = SE3LowPassFilter(tau=filter_s) if filter_s else None
        self._target = self.tool(model.HOME)
        if self._filter is not None:
            self._filter.reset(np.asfortranarray(self._target))
        self._displacement = np.zeros(len(model.HOME))
        self._last = np.zeros(len(model.HOME))

    def tool(self, position: Array) -> Array:
        """Returns the pose of the tool, 4 × 4, m."""
        return np.array(self._scene.forwardKinematics(position, model.TIP))

    def step(self, time_s: float, position: Array, new: Target | None) -> Array:  # noqa: ARG002
        """Returns the joint velocities, n, rad/s."""
        if new is not None:
            self._target = new.pose
        target = np.asfortranarray(self._target)
        if self._filter is not None:
            target = self._filter.update(target, PERIOD_S)
        self._scene.setJointPositions(np.clip(position, self._lower, self._upper))
        self._frame.setTargetFrameTransform(target)
        if self._acceleration is not None:
            self._acceleration.setLastVelocity(self._last)
        try:
            self._oink.solveIk(self._scene, self._tasks, self._limits, [], self._displacement, REGULARIZATION)
        except RuntimeError as error:
            self._last = brake(self._last)
            raise ControllerError(str(error)) from error
        self._last = self._displacement / PERIOD_S
        return self._last

    def close(self) -> None:
        """Does nothing."""


def make(urdf: Path, setting: Setting) -> RoboPlan:
    """Loads RoboPlan as its example does."""
    return RoboPlan(urdf, setting.gain(), filter_s=FILTER_S, limit_acceleration=False)
