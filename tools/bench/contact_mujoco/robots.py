"""The arms: kinematics and limits of the project's URDF files, with inertias."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from sawyer_mjcf import INERTIAL as SAWYER_INERTIAL
from sawyer_mjcf import posture as sawyer_posture

Array = NDArray[np.float64]

REPOSITORY = Path(__file__).resolve().parents[3]
ARMATURE = 0.1
"""Inertia of each motor behind its gear, kg·m²."""
LINK_RADIUS_M = 0.08
"""Radius of the links whose inertia is estimated here, m."""
PANDA_MASSES = (3.0, 3.0, 3.0, 3.0, 2.5, 1.5, 1.0)
"""Masses of the links of the Panda, kg: our own round numbers, 17 kg together. The manufacturer publishes none."""


@dataclass(frozen=True)
class Robot:
    """An arm."""

    name: str
    """Its name in revprio."""
    start: Array
    """Posture at the start of each run, rad."""

    @property
    def joints(self) -> list[ET.Element]:
        """The joints of its URDF file, from base to tool."""
        return ET.parse(REPOSITORY / f"crates/robot/robots/{self.name}.urdf").getroot().findall("joint")

    @property
    def acceleration_limits(self) -> Array:
        """Acceleration limits of the joints, n, rad/s²."""
        limits = [joint.find("limit") for joint in self.joints]
        return np.array([float(limit.attrib["acceleration"]) for limit in limits if limit is not None])

    def inertial(self, number: int, link: str, centre: Array) -> dict[str, str]:
        """Returns the attributes of MJCF for the inertia of a link; `centre`: middle between its joints, m.

        Those of the Sawyer are published by its manufacturer. A link of the Panda counts as a ball and a rod.
        """
        if self.name == "sawyer":
            mass, place, inertia = SAWYER_INERTIAL[link]
            return {"mass": f"{mass}", "pos": place, "fullinertia": inertia}
        weight = PANDA_MASSES[number]
        moment = weight * (0.4 * LINK_RADIUS_M**2 + float(centre @ centre) / 3)
        place = " ".join(map(str, centre))
        return {"mass": f"{weight}", "pos": place, "diaginertia": f"{moment} {moment} {moment}"}


PANDA = Robot("panda", np.array([0, -np.pi / 4, 0, -3 * np.pi / 4, 0, np.pi / 2, np.pi / 4]))
SAWYER = Robot("sawyer", sawyer_posture())
ROBOTS = (SAWYER, PANDA)
DOWN = np.array([0.0, 0.0, -1.0])
"""Direction in which the arms press. In these postures 100 N need 64 % of the torque of a joint at most."""
