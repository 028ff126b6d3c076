"""RoboPlan's solver Oink with the settings of its example, `roboplan_examples/python/example_oink.py`."""

from __future__ import annotations

from itertools import combinations

import numpy as np
from behaviour.rotations import Array
from roboplan.core import CartesianConfiguration, Scene, loadUrdfSceneDescriptionFromXml
from roboplan.optimal_ik import (
    AccelerationLimit,
    ConfigurationTask,
    ConfigurationTaskOptions,
    FrameTask,
    FrameTaskOptions,
    Oink,
    PositionLimit,
    SelfCollisionBarrier,
    SelfCollisionBarrierOptions,
    VelocityLimit,
)

from barrier.controllers.base import Answer, Task
from barrier.scenes import MIN_DISTANCE_M, OBSTACLE, PERIOD_S

REGULARIZATION = 1e-3


class RoboPlan:
    """Inverse kinematics by tasks and barriers in one quadratic program, and a check of its answer."""

    def __init__(self, task: Task) -> None:
        """Loads the arm."""
        scene = task.scene
        self._tip = scene.tip
        self._scene = Scene(scene.name, loadUrdfSceneDescriptionFromXml(scene.urdf()))
        # Only the obstacle is avoided.
        self._scene.setCollisions(list(combinations(scene.shapes, 2)), False)
        self._scene.setCollisions([(OBSTACLE, link) for link in scene.shapes], True)
        self._scene.setJointPositions(scene.home)
        self._oink = Oink(self._scene)
        goal = CartesianConfiguration()
        goal.base_frame, goal.tip_frame = scene.base, scene.tip
        options = FrameTaskOptions(
            position_cost=1.0,
            orientation_cost=0.1 if scene.has_orientation else 0.0,
            task_gain=task.part(),
            lm_damping=0.01,
        )
        self._frame = FrameTask(self._oink, self._scene, goal, options)
        self._tasks = [self._frame]
        n = len(scene.home)
        if scene.has_orientation:
            lower = ConfigurationTaskOptions(task_gain=task.part(), lm_damping=0.0, priority=2)
            self._tasks.append(ConfigurationTask(self._oink, scene.home, np.full(n, 0.05), lower))
        self._constraints = [PositionLimit(self._oink, gain=1.0)]
        self._constraints.append(VelocityLimit(self._oink, PERIOD_S, scene.limits("velocity")))
        self._acceleration: AccelerationLimit | None = None
        if task.limits_acceleration:
            self._acceleration = AccelerationLimit(self._oink, PERIOD_S, scene.acceleration)
            self._constraints.append(self._acceleration)
        barrier = SelfCollisionBarrierOptions(
            n_collision_pairs=len(scene.shapes),
            gain=1.0,
            safe_displacement_gain=0.01,
            d_min=MIN_DISTANCE_M,
            d_max=0.25,
        )
        self._barriers = [SelfCollisionBarrier(self._oink, self._scene, PERIOD_S, barrier)]
        self._displacement = np.zeros(n)

    def tool(self, position: Array) -> Array:
        """Returns the position of the tool, 3, m."""
        return np.asarray(self._scene.forwardKinematics(position, self._tip))[:3, 3]

    def step(self, position: Array, last: Array, target: Array) -> Answer:
        """Computes one period."""
        self._scene.setJointPositions(position)
        self._frame.setTargetFrameTransform(np.asfortranarray(target))
        if self._acceleration is not None:
            self._acceleration.setLastVelocity(last)
        try:
            self._oink.solveIk(
                self._scene, self._tasks, self._constraints, self._barriers, self._displacement, REGULARIZATION
            )
            displacement = self._displacement.copy()
            self._oink.enforceBarriers(self._scene, self._barriers, displacement, tolerance=0.0)
        except RuntimeError as error:
            return Answer(None, str(error))
        return Answer(displacement / PERIOD_S)

    def close(self) -> None:
        """Does nothing."""


def make(task: Task) -> RoboPlan:
    """Loads RoboPlan."""
    return RoboPlan(task)
