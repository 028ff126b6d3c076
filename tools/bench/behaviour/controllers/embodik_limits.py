"""EmbodiK's velocity solver with its acceleration limits."""

from __future__ import annotations

from pathlib import Path

from behaviour.controllers.base import Setting
from behaviour.controllers.embodik import EmbodiK


def make(urdf: Path, setting: Setting) -> EmbodiK:
    """Loads EmbodiK with acceleration limits besides the default ones."""
    del setting
    return EmbodiK(urdf, limit_acceleration=True)
