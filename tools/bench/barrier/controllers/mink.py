"""mink with the settings of its examples for arms, `examples/arm_ur5e.py` and `examples/arm_aloha.py`."""

from __future__ import annotations

import mink
import mujoco
import numpy as np
from behaviour.rotations import Array

from barrier.controllers.base import Answer, Task
from barrier.referee import Capsule
from barrier.scenes import MIN_DISTANCE_M, OBSTACLE, PERIOD_S, Scene

DAMPING = 1e-3
DETECTION = 2.0
"""Distance at which a pair is considered, as a multiple of the distance to keep; that of the example `arm_aloha.py`."""


def load(scene: Scene) -> mujoco.MjModel:
    """Returns the arm with its shapes and the obstacle as geoms."""
    spec = mujoco.MjSpec.from_string(scene.source)
    spec.compiler.fusestatic = False
    # The description has no inertia, and kinematics needs none; MuJoCo refuses bodies without mass.
    spec.compiler.boundmass = spec.compiler.boundinertia = 1.0
    for link, shape in scene.shapes.items():
        add(spec.body(link), link, shape)
    add(spec.worldbody, OBSTACLE, scene.obstacle)
    return spec.compile()


def add(body: mujoco.MjsBody, name: str, shape: Capsule) -> None:
    """Adds a shape to a body."""
    if np.array_equal(shape.start, shape.end):
        size = [shape.radius, 0, 0]
        body.add_geom(name=name, type=mujoco.mjtGeom.mjGEOM_SPHERE, pos=shape.start, size=size)
        return
    size, ends = [shape.radius, 0, 0], [*shape.start, *shape.end]
    body.add_geom(name=name, type=mujoco.mjtGeom.mjGEOM_CAPSULE, fromto=ends, size=size)


class Mink:
    """Differential inverse kinematics on a MuJoCo model."""

    def __init__(self, task: Task) -> None:
        """Loads the arm."""
        scene = task.scene
        self._tip = scene.tip
        self._model = load(scene)
        self._configuration = mink.Configuration(self._model, q=scene.home)
        self._frame = mink.FrameTask(
            scene.tip,
            "body",
            position_cost=1.0,
            orientation_cost=1.0 if scene.has_orientation else 0.0,
            lm_damping=1.0,
            gain=task.part(),
        )
        self._tasks = [self._frame]
        if scene.has_orientation:
            posture = mink.PostureTask(self._model, cost=1e-2, gain=task.part())
            posture.set_target_from_configuration(self._configuration)
            self._tasks.append(posture)
        velocities = dict(zip(scene.names, scene.limits("velocity"), strict=True))
        self._limits = [
            mink.ConfigurationLimit(self._model),
            mink.VelocityLimit(self._model, velocities),
            mink.CollisionAvoidanceLimit(
                self._model,
                [(list(scene.shapes), [OBSTACLE])],
                minimum_distance_from_collisions=MIN_DISTANCE_M,
                collision_detection_distance=DETECTION * MIN_DISTANCE_M,
            ),
        ]
        self._lower, self._upper = self._model.jnt_range.T

    def tool(self, position: Array) -> Array:
        """Returns the position of the tool, 3, m."""
        self._configuration.update(position)
        return np.asarray(self._configuration.get_transform_frame_to_world(self._tip, "body").translation())

    def step(self, position: Array, last: Array, target: Array) -> Answer:  # noqa: ARG002
        """Computes one period."""
        self._frame.set_target(mink.SE3.from_matrix(target))
        self._configuration.update(np.clip(position, self._lower, self._upper))
        try:
            velocity = mink.solve_ik(
                self._configuration, self._tasks, PERIOD_S, "daqp", damping=DAMPING, limits=self._limits
            )
        except mink.MinkError as error:
            return Answer(None, str(error))
        return Answer(np.asarray(velocity))

    def close(self) -> None:
        """Does nothing."""


def make(task: Task) -> Mink:
    """Loads mink."""
    return Mink(task)
