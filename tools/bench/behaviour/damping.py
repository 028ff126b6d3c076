"""Damping of revprio's controller in the hard families: `python -m behaviour.damping --document FILE` fills a table."""

from __future__ import annotations

import argparse
import functools
from pathlib import Path
from typing import Any

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
from revprio.models import Damping

from behaviour.controllers.base import SETTINGS, Setting
from behaviour.controllers.revprio import URL, Revprio
from behaviour.families import PERIOD_S, Family, families
from behaviour.pictures import STYLE, acceleration_over_limit, error_mm
from behaviour.report import fill, recovery_text, table
from behaviour.score import score
from behaviour.simulate import Record, run

SETTING = SETTINGS[1]
"""Real conditions with measured positions."""
FAMILIES = ("out_of_reach", "joint_limit", "too_fast")
VALUES = (
    (0.05, 0.1),
    (0.05, 0.2),
    (0.1, 0.1),
    (0.1, 0.2),
    (0.15, 0.15),
    (0.15, 0.3),
    (0.2, 0.1),
    (0.2, 0.2),
    (0.2, 0.3),
)
"""Threshold and largest factor."""
LENGTHS = ((0.5, 0.3), (0.25, 0.3), (0.25, 0.6))
"""Characteristic length, m, and threshold, which is the largest factor too."""
SHOWN = ("none", "0.05, 0.1", "0.15, 0.15")

Runs = dict[str, dict[str, Record]]
"""Runs by damping, then by family."""


def changes() -> dict[str, dict[str, Any]]:
    """Returns the changed fields of the controller by the name of the damping."""
    named: dict[str, dict[str, Any]] = {"none": {"damping": None}}
    for threshold, factor in VALUES:
        named[f"{threshold}, {factor}"] = {"damping": Damping(threshold=threshold, max_factor=factor)}
    for length, threshold in LENGTHS:
        damping = Damping(threshold=threshold, max_factor=threshold)
        named[f"{threshold}, {threshold}, L = {length} m"] = {"damping": damping, "characteristic_length_m": length}
    return named


def make(changed: dict[str, Any], setting: Setting) -> Revprio:
    """Opens a session with the changed fields."""
    return Revprio(URL, setting.drive(), changed)


def simulate(chosen: list[Family]) -> Runs:
    """Runs all families with each damping."""
    return {
        name: {family.name: run(functools.partial(make, changed), family, SETTING) for family in chosen}
        for name, changed in changes().items()
    }


def runs_table(runs: Runs, chosen: list[Family]) -> str:
    """Returns error, recovery, acceleration and vibration for each damping and family."""
    rows = [
        ["family", "threshold, max_factor", "tracking, mm", "recovery, s", "acceleration, rad/s²", "power above 3 Hz"]
    ]
    for family in chosen:
        for name, records in runs.items():
            result = score(records[family.name], family)
            numbers = [f"{result.tracking_mm:.2f}", recovery_text(result)]
            numbers += [f"{result.acceleration:.2f}", f"{1e3 * result.vibration:.2f}"]
            rows.append([family.title, name, *numbers])
    return table(rows)


def draw(runs: Runs, family: Family, path: Path) -> None:
    """Draws error and acceleration for some dampings over the time."""
    figure, axes = plt.subplots(2, len(SHOWN), figsize=(9, 3.6), sharex=True, sharey="row", layout="constrained")
    for column, name in enumerate(SHOWN):
        record = runs[name][family.name]
        times_s = PERIOD_S * np.arange(len(record.position), dtype=np.float64)
        top, bottom = axes[:, column]
        top.set_title("no damping" if name == "none" else name)
        top.plot(times_s, error_mm(record, family), color="#0072b2", linewidth=1)
        bottom.plot(times_s, acceleration_over_limit(record), color="#0072b2", linewidth=0.7)
        for axis in (top, bottom):
            axis.axvspan(*family.unreachable[0], color="0.93")
        bottom.set_xlabel("time, s")
    axes[0, 0].set_ylabel("pose error, mm")
    axes[1, 0].set_ylabel("acceleration / limit")
    figure.savefig(path, dpi=110)
    plt.close(figure)


def main() -> None:
    """Runs the sweep, fills the table and draws the picture next to the document."""
    parser = argparse.ArgumentParser(prog="behaviour.damping", description=__doc__)
    parser.add_argument("--document", type=Path, required=True, help="Markdown file with the part bench:damping")
    document: Path = parser.parse_args().document
    chosen = [family for name in FAMILIES for family in families(quick=False) if family.name == name]
    runs = simulate(chosen)
    fill(document, "damping", runs_table(runs, chosen))
    mpl.use("agg")
    with mpl.rc_context(STYLE):
        draw(runs, chosen[0], document.with_suffix(".png"))


if __name__ == "__main__":
    main()
