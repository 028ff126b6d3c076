"""RoboPlan without the filter of the targets."""

from __future__ import annotations

from pathlib import Path

from behaviour.controllers.base import Setting
from behaviour.controllers.roboplan import RoboPlan


def make(urdf: Path, setting: Setting) -> RoboPlan:
    """Loads RoboPlan with the filter of its example set to 0, which disables it."""
    return RoboPlan(urdf, setting.gain(), filter_s=0.0, limit_acceleration=False)
