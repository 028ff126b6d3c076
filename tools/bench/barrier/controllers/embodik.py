"""EmbodiK's velocity solver with the settings of its example and of its documentation.

The example is `examples/02_collision_aware_IK.py`. Number of rows, recovery floor and fallback are those that the page
`docs/collision_constraints.md` advises.
"""

from __future__ import annotations

import embodik
import numpy as np
from behaviour.rotations import Array

from barrier.controllers.base import Answer, Task
from barrier.scenes import MIN_DISTANCE_M, OBSTACLE, PERIOD_S, Scene

GAIN = 10.0
"""Gain of position and orientation, 1/s; that of the example."""
POSTURE_WEIGHT = 1e-2
STATUS = embodik.SolverStatus
MOVES = (STATUS.SUCCESS, STATUS.INFEASIBLE, STATUS.NUMERICAL_ERROR, STATUS.NO_PROGRESS, STATUS.COLLISION_VIOLATED)
"""Answers whose position the examples apply."""


def load(task: Task) -> embodik.RobotModel:
    """Returns the arm."""
    return embodik.RobotModel(str(task.scene.urdf_file(task.folder)))


def configure(solver: embodik.KinematicsSolver, scene: Scene) -> None:
    """Sets what the example sets, and the pairs with the obstacle."""
    runtime = solver.runtime_config()
    runtime.enable_auto_task_layout = runtime.weighted_fallback_enabled = True
    solver.configure_runtime(runtime)
    solver.dt = PERIOD_S
    solver.set_collision_tuning_mode(embodik.CollisionTuningMode.BALANCED)
    solver.configure_collision_constraint(
        min_distance=MIN_DISTANCE_M,
        include_pairs=[(f"{OBSTACLE}_0", f"{link}_0") for link in scene.shapes],
        exclude_pairs=[],
        max_constraints=5,
    )
    solver.set_non_worsening_collision_floor_enabled(True)


class EmbodiK:
    """Prioritized inverse kinematics with a collision constraint and a check of the step."""

    def __init__(self, task: Task) -> None:
        """Loads the arm."""
        scene = task.scene
        self._scene = scene
        self._robot = load(task)
        self._solver = embodik.KinematicsSolver(self._robot)
        configure(self._solver, scene)
        kind = embodik.TaskType.FRAME_POSE if scene.has_orientation else embodik.TaskType.FRAME_POSITION
        self._frame = self._solver.add_frame_task("tool", scene.tip, kind)
        self._frame.solve_mode = embodik.TaskSolveMode.SCALE
        self._frame.allow_min_error_fallback = True
        if scene.has_orientation:
            posture = self._solver.add_posture_task("posture")
            posture.solve_mode = embodik.TaskSolveMode.MIN_ERROR
            posture.weight = POSTURE_WEIGHT
            posture.set_target_configuration(scene.home)
        if task.limits_acceleration:
            self._solver.set_acceleration_limits(scene.acceleration)
        self._solver.enable_acceleration_limits(task.limits_acceleration)
        self._options = embodik.PositionStepOptions()
        self._options.position_gain = self._options.orientation_gain = GAIN
        self._options.max_steps = 1
        self._options.primary_allow_min_error_fallback = True

    def tool(self, position: Array) -> Array:
        """Returns the position of the tool, 3, m."""
        self._robot.update_configuration(position)
        return np.asarray(self._robot.get_frame_pose(self._scene.tip).translation)

    def step(self, position: Array, last: Array, target: Array) -> Answer:
        """Computes one period."""
        self._solver.set_previous_joint_velocities(last)
        result = self._solver.solve_position_step(position, np.asfortranarray(target), "tool", self._options)
        refusal = None if result.status == embodik.SolverStatus.SUCCESS else result.status.name
        if result.status not in MOVES:
            return Answer(None, refusal)
        return Answer((np.asarray(result.q_solution) - position) / PERIOD_S, refusal)

    def close(self) -> None:
        """Does nothing."""


def make(task: Task) -> EmbodiK:
    """Loads EmbodiK."""
    return EmbodiK(task)
