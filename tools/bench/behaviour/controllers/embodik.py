"""EmbodiK's velocity solver with the settings of its examples `01_basic_ik_simple.py` and `03_teleop_ik.py`.

The second example keeps them in `example_helpers/teleop_ik_backend.py` and `ik_common.py`.
"""

from __future__ import annotations

from pathlib import Path

import embodik
import numpy as np

from behaviour import arm as model
from behaviour.controllers.base import ControllerError, Setting
from behaviour.families import PERIOD_S, Target
from behaviour.plant import brake
from behaviour.rotations import Array

GAIN = 10.0
"""Gain of position and orientation, 1/s."""
POSTURE_WEIGHT = 1e-2
STATUS = embodik.SolverStatus
MOVES = (STATUS.SUCCESS, STATUS.INFEASIBLE, STATUS.NUMERICAL_ERROR, STATUS.NO_PROGRESS)
"""Answers whose position the examples apply."""


class EmbodiK:
    """Prioritized inverse kinematics: the task of the tool is scaled until it fits the limits."""

    def __init__(self, urdf: Path, *, limit_acceleration: bool) -> None:
        """Loads the arm.

        The step is fixed. The adaptive one of the examples moves farther than the speed limits allow in a period.
        `limit_acceleration`: sets the solver's acceleration limits, which the examples do not use.
        """
        limits = model.load()
        self._lower, self._upper = limits.lower, limits.upper
        self._robot = embodik.RobotModel(str(urdf))
        self._solver = embodik.KinematicsSolver(self._robot)
        self._solver.dt = PERIOD_S
        runtime = self._solver.runtime_config()
        runtime.enable_auto_task_layout = runtime.weighted_fallback_enabled = True
        self._solver.configure_runtime(runtime)
        frame = self._solver.add_frame_task("tool", model.TIP)
        frame.priority, frame.weight = 0, 1.0
        frame.solve_mode = embodik.TaskSolveMode.SCALE_ELASTIC
        posture = self._solver.add_posture_task("posture")
        posture.priority, posture.weight = 1, POSTURE_WEIGHT
        posture.solve_mode = embodik.TaskSolveMode.MIN_ERROR
        posture.set_target_configuration(model.HOME)
        if limit_acceleration:
            self._solver.set_acceleration_limits(limits.acceleration)
        self._solver.enable_acceleration_limits(limit_acceleration)
        self._options = embodik.PositionStepOptions()
        self._options.position_gain = self._options.orientation_gain = GAIN
        self._options.max_steps = 1
        self._target = self.tool(model.HOME)
        self._last = np.zeros_like(model.HOME)

    def tool(self, position: Array) -> Array:
        """Returns the pose of the tool, 4 × 4, m."""
        self._robot.update_configuration(position)
        return np.asarray(self._robot.get_frame_pose(model.TIP).homogeneous())

    def step(self, time_s: float, position: Array, new: Target | None) -> Array:  # noqa: ARG002
        """Returns the joint velocities, n, rad/s."""
        if new is not None:
            self._target = new.pose
        inside = np.clip(position, self._lower, self._upper)
        if self._solver.get_acceleration_limits_enabled():
            self._solver.set_previous_joint_velocities(self._last)
        result = self._solver.solve_position_step(inside, np.asfortranarray(self._target), "tool", self._options)
        if result.status not in MOVES:
            self._last = brake(self._last)
            raise ControllerError(result.status.name)
        self._last = (np.asarray(result.q_solution) - inside) / PERIOD_S
        return self._last

    def close(self) -> None:
        """Does nothing."""


def make(urdf: Path, setting: Setting) -> EmbodiK:
    """Loads EmbodiK."""
    del setting
    return EmbodiK(urdf, limit_acceleration=False)
