"""pink with the settings of its example of two arms, `examples/barriers/kukas_self_collision.py`."""

from __future__ import annotations

import numpy as np
import pink
import pinocchio as pin
from behaviour.rotations import Array
from pink.barriers import SelfCollisionBarrier
from pink.limits import AccelerationLimit
from pink.tasks import FrameTask, PostureTask

from barrier.controllers.base import Answer, Task
from barrier.scenes import MIN_DISTANCE_M, OBSTACLE, PERIOD_S


class Pink:
    """Differential inverse kinematics by weighted tasks and a barrier in one quadratic program."""

    def __init__(self, task: Task) -> None:
        """Loads the arm."""
        scene, urdf = task.scene, str(task.scene.urdf_file(task.folder))
        self._tip = scene.tip
        self._model = pin.buildModelFromUrdf(urdf)
        shapes = pin.buildGeomFromUrdf(self._model, urdf, pin.GeometryType.COLLISION)
        obstacle = shapes.getGeometryId(f"{OBSTACLE}_0")
        for link in scene.shapes:
            shapes.addCollisionPair(pin.CollisionPair(shapes.getGeometryId(f"{link}_0"), obstacle))
        self._configuration = pink.Configuration(
            self._model,
            self._model.createData(),
            scene.home,
            collision_model=shapes,
            collision_data=shapes.createData(),
        )
        # The example weighs position to orientation as 50 to 10.
        orientation_cost = 10.0 if scene.has_orientation else 0.0
        self._frame = FrameTask(scene.tip, position_cost=50.0, orientation_cost=orientation_cost, gain=task.part())
        posture = PostureTask(cost=1e-3, gain=task.part())
        self._tasks = [self._frame, posture] if scene.has_orientation else [self._frame]
        for each in self._tasks:
            each.set_target_from_configuration(self._configuration)
        self._barrier = SelfCollisionBarrier(
            n_collision_pairs=len(scene.shapes), gain=20.0, safe_displacement_gain=1.0, d_min=MIN_DISTANCE_M
        )
        self._limits = [self._model.configuration_limit, self._model.velocity_limit]
        self._acceleration: AccelerationLimit | None = None
        if task.limits_acceleration:
            self._acceleration = AccelerationLimit(self._model, scene.acceleration)
            self._limits.append(self._acceleration)

    def tool(self, position: Array) -> Array:
        """Returns the position of the tool, 3, m."""
        self._configuration.update(position)
        return np.asarray(self._configuration.get_transform_frame_to_world(self._tip).translation)

    def step(self, position: Array, last: Array, target: Array) -> Answer:
        """Computes one period."""
        self._frame.set_target(pin.SE3(target))
        self._configuration.update(np.clip(position, self._model.lowerPositionLimit, self._model.upperPositionLimit))
        if self._acceleration is not None:
            self._acceleration.set_last_integration(last, PERIOD_S)
        try:
            velocity = pink.solve_ik(
                self._configuration,
                self._tasks,
                PERIOD_S,
                solver="daqp",
                limits=self._limits,
                barriers=[self._barrier],
                safety_break=False,
            )
        except pink.exceptions.PinkError as error:
            return Answer(None, str(error))
        return Answer(np.asarray(velocity))

    def close(self) -> None:
        """Does nothing."""


def make(task: Task) -> Pink:
    """Loads pink."""
    return Pink(task)
