"""The arm: kinematics and limits of the URDF that all controllers load."""

from __future__ import annotations

import functools
import re
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from behaviour.rotations import Array, from_roll_pitch_yaw, turn_z

REPOSITORY = Path(__file__).resolve().parents[3]
SOURCE = REPOSITORY / "fixtures/robots/panda.urdf"
TIP = "panda_link8"
HOME = np.array([0.0, -np.pi / 4, 0.0, -3 * np.pi / 4, 0.0, np.pi / 2, np.pi / 4])
"""Posture at the start of each run, rad."""


@dataclass(frozen=True)
class Joint:
    """One joint of the chain; the axis of a moving joint is z."""

    name: str
    origin: Array
    """Pose in the frame of its parent, 4 × 4, m."""
    is_fixed: bool


@dataclass(frozen=True)
class Arm:
    """A chain of revolute joints with their limits."""

    joints: tuple[Joint, ...]
    lower: Array
    """Lower position limits, n, rad."""
    upper: Array
    """Upper position limits, n, rad."""
    velocity: Array
    """Speed limits V, n, rad/s."""
    acceleration: Array
    """Acceleration limits A, n, rad/s²."""

    @property
    def names(self) -> list[str]:
        """Names of the moving joints."""
        return [joint.name for joint in self.joints if not joint.is_fixed]

    def frames(self, position: Array) -> Array:
        """Returns the poses of base, joints and tool, (joints + 1) × 4 × 4, m."""
        angles = iter(position)
        poses = [np.eye(4)]
        for joint in self.joints:
            pose = poses[-1] @ joint.origin
            poses.append(pose if joint.is_fixed else pose @ turn_z(next(angles)))
        return np.array(poses)

    def tool(self, position: Array) -> Array:
        """Returns the pose of the tool, 4 × 4, m."""
        return np.asarray(self.frames(position)[-1])


def numbers(text: str) -> list[float]:
    """Returns the numbers of an attribute."""
    return [float(word) for word in text.split()]


@functools.cache
def load(path: Path = SOURCE) -> Arm:
    """Reads a URDF that lists its joints from base to tool and turns them about z."""
    joints: list[Joint] = []
    limits: list[list[float]] = []
    for element in ET.parse(path).getroot().findall("joint"):
        origin, axis, limit = (element.find(name) for name in ("origin", "axis", "limit"))
        pose = np.eye(4)
        if origin is not None:
            pose[:3, 3] = numbers(origin.get("xyz", "0 0 0"))
            pose[:3, :3] = from_roll_pitch_yaw(numbers(origin.get("rpy", "0 0 0")))
        is_fixed = element.get("type") == "fixed"
        joints.append(Joint(element.get("name", ""), pose, is_fixed))
        if is_fixed:
            continue
        if axis is None or limit is None or numbers(axis.get("xyz", "")) != [0, 0, 1]:
            raise ValueError(f"joint {element.get('name')} of {path} needs limits and the axis z")
        limits.append([float(limit.attrib[name]) for name in ("lower", "upper", "velocity", "acceleration")])
    return Arm(tuple(joints), *np.array(limits).T)


def urdf_for_peers(folder: Path) -> Path:
    """Writes the URDF without its version and the limits that came with it: older parsers do not know 1.2."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "panda.urdf"
    path.write_text(re.sub(r' (version="1\.2"|(acceleration|deceleration|jerk)="[^"]*")', "", SOURCE.read_text()))
    return path
