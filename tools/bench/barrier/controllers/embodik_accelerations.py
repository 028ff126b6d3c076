"""EmbodiK's acceleration solver with the settings of its example, `examples/02_collision_aware_IK.py`."""

from __future__ import annotations

import math

import embodik
import numpy as np
from behaviour.rotations import Array

from barrier.controllers.base import Answer, Task
from barrier.controllers.embodik import GAIN, POSTURE_WEIGHT, configure, load
from barrier.plant import brake
from barrier.scenes import PERIOD_S, Scene

SUBSTEPS = 2
"""Places of a period that are validated; those of the example."""


def reference(dimension: int, gain: float) -> embodik.AccelerationTaskReference:
    """Returns a critically damped reference at rest."""
    result = embodik.AccelerationTaskReference()
    result.desired_velocity = result.desired_acceleration = np.zeros(dimension)
    result.proportional_gain, result.derivative_gain = gain, 2 * math.sqrt(gain)
    return result


class EmbodiKAccelerations:
    """Joint accelerations, with the collision rows of the velocity solver or with rows of its own."""

    def __init__(self, task: Task) -> None:
        """Loads the arm."""
        scene = task.scene
        self._scene = scene
        self._robot = load(task)
        self._solver = embodik.AccelerationSolver(self._robot)
        self._position = self._solver.add_frame_task("position", scene.tip, embodik.TaskType.FRAME_POSITION)
        self._tasks = [self._position]
        self._solver.set_task_reference("position", reference(3, GAIN))
        self._orientation = None
        if scene.has_orientation:
            self._orientation = self._solver.add_frame_task(
                "orientation", scene.tip, embodik.TaskType.FRAME_ORIENTATION
            )
            self._tasks.append(self._orientation)
            self._solver.set_task_reference("orientation", reference(3, GAIN))
            posture = self._solver.add_posture_task("posture", list(range(len(scene.home))))
            posture.priority, posture.weight = 1, POSTURE_WEIGHT
            posture.solve_mode = embodik.TaskSolveMode.MIN_ERROR
            posture.set_target_configuration(scene.home)
            self._solver.set_task_reference("posture", reference(len(scene.home), POSTURE_WEIGHT))
        for each in self._tasks:
            each.solve_mode = embodik.TaskSolveMode.SCALE
        self._options = embodik.AccelerationSolveOptions()
        self._options.acceleration_limits_override = scene.acceleration
        self._velocity = np.zeros(len(scene.home))
        """Joint velocities at the end of the last period, which this solver wants back, n."""
        self.avoid(scene)

    def avoid(self, scene: Scene) -> None:
        """Sets up the avoidance."""
        self._velocities = embodik.KinematicsSolver(self._robot)
        configure(self._velocities, scene)
        self._lift = embodik.VelocityCollisionLiftOptions()
        self._lift.validation_substeps = SUBSTEPS

    def solve(self, position: Array, velocity: Array) -> embodik.AccelerationSolverResult:
        """Computes the accelerations of one period."""
        return self._solver.solve_with_velocity_collision(
            self._velocities, position, velocity, PERIOD_S, self._options, self._lift
        )

    def tool(self, position: Array) -> Array:
        """Returns the position of the tool, 3, m."""
        self._robot.update_configuration(position)
        return np.asarray(self._robot.get_frame_pose(self._scene.tip).translation)

    def step(self, position: Array, last: Array, target: Array) -> Answer:
        """Computes one period."""
        self._position.set_target_position(target[:3, 3].copy())
        if self._orientation is not None:
            self._orientation.set_target_orientation(np.asfortranarray(target[:3, :3]))
        result = self.solve(position, self._velocity)
        if result.status != embodik.SolverStatus.SUCCESS:
            self._velocity = brake(last, self._scene.acceleration)
            return Answer(None, result.status.name)
        # Accelerations are constant in a period. A command is the mean velocity: the position is then the solver's.
        mean = (np.asarray(result.q_solution) - position) / PERIOD_S
        self._velocity = np.asarray(result.joint_velocities_next)
        return Answer(mean)

    def close(self) -> None:
        """Does nothing."""


def make(task: Task) -> EmbodiKAccelerations:
    """Loads EmbodiK."""
    return EmbodiKAccelerations(task)
