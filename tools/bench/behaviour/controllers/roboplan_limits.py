"""RoboPlan with its acceleration limit."""

from __future__ import annotations

from pathlib import Path

from behaviour.controllers.base import Setting
from behaviour.controllers.roboplan import FILTER_S, RoboPlan


def make(urdf: Path, setting: Setting) -> RoboPlan:
    """Loads RoboPlan with its acceleration limit besides the default ones."""
    return RoboPlan(urdf, setting.gain(), filter_s=FILTER_S, limit_acceleration=True)
