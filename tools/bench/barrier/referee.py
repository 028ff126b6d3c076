"""Kinematics and distances in NumPy, which measure all programs alike and share no code with any of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from behaviour.rotations import Array


@dataclass(frozen=True)
class Joint:
    """One joint of a serial chain."""

    name: str
    child: str
    """Link that the joint moves."""
    kind: str
    """`revolute`, `prismatic` or `fixed`."""
    origin: Array
    """Pose in the frame of the parent link, 4 × 4, m."""
    axis: Array
    """Unit vector in the frame of the joint, 3."""

    @property
    def is_moving(self) -> bool:
        """Whether it has a coordinate."""
        return self.kind != "fixed"

    def motion(self, coordinate: float) -> Array:
        """Returns the pose of the child link in the frame of the joint, 4 × 4, m."""
        pose = np.eye(4)
        if self.kind == "prismatic":
            pose[:3, 3] = coordinate * self.axis
        else:
            x, y, z = self.axis
            cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
            pose[:3, :3] += np.sin(coordinate) * cross + (1 - np.cos(coordinate)) * cross @ cross
        return pose


@dataclass(frozen=True)
class Capsule:
    """All points within a radius of a segment; a sphere if both ends are the same."""

    start: Array
    """One end, 3, m, in the frame of its link."""
    end: Array
    """The other end, 3, m."""
    radius: float
    """Radius, m."""

    def moved(self, pose: Array) -> Capsule:
        """Returns the same capsule in the frame that contains `pose`."""
        start, end = (pose[:3, :3] @ point + pose[:3, 3] for point in (self.start, self.end))
        return Capsule(start, end, self.radius)


def link_poses(joints: tuple[Joint, ...], position: Array) -> dict[str, Array]:
    """Returns the pose of each link below the base, 4 × 4, m."""
    coordinates = iter(position)
    poses: dict[str, Array] = {}
    pose = np.eye(4)
    for joint in joints:
        pose = pose @ joint.origin
        if joint.is_moving:
            pose = pose @ joint.motion(next(coordinates))
        poses[joint.child] = pose
    return poses


def distance(first: Capsule, second: Capsule) -> float:
    """Returns the distance of two capsules, m; negative if they intersect.

    The squared distance of two points s and t along the segments is convex. Its minimum on the square 0 ≤ s, t ≤ 1 is
    the stationary point if that is inside, and on one of the four edges otherwise.
    """
    along, across = first.end - first.start, second.end - second.start
    between = first.start - second.start
    uu, vv, uv = along @ along, across @ across, along @ across
    ub, vb = along @ between, across @ between

    def s_of(t: float) -> float:
        return float(np.clip((t * uv - ub) / uu, 0, 1)) if uu > 0 else 0.0

    def t_of(s: float) -> float:
        return float(np.clip((s * uv + vb) / vv, 0, 1)) if vv > 0 else 0.0

    places = [(0.0, t_of(0.0)), (1.0, t_of(1.0)), (s_of(0.0), 0.0), (s_of(1.0), 1.0)]
    determinant = uu * vv - uv * uv
    if determinant > 0:
        s, t = (uv * vb - vv * ub) / determinant, (uu * vb - uv * ub) / determinant
        if 0 <= s <= 1 and 0 <= t <= 1:
            places.append((s, t))
    least = min(float(np.linalg.norm(between + s * along - t * across)) for s, t in places)
    return least - first.radius - second.radius
