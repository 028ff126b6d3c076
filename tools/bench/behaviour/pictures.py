"""Pictures of the recorded runs: `python -m behaviour.pictures --out FOLDER --document docs/behaviour.md`.

They are written to a folder next to the document and with its name.
"""

from __future__ import annotations

import argparse
import io
from pathlib import Path

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from PIL import Image

from behaviour import arm as model
from behaviour import entries
from behaviour.controllers.base import SETTINGS, Setting
from behaviour.families import PERIOD_S, Family, families
from behaviour.rotations import Array
from behaviour.score import RADIUS_M, pose_errors
from behaviour.simulate import Record

SETTING = SETTINGS[1]
"""Real conditions with measured positions."""
MOVING = "out_of_reach"
"""Family of the moving picture."""
COLUMNS = ("revprio", "RoboPlan", "EmbodiK")
"""revprio and the two other programs whose entries with the settings of their examples have the best ranks."""
FRAMES_PER_S = 10
COLOURS = {
    "revprio": "#0072b2",
    "revprio, looking ahead": "#56b4e9",
    "pink": "#d55e00",
    "pink, acceleration limits": "#cc79a7",
    "mink": "#009e73",
    "placo": "#8c8c8c",
    "EmbodiK": "#b38f00",
    "RoboPlan": "#5e4fa2",
}
"""The entries that are drawn. The tables have all."""
STYLE = {"font.size": 8, "axes.spines.top": False, "axes.spines.right": False, "axes.titlesize": 9}


def load(out: Path, name: str, setting: Setting, family: Family) -> Record:
    """Reads a run."""
    return Record.load(entries.path_of(out, name, setting, family.name))


def error_mm(record: Record, family: Family) -> Array:
    """Returns the pose error at the start of each period, mm."""
    distance, angle = pose_errors(record, family)
    return np.asarray(1e3 * np.hypot(distance, RADIUS_M * angle))


def acceleration_over_limit(record: Record) -> Array:
    """Returns in each period the largest joint acceleration of the command as a multiple of its limit."""
    acceleration = np.diff(record.command, axis=0, prepend=0.0) / PERIOD_S
    return np.asarray((np.abs(acceleration) / model.load().acceleration).max(axis=1))


def draw_family(axes: tuple[Axes, Axes], out: Path, family: Family) -> None:
    """Draws error and acceleration of the drawn entries over the time."""
    left, right = axes
    for start, end in family.untracked:
        left.axvspan(start, end, color="0.93")
        right.axvspan(start, end, color="0.93")
    for name in reversed(COLOURS):
        record = load(out, name, SETTING, family)
        times_s = PERIOD_S * np.arange(len(record.position), dtype=np.float64)
        width = 1.4 if name.startswith(entries.OURS) else 0.7
        left.semilogy(times_s, np.maximum(error_mm(record, family), 0.05), color=COLOURS[name], linewidth=width)
        over = np.maximum(acceleration_over_limit(record), 1e-3)
        right.semilogy(times_s, over, color=COLOURS[name], linewidth=width, alpha=0.8)
    right.axhline(1, color="black", linewidth=0.8, linestyle=":")
    left.set_ylim(0.05, 2000)
    right.set_ylim(1e-3, 100)
    left.set_title(family.title, loc="left", fontweight="bold")
    left.set_ylabel("pose error, mm")
    right.set_ylabel("acceleration / limit")


def draw_families(out: Path, path: Path) -> None:
    """Draws all families under real conditions, with measured positions."""
    chosen = families(quick=False)
    figure, rows = plt.subplots(len(chosen), 2, figsize=(9, 1.75 * len(chosen)), layout="constrained")
    for axes, family in zip(rows, chosen, strict=True):
        draw_family((axes[0], axes[1]), out, family)
    for axis in rows[-1]:
        axis.set_xlabel("time, s")
    lines = [Line2D([], [], color=colour) for colour in COLOURS.values()]
    figure.legend(lines, list(COLOURS), loc="outside upper center", ncols=len(lines), frameon=False)
    figure.savefig(path, dpi=110)
    plt.close(figure)


def project(points: Array) -> Array:
    """Returns a view from the side, slightly from above: … × 3 to … × 2, m."""
    x, y, z = np.moveaxis(points, -1, 0)
    return np.stack([x + 0.35 * y, z + 0.2 * y], axis=-1)


