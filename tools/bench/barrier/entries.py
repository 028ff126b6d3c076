"""The entries of the comparison and the files of their runs."""

from __future__ import annotations

import importlib
from dataclasses import dataclass
from pathlib import Path
from typing import cast

from barrier.controllers.base import Controller, Task
from barrier.plant import Drive
from barrier.scenes import SLIDES, Scene, Start

OURS = "revprio"
HTTP = "revprio over HTTP"
"""The entry for the time of a step through a service."""


@dataclass(frozen=True)
class Entry:
    """A program with its settings."""

    module: str
    """Module of `controllers`. It is imported only when it runs: the programs need different versions of libraries."""
    limits_acceleration: bool
    scene: str | None = None
    """The only scene that the entry can run, if there is one."""


ENTRIES = {
    OURS: Entry("revprio", limits_acceleration=True),
    "revprio, no acceleration limits": Entry("revprio", limits_acceleration=False),
    "pink": Entry("pink", limits_acceleration=False),
    "pink, acceleration limits": Entry("pink", limits_acceleration=True),
    "mink": Entry("mink", limits_acceleration=False),
    "placo": Entry("placo", limits_acceleration=False),
    "EmbodiK": Entry("embodik", limits_acceleration=False),
    "EmbodiK, acceleration limits": Entry("embodik", limits_acceleration=True),
    "EmbodiK, acceleration solver": Entry("embodik_accelerations", limits_acceleration=True),
    "EmbodiK, certified rows": Entry("embodik_certified", limits_acceleration=True, scene=SLIDES.name),
    "RoboPlan": Entry("roboplan", limits_acceleration=False),
    "RoboPlan, acceleration limits": Entry("roboplan", limits_acceleration=True),
    HTTP: Entry("revprio_http", limits_acceleration=True),
}
"""All entries in the order of the tables."""


def runs(name: str, scene: Scene) -> bool:
    """Returns whether an entry can run a scene."""
    return ENTRIES[name].scene in (None, scene.name)


def make(name: str, scene: Scene, drive: Drive, folder: Path) -> Controller:
    """Starts the controller of an entry."""
    entry = ENTRIES[name]
    module = importlib.import_module(f"barrier.controllers.{entry.module}")
    return cast(Controller, module.make(Task(scene, drive, entry.limits_acceleration, folder)))


def path_of(out: Path, name: str, scene: Scene, start: Start, drive: Drive) -> Path:
    """Returns the file of a run."""
    words = (name, scene.name, start.name, drive.name)
    return out / "runs" / ("--".join(words).replace(" ", "-").replace(",", "") + ".npz")
