"""Noisy targets at rest and in motion: `python -m behaviour.smoothing --out FOLDER --document FILE` fills a table."""

from __future__ import annotations

import argparse
import functools
from pathlib import Path

import numpy as np
from revprio.models import Streaming

from behaviour import arm as model
from behaviour import entries, families
from behaviour.controllers.base import SETTINGS, Controller, Setting
from behaviour.controllers.revprio import URL, Revprio, tasks
from behaviour.families import PERIOD_S, START, Family
from behaviour.report import fill, table
from behaviour.score import rms, score
from behaviour.simulate import Make, run

SETTING = SETTINGS[1]
"""Real conditions with measured positions."""
VALUES_S = (0.0, 0.03, 0.06, 0.1, 0.2, 0.3)
PEERS = ("pink", "mink")
REST = Family("rest", "target at rest", 8.0, lambda _: START, sender=functools.partial(families.tracker, drop_outs=()))
SETTLED = round(3.0 / PERIOD_S)
"""Periods until the arm is at rest."""
JUMPING = next(family for family in families.ALL if family.name == "jumping")


def make(smoothing_s: float, setting: Setting) -> Controller:
    """Opens a session with this smoothing."""
    hand, posture = tasks()
    hand = hand.model_copy(update={"streaming": Streaming(smoothing_s=smoothing_s)})
    return Revprio(URL, setting.drive(), {"tasks": [hand, posture]})


def row(name: str, maker: Make) -> list[str]:
    """Returns the motion at rest, and tracking error and acceleration of the jumping targets."""
    command = run(maker, REST, SETTING).command[SETTLED:]
    result = score(run(maker, JUMPING, SETTING), JUMPING)
    at_rest = [rms(np.linalg.norm(command, axis=1)), float(np.abs(command).max())]
    return [name, *(f"{speed:.3f}" for speed in at_rest), f"{result.tracking_mm:.1f}", f"{result.acceleration:.1f}"]


def main() -> None:
    """Runs the sweep and fills the table."""
    parser = argparse.ArgumentParser(prog="behaviour.smoothing", description=__doc__)
    parser.add_argument("--document", type=Path, required=True, help="Markdown file with the part bench:smoothing")
    parser.add_argument("--out", type=Path, required=True, help="folder of the robot for the peers")
    arguments = parser.parse_args()
    urdf = model.urdf_for_peers(arguments.out)
    head = ["`smoothing_s`", "at rest, RMS, rad/s", "largest joint, rad/s", "tracking, mm", "acceleration, rad/s²"]
    rows = [head, *(row(f"{value:g} s", functools.partial(make, value)) for value in VALUES_S)]
    rows += [row(name, functools.partial(entries.make, name, urdf)) for name in PEERS]
    fill(arguments.document, "smoothing", table(rows))


if __name__ == "__main__":
    main()