class Column:
    """One program in the moving picture: its arm, its error and its commands."""

    def __init__(self, axes: Array, name: str, record: Record, family: Family) -> None:
        """Draws what does not move."""
        self._arm, self._error, self._command = axes
        self._name, self._record, self._family = name, record, family
        self._errors = error_mm(record, family)
        self._times_s = PERIOD_S * np.arange(len(record.position), dtype=np.float64)
        tools = np.array([model.load().tool(position)[:3, 3] for position in record.position])
        self._path = project(tools)
        self._arm.set_title(name, color=COLOURS[name], fontweight="bold")
        self._arm.set(xlim=(-0.35, 1.15), ylim=(-0.05, 1.0), aspect="equal", xticks=[], yticks=[])
        self._arm.axhline(0, color="0.8")
        self._error.set(xlim=(0, family.duration_s), ylim=(0, 450), xticklabels=[])
        self._command.set(xlim=(0, family.duration_s), ylim=(-2.7, 2.7), xlabel="time, s")
        for axis in (self._error, self._command):
            for start, end in family.untracked:
                axis.axvspan(start, end, color="0.93")
        (self._links,) = self._arm.plot(
            [], [], "o-", color=COLOURS[name], linewidth=5, markersize=7, solid_capstyle="round"
        )
        (self._trail,) = self._arm.plot([], [], color="0.6", linewidth=0.8)
        (self._target,) = self._arm.plot([], [], "+", color="black", markersize=11, markeredgewidth=1.5)
        (self._error_line,) = self._error.plot([], [], color=COLOURS[name], linewidth=1.2)
        colours = mpl.colormaps["viridis"](np.linspace(0, 0.9, record.command.shape[1]))
        self._commands = [self._command.plot([], [], color=colour, linewidth=0.7)[0] for colour in colours]
        self._text = self._arm.text(
            0.98, 0.95, "", transform=self._arm.transAxes, ha="right", va="top", family="monospace"
        )

    def move(self, number: int) -> None:
        """Shows the state at the start of a period."""
        chain = project(model.load().frames(self._record.position[number])[:, :3, 3])
        self._links.set_data(chain[:, 0], chain[:, 1])
        self._trail.set_data(self._path[: number + 1, 0], self._path[: number + 1, 1])
        target = project(self._family.pose(number * PERIOD_S)[:3, 3])
        self._target.set_data([target[0]], [target[1]])
        times_s = self._times_s[: number + 1]
        self._error_line.set_data(times_s, self._errors[: number + 1])
        for line, values in zip(self._commands, self._record.command.T, strict=True):
            line.set_data(times_s, values[: number + 1])
        self._text.set_text(f"error {self._errors[number]:5.0f} mm")


def image_of(figure: Figure) -> Image.Image:
    """Returns the figure as an image."""
    memory = io.BytesIO()
    figure.savefig(memory, dpi=80)
    memory.seek(0)
    return Image.open(memory).convert("RGB")


def draw_moving(out: Path, path: Path) -> None:
    """Draws the arms side by side, moving in real time."""
    family = next(family for family in families(quick=False) if family.name == MOVING)
    shape = {"height_ratios": [3, 1, 1.3]}
    figure, axes = plt.subplots(3, len(COLUMNS), figsize=(11, 6), layout="constrained", gridspec_kw=shape)
    columns = [
        Column(axes[:, place], name, load(out, name, SETTING, family), family) for place, name in enumerate(COLUMNS)
    ]
    axes[1, 0].set_ylabel("pose error, mm")
    axes[2, 0].set_ylabel("commands, rad/s")
    step = round(1 / (FRAMES_PER_S * PERIOD_S))
    images = []
    for number in range(0, round(family.duration_s / PERIOD_S), step):
        for column in columns:
            column.move(number)
        images.append(image_of(figure))
    plt.close(figure)
    palette = images[-1].quantize(48, dither=Image.Dither.NONE)
    frames = [image.quantize(palette=palette, dither=Image.Dither.NONE) for image in images]
    frames[0].save(path, save_all=True, append_images=frames[1:], duration=1000 // FRAMES_PER_S, loop=0, optimize=True)


def main() -> None:
    """Draws all pictures."""
    parser = argparse.ArgumentParser(prog="behaviour.pictures", description=__doc__)
    parser.add_argument("--out", type=Path, required=True, help="folder of the recorded runs")
    parser.add_argument("--document", type=Path, required=True, help="page that the pictures belong to")
    arguments = parser.parse_args()
    folder = arguments.document.with_suffix("")
    folder.mkdir(exist_ok=True)
    mpl.use("agg")
    with mpl.rc_context(STYLE):
        draw_families(arguments.out, folder / "families.png")
        draw_moving(arguments.out, folder / "out_of_reach.gif")


if __name__ == "__main__":
    main()
