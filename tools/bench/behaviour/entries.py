"""The entries of the comparison and the files of their runs."""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import cast

from behaviour.controllers.base import Controller, Setting

MODULES = {
    "revprio": "revprio",
    "revprio, looking ahead": "revprio_ahead",
    "pink": "pink",
    "pink, acceleration limits": "pink_accelerations",
    "mink": "mink",
    "placo": "placo",
    "EmbodiK": "embodik",
    "EmbodiK, acceleration limits": "embodik_limits",
    "EmbodiK, acceleration solver": "embodik_accelerations",
    "RoboPlan": "roboplan",
    "RoboPlan, unfiltered": "roboplan_unfiltered",
    "RoboPlan, acceleration limits": "roboplan_limits",
}
"""Module of each entry. Each is imported only when it runs: the programs need different versions of libraries."""
OURS = "revprio"


def make(name: str, urdf: Path, setting: Setting) -> Controller:
    """Starts the controller of an entry."""
    module = importlib.import_module(f"behaviour.controllers.{MODULES[name]}")
    return cast("Controller", module.make(urdf, setting))


def path_of(out: Path, name: str, setting: Setting, family: str) -> Path:
    """Returns the file of a run."""
    words = f"{name} {setting.name}".replace(",", "").replace(" ", "_")
    return out / "runs" / f"{words}.{family}.npz"
