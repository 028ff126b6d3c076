"""Computes the live figures of the site with a running service: live.py URL. Prints a script that defines their data.

`conflict`: two tasks with opposite velocities along directions at an angle, as in examples/methods.rs. For each method and angle
it has the joint velocity of the first two joints.
"""

import json
import math
import sys
import urllib.request

DAMPING = {"threshold": 0.05, "max_factor": 0.1}
METHODS = [
    ("task priority", "task_priority", None),
    ("reverse priority, exact", "reverse_priority", None),
    ("damped least squares", "damped_least_squares", DAMPING),
    ("singularity-robust", "singularity_robust", None),
    ("reverse priority, damped", "reverse_priority", DAMPING),
]
STEP = 0.5
ANGLES = [STEP * (i + 1) for i in range(round(90 / STEP))]


def problem(method: str, damping: dict[str, float] | None, degrees: float) -> dict[str, object]:
    """Returns the problem: velocity 1 along a direction, and −1 along a direction at an angle to it."""
    angle = math.radians(degrees)
    rows = [([1, 0, 0], 1), ([math.cos(angle), math.sin(angle), 0], -1)]
    tasks = [{"jacobian": [row], "velocity": [velocity]} for row, velocity in rows]
    return {"tasks": tasks, "method": method, "solver": "closed_form", "damping": damping}


def main() -> None:
    """Prints the data."""
    items = [problem(method, damping, angle) for _, method, damping in METHODS for angle in ANGLES]
    body = json.dumps({"items": items}).encode()
    request = urllib.request.Request(f"{sys.argv[1]}/v1/resolve/batch", body, {"Content-Type": "application/json"})
    with urllib.request.urlopen(request) as answer:  # noqa: S310: the address of the service that was just started
        answers = json.load(answer)["items"]
    velocities = [[round(value, 6) for value in item["joint_velocity"][:2]] for item in answers]
    count = len(ANGLES)
    curves = [{"label": label, "velocity": velocities[k * count : (k + 1) * count]} for k, (label, *_) in enumerate(METHODS)]
    figures = {"conflict": {"angles": ANGLES, "curves": curves}}
    print(f"globalThis.revprioFigures = {json.dumps(figures, ensure_ascii=False)};")


main()
