"""Rotations and poses."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def turn_z(angle: float) -> Array:
    """Returns the rotation about z as a pose, 4 × 4."""
    pose = np.eye(4)
    pose[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    return pose


def from_roll_pitch_yaw(angles: list[float]) -> Array:
    """Returns the rotation of URDF's `rpy`, 3 × 3."""
    (sr, sp, sy), (cr, cp, cy) = np.sin(angles), np.cos(angles)
    roll = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    pitch = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    yaw = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    return np.asarray(yaw @ pitch @ roll)


def rotation_vector(rotation: Array) -> Array:
    """Returns angle times axis of a rotation of less than π, 3, rad."""
    skew = np.array([rotation[2, 1] - rotation[1, 2], rotation[0, 2] - rotation[2, 0], rotation[1, 0] - rotation[0, 1]])
    sine = np.linalg.norm(skew) / 2
    angle = np.arctan2(sine, (np.trace(rotation) - 1) / 2)
    return np.asarray(skew / 2 * (angle / sine if sine > 1e-12 else 1.0))


def rotation_angle(rotation: Array) -> float:
    """Returns the angle of a rotation, 0 to π, rad; accurate for small angles."""
    return float(2 * np.arcsin(min(1.0, np.linalg.norm(rotation - np.eye(3)) / np.sqrt(8))))


def from_rotation_vector(vector: Array) -> Array:
    """Returns the rotation by angle times axis (Rodrigues), 3 × 3."""
    angle = float(np.linalg.norm(vector))
    if angle < 1e-12:
        return np.eye(3)
    x, y, z = vector / angle
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.asarray(np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross)


def from_quaternion(w: float, x: float, y: float, z: float) -> Array:
    """Returns the rotation of a unit quaternion, 3 × 3."""
    vector = np.array([x, y, z])
    sine = float(np.linalg.norm(vector))
    angle = 2 * np.arctan2(sine, w)
    return from_rotation_vector(vector * (angle / sine if sine > 1e-12 else 2.0))


def to_quaternion(rotation: Array) -> tuple[float, float, float, float]:
    """Returns the unit quaternion w, x, y, z of a rotation; exact for a half turn too."""
    # The largest diagonal entry of 4 q qᵀ is at least 1, so the division is safe.
    (a, b, c), (d, e, f), (g, h, i) = rotation
    products = np.array(
        [
            [1 + a + e + i, h - f, c - g, d - b],
            [h - f, 1 + a - e - i, b + d, c + g],
            [c - g, b + d, 1 - a + e - i, f + h],
            [d - b, c + g, f + h, 1 - a - e + i],
        ]
    )
    row = products[np.argmax(np.diag(products))]
    w, x, y, z = (row / np.linalg.norm(row)).tolist()
    return w, x, y, z
