"""Surfaces that yield in two directions: a plate on a spring tilts, or moves sideways."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import mujoco
import numpy as np
import revprio

from contact_mujoco import pressing, scene
from contact_mujoco.arm import Arm
from contact_mujoco.conditions import Conditions
from contact_mujoco.pressing import Rig, Wall
from contact_mujoco.robots import DOWN, PANDA, Array
from contact_mujoco.score import score
from contact_mujoco.tables import VERDICT, short, table, terms, verdict

LEVER_M = 0.1
"""Distance from the tool to the hinge of a plate that tilts, m."""
PLATE_CONTACT = 1e6
"""Stiffness between ball and plate, N/m."""
THICKNESS_M = 0.01
"""Half of the thickness of a plate, m."""


class Plate(Wall):
    """A plate on a spring below the tool."""

    @property
    def depth(self) -> float:
        """Not measured: 0."""
        return 0.0

    def __init__(self, arm: Arm) -> None:
        """Sets the stiffness between ball and plate, in a place in which they touch."""
        super().__init__(arm, -DOWN)
        place = arm.model.body("plate").pos
        start = place.copy()
        place[2] = arm.point[2] - scene.TOOL_RADIUS_M - THICKNESS_M + pressing.DEPTH_M
        scene.set_stiffness(arm.model, arm.data, arm.model.geom("surface").id, PLATE_CONTACT)
        place[:] = start
        mujoco.mj_forward(arm.model, arm.data)


@dataclass(frozen=True)
class Spring:
    """How a plate yields: it tilts, or it moves sideways while it goes down, by a spring of K at the tool."""

    tilts: bool
    mass_kg: float
    """Mass of the plate; for a tilting one at the lever, kg."""
    sliding: float
    """Friction between ball and plate."""

    def mjcf(self, stiffness: float, place: Array) -> str:
        """Returns the plate with its middle at a place; `stiffness`: K, N/m."""
        if self.tilts:
            joint = f'type="hinge" axis="0 1 0" pos="{-LEVER_M} 0 0"'
            spring, inertia = stiffness * LEVER_M**2, self.mass_kg * LEVER_M**2
        else:
            joint, spring, inertia = 'type="slide" axis="1 0 -1"', 0.5 * stiffness, self.mass_kg
        damping = 2 * PLATE_DAMPING * np.sqrt(spring * inertia)
        joint = f'<joint {joint} stiffness="{spring}" damping="{damping}"/>'
        contact = f'condim="3" friction="{self.sliding} 0 0" {scene.SURFACE}'
        geom = f'<geom name="surface" type="box" size="0.1 0.1 {THICKNESS_M}" mass="{self.mass_kg}" {contact}/>'
        return f'<body name="plate" pos="{scene.numbers(place)}" gravcomp="1">{joint}{geom}</body>'


PLATE_DAMPING = 0.05
"""Damping ratio of the plate on its spring."""


class Yielding(Rig):
    """The surface is a plate on a spring."""

    def __init__(self, conditions: Conditions, spring: Spring) -> None:
        """Builds all."""
        self._spring = spring
        super().__init__(conditions)

    def model(self) -> mujoco.MjModel:
        """Returns the model with the plate."""
        robot = self.conditions.robot
        pose = revprio.kinematics(robot=robot.name, joint_position=robot.start).pose
        below = scene.TOOL_RADIUS_M + THICKNESS_M + pressing.gap_m(self.conditions)
        place = np.asarray(pose.position) + below * DOWN
        return scene.model(robot, self._spring.mjcf(self.conditions.stiffness, place))

    def stand(self) -> Wall:
        """Returns the plate."""
        return Plate(self.arm)


def yielding() -> str:
    """Returns the table of surfaces that yield in two directions."""
    rows = []
    for tilts, mass, stiffness in product((True, False), (0.05, 0.5, 2.0), (1e3, 1e4, 1e5)):
        conditions = terms(PANDA, stiffness)
        found = score(conditions, pressing.press(Yielding(conditions, Spring(tilts, mass, 0.5))))
        rows.append(["tilts" if tilts else "moves sideways", mass, short(stiffness), *verdict(found)])
    return table(["surface", "mass, kg", "K, N/m", *VERDICT], rows)
