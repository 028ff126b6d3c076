"""Draws the scenarios of this directory: each robot at some times of its run, from above and from the side.

It needs the traces of the runs and a service that knows their robots:

    for each scenario: revprio simulate examples/scenarios/NAME.toml --robot … --traces csv --out runs/NAME
    revprio serve --robot … --robot … --robot … --robot …
    python examples/scenarios/draw.py runs docs/guides/scenarios.png
"""

import csv
import re
import sys
import tomllib
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import revprio

TIMES = 6
"""Number of postures of a run that are drawn."""


def postures(trace: Path, joints: list[str]) -> np.ndarray:
    """Returns the joint positions of a run, periods × n."""
    with trace.open() as file:
        rows = list(csv.DictReader(file))
    columns = [next(name for name in rows[0] if re.fullmatch(rf"position_{joint}_[a-z]+", name)) for joint in joints]
    return np.array([[float(row[column]) for column in columns] for row in rows])


def chains(client: revprio.Client, robot: str, q: np.ndarray) -> list[np.ndarray]:
    """Returns the line from the base to each tip, points × 3, m."""
    answer = client.kinematics(robot=robot, joint_position=q)
    frames = {link.joint: link for link in answer.links}
    lines = []
    for tip in answer.tips:
        line, joint = [tip.pose.position], tip.joint
        while joint is not None:
            line.append(frames[joint].pose.position)
            joint = frames[joint].parent
        lines.append(np.array(line))
    return lines


def outline(obstacle: dict, view: tuple[int, int]) -> mpl.patches.Patch:
    """Returns what is seen of an obstacle."""
    if "box" in obstacle:
        middle = np.array(obstacle["box"]["pose"]["position"])[list(view)]
        size = np.array(obstacle["box"]["size"])[list(view)]
        return mpl.patches.Rectangle(middle - size / 2, *size)
    if "sphere" in obstacle:
        return mpl.patches.Circle(np.array(obstacle["sphere"]["center"])[list(view)], obstacle["sphere"]["radius"])
    start, end = (np.array(obstacle["capsule"][name])[list(view)] for name in ("start", "end"))
    radius = obstacle["capsule"]["radius"]
    low, high = np.minimum(start, end) - radius, np.maximum(start, end) + radius
    style = mpl.patches.BoxStyle("Round", pad=0, rounding_size=radius)
    return mpl.patches.FancyBboxPatch(low, *(high - low), boxstyle=style)


def draw(scenario: dict, trace: Path, client: revprio.Client, above: plt.Axes, aside: plt.Axes) -> None:
    """Draws one scenario."""
    robot = scenario["controller"]["robot"]
    q = postures(trace, [joint.name for joint in client.robot(robot).joints])
    tips = np.array([[line[0] for line in chains(client, robot, position)] for position in q[::20]])
    for axes, view, name in ((above, (0, 1), "y"), (aside, (0, 2), "z")):
        for obstacle in scenario["controller"].get("collisions", {}).get("obstacles", []):
            patch = outline(obstacle, view)
            patch.set(facecolor="#d9a441", edgecolor="#8a6414", alpha=0.6)
            axes.add_patch(patch)
        for k, period in enumerate(np.linspace(0, len(q) - 1, TIMES).astype(int)):
            for line in chains(client, robot, q[period]):
                shade = 0.8 - 0.75 * k / (TIMES - 1)
                axes.plot(line[:, view[0]], line[:, view[1]], "-o", color=str(shade), markersize=2, linewidth=1.2)
        for tip in range(tips.shape[1]):
            axes.plot(tips[:, tip, view[0]], tips[:, tip, view[1]], color=f"C{tip}", linewidth=1.5)
        axes.set(aspect="equal", xlabel="x (m)", ylabel=f"{name} (m)")
        axes.grid(alpha=0.3)
    above.set_title(scenario["name"], fontsize=10)


def main(runs: Path, picture: Path) -> None:
    """Draws all scenarios that have a trace."""
    scenarios = [tomllib.loads(file.read_text()) for file in sorted(Path(__file__).parent.glob("*.toml"))]
    traces = [next(runs.rglob(f"{scenario['name']}-*.csv"), None) for scenario in scenarios]
    drawn = [(scenario, trace) for scenario, trace in zip(scenarios, traces, strict=True) if trace]
    figure, axes = plt.subplots(2, len(drawn), figsize=(3.4 * len(drawn), 6.4), layout="constrained", squeeze=False)
    with revprio.Client() as client:
        for k, (scenario, trace) in enumerate(drawn):
            draw(scenario, trace, client, axes[0, k], axes[1, k])
    figure.savefig(picture, dpi=90)


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
