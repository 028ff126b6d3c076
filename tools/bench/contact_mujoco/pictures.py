"""Pictures of the scenarios: `python -m contact_mujoco.pictures FOLDER`."""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib as mpl
import mujoco
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from contact_mujoco import door, peg, surfaces
from contact_mujoco.arm import Arm
from contact_mujoco.robots import Array
from contact_mujoco.surfaces import Surface

WIDTH, HEIGHT = 480, 420
"""Size of a rendered frame, pixels."""
DOTS_PER_INCH = 100


def frame(arm: Arm, azimuth: float, distance: float = 1.4) -> Array | None:
    """Returns a view of the arm; `None` where MuJoCo has no renderer."""
    camera = mujoco.MjvCamera()
    camera.lookat[:] = [0.2, 0.05, 0.47]
    camera.azimuth, camera.elevation, camera.distance = azimuth, -15, distance
    try:
        with mujoco.Renderer(arm.model, HEIGHT, WIDTH) as renderer:
            renderer.update_scene(arm.data, camera)
            return np.asarray(renderer.render())
    except (mujoco.FatalError, RuntimeError, AttributeError) as error:
        print(f"no rendered frame: {error}", file=sys.stderr)
        return None


def start(view: Array | None, title: str) -> tuple[Figure, list[Axes]]:
    """Returns a figure with a view and two plots."""
    figure = Figure(figsize=(10, 3.4), layout="constrained", dpi=DOTS_PER_INCH)
    figure.suptitle(title, fontsize=11)
    axes = list(figure.subplots(1, 3))
    axes[0].axis("off")
    if view is not None:
        axes[0].imshow(view)
    return figure, axes[1:]


def wiping(folder: Path) -> None:
    """Draws the normal force on a tilted plane and on a cylinder."""
    known, arm = surfaces.wipe(Surface(0.5, 20, is_known=True))
    fixed, _ = surfaces.wipe(Surface(0.5, 20))
    figure, axes = start(frame(arm, 100), "Wiping with 20 N at 5 cm/s, µ = 0.5")
    for name, trace in (("axes of the base", fixed), ("axes of the surface", known)):
        axes[0].plot(trace.time_s[::20], trace.force[::20], linewidth=1, label=name)
    axes[0].set(title="plane, 20°", xlabel="time (s)", ylabel="normal force (N)", ylim=(0, 60))
    axes[0].legend(frameon=False, fontsize=8)
    for sliding in (0.0, 0.2, 0.5):
        trace, _ = surfaces.wipe(Surface(sliding, None))
        axes[1].plot(trace.time_s[::20], trace.force[::20], linewidth=1, label=f"µ = {sliding}")
    axes[1].set(title="cylinder, axes of the base", xlabel="time (s)", ylim=(0, 60))
    axes[1].legend(frameon=False, fontsize=8)
    figure.savefig(folder / "wiping.png")


def doors(folder: Path) -> None:
    """Draws how a door opens."""
    runs = {"along x": door.opening(0.4, follows=False), "along the motion": door.opening(0.4, follows=True)}
    view = frame(runs["along the motion"].arm, 60, 1.5)
    figure, axes = start(view, "A door of 0.4 m, whose radius the controller does not know")
    for name, run in runs.items():
        axes[0].plot(run.time_s, np.degrees(run.angle), label=f"force {name}")
        axes[1].plot(run.time_s, run.radial, linewidth=1)
    axes[0].set(xlabel="time (s)", ylabel="angle of the door (°)")
    axes[0].legend(frameon=False, fontsize=8)
    axes[1].set(xlabel="time (s)", ylabel="force across the motion (N)")
    figure.savefig(folder / "door.png")


def pegs(folder: Path) -> None:
    """Draws how a peg finds a hole."""
    block = peg.Block(0.0005, (-0.004, 0.003), 1e4)
    found = peg.search(block, 0.001)
    figure, axes = start(frame(found.arm, 125, 1.2), "A peg with 0.5 mm of play finds its hole by a spiral")
    axes[0].plot(1e3 * found.points[:, 0], 1e3 * found.points[:, 1], linewidth=1)
    axes[0].plot(1e3 * block.offset[0], 1e3 * block.offset[1], "+", color="black")
    axes[0].set(xlabel="x (mm)", ylabel="y (mm)", aspect="equal")
    axes[1].plot(found.time_s, -found.force[:, 2], linewidth=1, label="along z")
    axes[1].plot(found.time_s, np.linalg.norm(found.force[:, :2], axis=1), linewidth=1, label="across")
    depth = axes[1].twinx()
    depth.plot(found.time_s, -1e3 * found.points[:, 2], color="0.5", linestyle="--", linewidth=1)
    depth.set_ylabel("depth (mm), dashed")
    axes[1].set(xlabel="time (s)", ylabel="force (N)")
    axes[1].legend(frameon=False, fontsize=8)
    figure.savefig(folder / "peg.png")


def main() -> None:
    """Draws all."""
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    mpl.rcParams.update({"axes.spines.top": False, "axes.spines.right": False, "font.size": 9, "axes.titlesize": 10})
    for draw in (wiping, doors, pegs):
        draw(folder)


if __name__ == "__main__":
    main()
