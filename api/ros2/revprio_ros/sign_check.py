"""A check of the sign of the wrench in contact.

An object that the tool presses on pushes back: as the tool moves into it, the force on the environment along the motion
grows. With the wrong sign it falls instead, as if the environment pulled the tool along, and a force law pushes harder
and harder. The check cannot tell this from a person who pushes the arm with a growing force.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from itertools import pairwise
from math import hypot
from types import SimpleNamespace
from typing import Any

import revprio

from revprio_ros.conversion import rotated

MIN_MOTION_M = 5e-5
"""Smallest motion whose direction is compared with the force, m."""


class SignCheck:
    """Compares motion and force of the tool over some periods."""

    def __init__(self, force_n: float, periods: int) -> None:
        """`force_n`: force from which a wrong sign is reported, N; `periods`: length of the comparison, periods."""
        self._force_n = force_n
        self._samples: deque[tuple[Sequence[float], Sequence[float]]] = deque(maxlen=periods + 1)

    def add(self, position: Sequence[float], force: Sequence[float]) -> str | None:
        """Adds a period; returns the finding if the sign is probably wrong.

        `position`: of the tool, m; `force`: on the environment, N; both along the axes of the base.
        """
        if hypot(*force) < 0.5 * self._force_n:
            self._samples.clear()
            return None
        self._samples.append((position, force))
        if len(self._samples) < self._samples.maxlen:
            return None
        start, end = self._samples[0][0], self._samples[-1][0]
        motion = [b - a for a, b in zip(start, end)]
        length = hypot(*motion)
        if length < MIN_MOTION_M:
            return None
        along = [sum(f * m for f, m in zip(force, motion)) / length for _, force in self._samples]
        falling = sum(b <= a for a, b in pairwise(along))  # A measurement can be repeated.
        is_wrong = along[-1] < -self._force_n and along[0] - along[-1] > 0.25 * self._force_n
        if not is_wrong or falling < 0.75 * (len(along) - 1):
            return None
        return (
            f"the wrench has probably the wrong sign: the tool moved {1e3 * length:.1f} mm, and its force on the "
            f"environment along this motion went from {along[0]:.0f} N to {along[-1]:.0f} N instead of growing; do the "
            "sign test, correct `wrench_convention`, and start the node again"
        )


class SignMonitor:
    """Runs the check with the pose of the tool, in a thread."""

    def __init__(self, client: Any, config: revprio.ControllerConfig, force_n: float, periods: int) -> None:
        """`client`: computes the pose; `force_n`: 0 switches the check off."""
        self._client, self._robot = client, config.robot
        self._sign = -1.0 if config.wrench_convention == "on_tool" else 1.0
        self._in_tool_axes = config.wrench_frame == "tool"
        self._offset = config.tool_offset
        self._force_n = force_n
        self._check = SignCheck(force_n, periods)
        self._calls = ThreadPoolExecutor(1, "sign check")
        self._pending: Future[str | None] | None = None

    def update(self, arguments: dict[str, Any]) -> str | None:
        """Checks a measurement, as `Controller.step` gets it; returns a finding about an earlier one."""
        if self._force_n == 0 or "wrench" not in arguments:
            return None
        finding = None
        if self._pending is not None and self._pending.done():
            call, self._pending = self._pending, None
            finding = None if isinstance(call.exception(), revprio.RevprioError) else call.result()
        if self._pending is None:
            force = [self._sign * entry for entry in arguments["wrench"][:3]]
            if hypot(*force) < 0.5 * self._force_n:
                self._check.add([0.0] * 3, force)
            else:
                self._pending = self._calls.submit(self._look, arguments["joint_position"], force)
        return finding

    def close(self) -> None:
        """Ends the thread."""
        self._calls.shutdown(cancel_futures=True)

    def _look(self, joint_position: Any, force: list[float]) -> str | None:
        pose = self._client.kinematics(robot=self._robot, joint_position=joint_position).pose
        position = list(map(float, pose.position))
        turn = as_quaternion(pose.orientation)
        if self._offset is not None:
            lever = rotated(turn, list(map(float, self._offset.position)))
            position = [p + d for p, d in zip(position, lever)]
        if self._in_tool_axes:
            if self._offset is not None:
                force = rotated(as_quaternion(self._offset.orientation), force)
            force = rotated(turn, force)
        return self._check.add(position, force)


def as_quaternion(orientation: revprio.Orientation) -> SimpleNamespace:
    """Returns an orientation with the fields of geometry_msgs/Quaternion."""
    return SimpleNamespace(w=orientation.w, x=orientation.x, y=orientation.y, z=orientation.z)
