"""mink with the settings of its examples for arms."""

from __future__ import annotations

from pathlib import Path

import mink
import mujoco
import numpy as np

from behaviour import arm as model
from behaviour.controllers.base import ControllerError, Setting
from behaviour.families import PERIOD_S, Target
from behaviour.rotations import Array

DAMPING = 1e-3


class Mink:
    """Differential inverse kinematics on a MuJoCo model."""

    def __init__(self, urdf: Path, gain: float) -> None:
        """Loads the arm. `gain`: part of an error that is removed in one period."""
        spec = mujoco.MjSpec.from_file(str(urdf))
        spec.compiler.fusestatic = False
        # The URDF has no inertia, and kinematics needs none; MuJoCo refuses bodies without mass.
        spec.compiler.boundmass = spec.compiler.boundinertia = 1.0
        self._model = spec.compile()
        limits = model.load()
        self._configuration = mink.Configuration(self._model, q=model.HOME)
        self._frame = mink.FrameTask(
            model.TIP, "body", position_cost=1.0, orientation_cost=1.0, lm_damping=1.0, gain=gain
        )
        posture = mink.PostureTask(self._model, cost=1e-2, gain=gain)
        self._tasks = [self._frame, posture]
        for task in self._tasks:
            task.set_target_from_configuration(self._configuration)
        self._limits = [
            mink.ConfigurationLimit(self._model),
            mink.VelocityLimit(self._model, dict(zip(limits.names, limits.velocity, strict=True))),
        ]
        self._lower, self._upper = self._model.jnt_range.T

    def tool(self, position: Array) -> Array:
        """Returns the pose of the tool, 4 × 4, m."""
        self._configuration.update(position)
        return np.asarray(self._configuration.get_transform_frame_to_world(model.TIP, "body").as_matrix())

    def step(self, time_s: float, position: Array, new: Target | None) -> Array:  # noqa: ARG002
        """Returns the joint velocities, n, rad/s."""
        if new is not None:
            self._frame.set_target(mink.SE3.from_matrix(new.pose))
        self._configuration.update(np.clip(position, self._lower, self._upper))
        try:
            velocity = mink.solve_ik(
                self._configuration, self._tasks, PERIOD_S, "daqp", damping=DAMPING, limits=self._limits
            )
        except mink.MinkError as error:
            raise ControllerError(str(error)) from error
        return np.asarray(velocity)

    def close(self) -> None:
        """Does nothing."""


def make(urdf: Path, setting: Setting) -> Mink:
    """Loads mink."""
    return Mink(urdf, setting.gain())
