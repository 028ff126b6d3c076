"""EmbodiK's acceleration solver with the settings of its example `01_basic_ik_simple.py`, level *Acceleration*."""

from __future__ import annotations

import math
from pathlib import Path

import embodik
import numpy as np

from behaviour import arm as model
from behaviour.controllers.base import ControllerError, Setting
from behaviour.controllers.embodik import GAIN, POSTURE_WEIGHT
from behaviour.families import PERIOD_S, Target
from behaviour.plant import brake
from behaviour.rotations import Array


def reference(dimension: int, gain: float) -> embodik.AccelerationTaskReference:
    """Returns a critically damped reference at rest."""
    result = embodik.AccelerationTaskReference()
    result.desired_velocity = result.desired_acceleration = np.zeros(dimension)
    result.proportional_gain, result.derivative_gain = gain, 2 * math.sqrt(gain)
    return result


class EmbodiKAccelerations:
    """Joint accelerations from joint positions and velocities."""

    def __init__(self, urdf: Path) -> None:
        """Loads the arm."""
        limits = model.load()
        self._lower, self._upper = limits.lower, limits.upper
        self._robot = embodik.RobotModel(str(urdf))
        self._solver = embodik.AccelerationSolver(self._robot)
        self._position = self._solver.add_frame_task("position", model.TIP, embodik.TaskType.FRAME_POSITION)
        self._orientation = self._solver.add_frame_task("orientation", model.TIP, embodik.TaskType.FRAME_ORIENTATION)
        for task in (self._position, self._orientation):
            task.priority, task.weight = 0, 1.0
            task.solve_mode = embodik.TaskSolveMode.SCALE
        posture = self._solver.add_posture_task("posture")
        posture.priority, posture.weight = 1, POSTURE_WEIGHT
        posture.solve_mode = embodik.TaskSolveMode.MIN_ERROR
        posture.set_target_configuration(model.HOME)
        self._solver.set_task_reference("position", reference(3, GAIN))
        self._solver.set_task_reference("orientation", reference(3, GAIN))
        self._solver.set_task_reference("posture", reference(len(model.HOME), POSTURE_WEIGHT))
        self._options = embodik.AccelerationSolveOptions()
        self._options.acceleration_limits_override = limits.acceleration
        self._options.apply_velocity_limits = self._options.apply_position_limits = True
        self._target = self.tool(model.HOME)
        self._velocity = np.zeros_like(model.HOME)
        """Joint velocities at the end of the last period, which this solver wants back, n, rad/s."""
        self._last = np.zeros_like(model.HOME)

    def tool(self, position: Array) -> Array:
        """Returns the pose of the tool, 4 × 4, m."""
        self._robot.update_configuration(position)
        return np.asarray(self._robot.get_frame_pose(model.TIP).homogeneous())

    def step(self, time_s: float, position: Array, new: Target | None) -> Array:  # noqa: ARG002
        """Returns the joint velocities, n, rad/s."""
        if new is not None:
            self._target = new.pose
        self._position.set_target_position(self._target[:3, 3].copy())
        self._orientation.set_target_orientation(np.asfortranarray(self._target[:3, :3]))
        inside = np.clip(position, self._lower, self._upper)
        result = self._solver.solve(inside, self._velocity, PERIOD_S, self._options)
        if result.status != embodik.SolverStatus.SUCCESS:
            self._last = self._velocity = brake(self._last)
            raise ControllerError(result.status.name)
        self._velocity = np.asarray(result.joint_velocities_next)
        # Accelerations are constant in a period. A command is the mean velocity: the position is then the solver's.
        self._last = (np.asarray(result.q_solution) - inside) / PERIOD_S
        return self._last

    def close(self) -> None:
        """Does nothing."""


def make(urdf: Path, setting: Setting) -> EmbodiKAccelerations:
    """Loads EmbodiK."""
    del setting
    return EmbodiKAccelerations(urdf)
