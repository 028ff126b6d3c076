"""pink with its acceleration limit."""

from __future__ import annotations

from pathlib import Path

from behaviour.controllers.base import Setting
from behaviour.controllers.pink import Pink


def make(urdf: Path, setting: Setting) -> Pink:
    """Loads pink with its acceleration limit besides the default ones."""
    return Pink(urdf, setting.gain(), limit_acceleration=True)
