"""revprio with laws that look ahead; see docs/fast.md."""

from __future__ import annotations

from pathlib import Path

from revprio import ConstantProfile, ControllerTask, PoseLaw, PostureLaw
from revprio.models import Streaming

from behaviour import arm as model
from behaviour.controllers.base import Setting
from behaviour.controllers.revprio import AXES, POSTURE_GAIN, URL, Revprio
from behaviour.families import GAIN

MAX_VELOCITY = [3.0] * 3 + [6.0] * 3
MAX_ACCELERATION = [30.0] * 3 + [60.0] * 3


def make(urdf: Path, setting: Setting) -> Revprio:
    """Opens a session; the program ships the same robot description."""
    del urdf
    posture = ConstantProfile(value=list(model.HOME))
    tasks = [
        ControllerTask(
            name="tool",
            axes=AXES,
            law=PoseLaw(gain=GAIN, path="joint"),
            streaming=Streaming(max_velocity=MAX_VELOCITY, max_acceleration=MAX_ACCELERATION),
        ),
        ControllerTask(name="posture", law=PostureLaw(gain=POSTURE_GAIN, target_position=posture, path="joint")),
    ]
    return Revprio(URL, setting.drive(), {"tasks": tasks})
