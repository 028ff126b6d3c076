"""Wiping surfaces whose normal is not the pressing direction: tilted planes and a cylinder."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import mujoco
import numpy as np
import revprio

from contact_mujoco import pressing, scene
from contact_mujoco.arm import Arm
from contact_mujoco.conditions import Conditions
from contact_mujoco.pressing import Rig, Trace, Wall
from contact_mujoco.robots import DOWN, PANDA, Array
from contact_mujoco.tables import table, terms

RADIUS_M = 0.3
"""Radius of the cylinder, m. Its axis is y."""
STROKE_M = 0.1
SPEED = 0.05
"""Way along x and back, m, and largest speed along it, m/s."""
TARGET_N = 20.0
CYCLE_S = np.pi * STROKE_M / SPEED
"""Time of the way to and fro, s."""
TILTS = (0, 10, 20, 30)
"""Tilts of the planes, degrees."""
SLIDING = (0.0, 0.2, 0.5)
"""Coulomb friction µ of the surfaces."""
MAX_TILT_RAD = np.pi / 4
"""Largest tilt that the law estimates, rad: its default."""


@dataclass(frozen=True)
class Surface:
    """What is wiped, and what the controller knows of it."""

    sliding: float
    """Coulomb friction µ."""
    tilt_deg: float | None
    """Tilt of a plane that rises along x, degrees; `None`: the cylinder."""
    is_known: bool = False
    """Whether the axes of the tasks are those of the tilted plane; otherwise those of the base."""
    is_estimated: bool = False
    """Whether the law estimates the normal and turns the axes of the tasks with it."""

    @property
    def name(self) -> str:
        """Its name in tables."""
        return "cylinder" if self.tilt_deg is None else f"plane, {self.tilt_deg:.0f}°"

    @property
    def turn_rad(self) -> float:
        """Angle about −y that turns the axis z to the normal at the start, rad."""
        return float(np.radians(self.tilt_deg or 0.0))

    @property
    def frame(self) -> revprio.Pose:
        """Axes of the plane: x uphill, z along the normal."""
        half = 0.5 * self.turn_rad
        orientation = revprio.Orientation(w=np.cos(half), x=0, y=-np.sin(half), z=0)
        return revprio.Pose(position=[0, 0, 0], orientation=orientation)


class Wiping(Rig):
    """The tool presses downwards and moves along x and back."""

    def __init__(self, conditions: Conditions, surface: Surface) -> None:
        """Builds all."""
        self.surface = surface
        turn = surface.turn_rad
        self.outward = np.array([-np.sin(turn), 0.0, np.cos(turn)])
        super().__init__(conditions)

    def model(self) -> mujoco.MjModel:
        """Returns the model with the surface."""
        sliding = self.surface.sliding
        if self.surface.tilt_deg is not None:
            return scene.model(self.conditions.robot, scene.wall(np.zeros(3), self.outward, sliding))
        shape = f'type="cylinder" size="{RADIUS_M} 0.15" pos="0 0 {-RADIUS_M}" euler="1.5707963267948966 0 0"'
        geom = f'<geom name="surface" {shape} {scene.friction(sliding)} {scene.SURFACE}/>'
        return scene.model(self.conditions.robot, f'<body name="wall" mocap="true">{geom}</body>')

    def stand(self) -> Wall:
        """Returns the surface below the tool."""
        wall = Wall(self.arm, self.outward)
        wall.touch(self.conditions.stiffness, pressing.gap_m(self.conditions))
        return wall

    def tasks(self) -> list[revprio.ControllerTask]:
        """Returns the tasks of the preset `wipe`."""
        terms, told = self.conditions, self.conditions.told
        return revprio.wipe(
            "z",
            -terms.target,
            "x",
            stroke_m=STROKE_M,
            speed=SPEED,
            frame=self.surface.frame if self.surface.is_known else "base",
            approach_speed=terms.speed,
            period_s=terms.period_s,
            lag_s=told.lag_s,
            delay_periods=told.delay_periods,
            max_tilt_rad=MAX_TILT_RAD if self.surface.is_estimated else None,
        )

    def normal(self, arm: Arm) -> Array:
        """Returns the normal of the surface below the tool."""
        if self.surface.tilt_deg is not None:
            return self.outward
        way = arm.point - arm.data.mocap_pos[0] - RADIUS_M * DOWN
        way[1] = 0.0
        return np.asarray(way / np.linalg.norm(way))

    def forces(self, arm: Arm, wrenches: Array) -> Array:
        """Returns the force along the normal, N."""
        forces = wrenches[:, :3] @ -self.normal(arm)
        return np.where(forces > 1e-6, forces, 0.0)


def wipe(surface: Surface, stiffness: float = 1e4) -> tuple[Trace, Arm]:
    """Wipes for a second, and then to and fro once; returns the run, and the arm at its end."""
    conditions = terms(PANDA, stiffness, target=TARGET_N)
    hold_s = pressing.HOLD_S + 1.5 * conditions.travel_s
    rig = Wiping(conditions, surface)
    return pressing.press(rig, extra_s=1.0 + CYCLE_S - hold_s), rig.arm


def row(surface: Surface, trace: Trace) -> list[object]:
    """Returns what the normal force did on the last way to and fro: mean, least and most, and its error in per cent."""
    force = np.array(trace.force)[np.array(trace.time_s) > trace.time_s[-1] - CYCLE_S]
    losses = int(np.sum((force[:-1] > 0) & (force[1:] <= 0)))
    error = [100 * (value / TARGET_N - 1) for value in (force.min(), force.max())]
    axes = "estimated" if surface.is_estimated else "of the surface" if surface.is_known else "of the base"
    cells = [surface.name, surface.sliding, axes, f"{force.mean():.1f}", f"{force.min():.1f}, {force.max():.1f}"]
    return [*cells, f"{error[0]:+.0f}, {error[1]:+.0f}", losses, trace.fault or "–"]


def wiping() -> str:
    """Returns the table."""
    surfaces = [
        Surface(sliding, tilt, is_known=axes == "known", is_estimated=axes == "estimated")
        for tilt, sliding, axes in product((*TILTS, None), SLIDING, ("base", "known", "estimated"))
        if tilt is not None or axes != "known"
    ]
    rows = [row(surface, wipe(surface)[0]) for surface in surfaces]
    head = ["surface", "µ", "axes of the tasks", "mean, N", "least, most N", "error, %", "losses", "fault"]
    return table(head, rows)
