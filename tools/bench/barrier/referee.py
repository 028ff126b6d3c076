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

    def motion(self, coordinate: Array) -> Array:
        """Returns the poses of the child link in the frame of the joint, … × 4 × 4, m, for coordinates of any shape."""
        pose = np.zeros((*coordinate.shape, 4, 4))
        pose[...] = np.eye(4)
        if self.kind == "prismatic":
            pose[..., :3, 3] = coordinate[..., None] * self.axis
        else:
            x, y, z = self.axis
            cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
            sine, versine = np.sin(coordinate)[..., None, None], (1 - np.cos(coordinate))[..., None, None]
            pose[..., :3, :3] += sine * cross + versine * (cross @ cross)
        return pose


@dataclass(frozen=True)
class Capsule:
    """All points within a radius of a segment; a sphere if both ends are the same."""

    start: Array
    """One end, 3, m, in the frame of its link; or many, … × 3, in the base frame."""
    end: Array
    """The other end, 3 or … × 3, m."""
    radius: float
    """Radius, m."""

    def moved(self, pose: Array) -> Capsule:
        """Returns the same capsule in the frame that contains `pose`, … × 4 × 4."""
        start, end = (pose[..., :3, :3] @ point + pose[..., :3, 3] for point in (self.start, self.end))
        return Capsule(start, end, self.radius)


def link_poses(joints: tuple[Joint, ...], position: Array) -> dict[str, Array]:
    """Returns the poses of each link below the base, … × 4 × 4, m. `position`: … × n."""
    number = 0
    poses: dict[str, Array] = {}
    pose = np.eye(4)
    for joint in joints:
        pose = pose @ joint.origin
        if joint.is_moving:
            pose = pose @ joint.motion(position[..., number])
            number += 1
        poses[joint.child] = pose
    return poses


def dot(first: Array, second: Array) -> Array:
    """Returns the products of vectors, …."""
    return np.asarray((first * second).sum(axis=-1))


def part(numerator: Array, denominator: Array) -> Array:
    """Returns a quotient in 0 … 1; 0 where the denominator is zero."""
    safe = np.where(denominator > 0, denominator, 1.0)
    return np.asarray(np.where(denominator > 0, np.clip(numerator / safe, 0, 1), 0.0))


def distance(first: Capsule, second: Capsule) -> Array:
    """Returns the distances of capsules, …, m; negative if they intersect.

    The squared distance of two points s and t along the segments is convex. Its minimum on the square 0 ≤ s, t ≤ 1 is
    the stationary point if that is inside, and on one of the four edges otherwise.
    """
    along, across = first.end - first.start, second.end - second.start
    between = first.start - second.start
    uu, vv, uv = dot(along, along), dot(across, across), dot(along, across)
    ub, vb = dot(along, between), dot(across, between)
    zero, one = np.zeros_like(uv), np.ones_like(uv)
    # At the clipped stationary point the distance is that of two points of the capsules too, so it is never too small.
    determinant = uu * vv - uv * uv
    inner = (part(uv * vb - vv * ub, determinant), part(uu * vb - uv * ub, determinant))
    edges = [(end, part(end * uv + vb, vv)) for end in (zero, one)] + [
        (part(end * uv - ub, uu), end) for end in (zero, one)
    ]
    gaps = [between + s[..., None] * along - t[..., None] * across for s, t in (inner, *edges)]
    least = np.min([np.linalg.norm(gap, axis=-1) for gap in gaps], axis=0)
    return np.asarray(least - first.radius - second.radius)
