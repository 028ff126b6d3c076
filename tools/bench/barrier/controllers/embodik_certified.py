"""EmbodiK's acceleration solver with its certified rows, which it has for spheres on slides."""

from __future__ import annotations

import embodik
from behaviour.rotations import Array

from barrier.controllers.base import Task
from barrier.controllers.embodik_accelerations import EmbodiKAccelerations
from barrier.scenes import MIN_DISTANCE_M, PERIOD_S, Scene


class EmbodiKCertified(EmbodiKAccelerations):
    """Joint accelerations with a certificate of the path of each period."""

    def avoid(self, scene: Scene) -> None:  # noqa: ARG002
        """Sets up the avoidance."""
        definition = embodik.CollisionConstraintDefinition()
        definition.min_distance = MIN_DISTANCE_M
        policy = embodik.CollisionConstraintAccelerationPolicy()
        policy.outside_policy = embodik.CollisionConstraintOutsidePolicy.RECOVER_NON_WORSENING
        self._solver.configure_collision_constraint(definition, policy)

    def solve(self, position: Array, velocity: Array) -> embodik.AccelerationSolverResult:
        """Computes the accelerations of one period."""
        return self._solver.solve(position, velocity, PERIOD_S, self._options)


def make(task: Task) -> EmbodiKCertified:
    """Loads EmbodiK."""
    return EmbodiKCertified(task)
