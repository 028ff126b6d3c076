"""Picture of the runs on the slides: `python -m barrier.pictures --out FOLDER --document docs/barrier.md`.

It is written to a folder next to the document and with its name.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle

from barrier import entries
from barrier.plant import PERFECT
from barrier.scenes import MIN_DISTANCE_M, SLIDES, STARTS, Start
from barrier.simulate import Record

COLOURS = {
    "revprio": "#0072b2",
    "pink": "#d55e00",
    "mink": "#009e73",
    "placo": "#8c8c8c",
    "EmbodiK": "#cc79a7",
    "RoboPlan": "#e69f00",
}
"""Colours by the first word of the entry."""
STYLES = {"EmbodiK, acceleration solver": "--", "EmbodiK, certified rows": ":"}
STYLE = {"font.size": 8, "axes.spines.top": False, "axes.spines.right": False, "axes.titlesize": 9}
PANELS = (
    ("starts outside, no acceleration limits", STARTS[0], False),
    ("starts outside, acceleration limits", STARTS[0], True),
    ("starts 3 mm inside, all", STARTS[2], None),
)


def draw(axes: Axes, out: Path, start: Start, limited: bool | None) -> None:
    """Draws the paths of the centre of the tool. `limited`: with or without acceleration limits; none: both."""
    x, y, _ = (float(coordinate) for coordinate in SLIDES.obstacle.start)
    centre, radius = (x, y), SLIDES.obstacle.radius + SLIDES.shapes["tool"].radius
    axes.add_patch(Circle(centre, radius, color="0.85", linewidth=0))
    axes.add_patch(Circle(centre, radius + MIN_DISTANCE_M, fill=False, color="0.5", linewidth=0.8, linestyle=":"))
    for name, entry in reversed(entries.ENTRIES.items()):
        path = entries.path_of(out, name, SLIDES, start, PERFECT)
        if not path.exists() or limited not in (None, entry.limits_acceleration):
            continue
        position = Record.load(path).position
        colour = COLOURS[name.split(",")[0]]
        width = 1.8 if name.startswith(entries.OURS) else 1.1
        axes.plot(*position.T, color=colour, linewidth=width, linestyle=STYLES.get(name, "-"), label=name)
        axes.plot(*position[-1], marker="o", markersize=3.5, color=colour)
    axes.set_aspect("equal")
    axes.set_xlim(-0.05, 1.05)
    axes.set_ylim(-0.3, 0.2)


def main() -> None:
    """Draws the picture."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, required=True, help="folder of the recorded runs")
    parser.add_argument("--document", type=Path, required=True, help="Markdown file of the picture")
    arguments = parser.parse_args()
    mpl.rcParams.update(STYLE)
    figure, panels = plt.subplots(3, 1, figsize=(8.4, 8.6), sharex=True)
    figure.subplots_adjust(left=0.08, right=0.73, top=0.97, bottom=0.06, hspace=0.16)
    for axes, (title, start, limited) in zip(np.ravel(panels), PANELS, strict=True):
        draw(axes, arguments.out, start, limited)
        axes.set_title(title, loc="left", fontweight="bold")
        axes.set_ylabel("y, m")
        if limited is not None:
            handles, labels = axes.get_legend_handles_labels()
            axes.legend(handles[::-1], labels[::-1], fontsize=7, frameon=False, loc="upper left", bbox_to_anchor=(1, 1))
    panels[-1].set_xlabel("x, m")
    folder = arguments.document.with_suffix("")
    folder.mkdir(exist_ok=True)
    figure.savefig(folder / "slides.png", dpi=100)


if __name__ == "__main__":
    main()
