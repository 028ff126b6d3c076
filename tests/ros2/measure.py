"""Measures the periods of the node with the simulated arm, and prints a table.

    tests/ros2/run measure

Timer: interval between two periods of the node, as its diagnostics say. Received: interval between two commands, as
another process receives them. Both contain the scheduling of all processes of the machine.
"""

import json
import tempfile
import time
from pathlib import Path

import numpy as np
from harness import PACKAGE, Lab, free_port, recorder, until

SECONDS = 5.0


def measure(place: str, period_s: float) -> tuple[list[float], list[float]]:
    """Returns the intervals of the node's timer and of the received commands: median, 99th percentile, maximum, ms."""
    scenario = json.loads((PACKAGE / "config/wall.json").read_text())
    scenario["controller"]["period_s"] = period_s
    scenario["contacts"] = []
    scenario["controller"]["tasks"][0]["law"]["damping"] = 5000
    arm = recorder()
    with tempfile.TemporaryDirectory() as directory:
        lab = Lab(Path(directory))
        try:
            url = lab.service(free_port())[1] if place == "service" else ""
            lab.node("simulator", scenario=lab.file("free.json", json.dumps(scenario)))
            lab.node("controller", controller=lab.file("push.json", json.dumps(scenario["controller"])), url=url)
            arm.wait_for_motion()
            until(lambda: arm.says("controls the arm"), "the node controls the arm")
            time.sleep(1.0)
            first = len(arm.commands)
            time.sleep(SECONDS)
            received = np.diff([at_s for at_s, _ in arm.commands[first:]])
            values = arm.statuses["control"].values
        finally:
            lab.end()
    timer = [float(values[f"period {name} (ms)"]) for name in ("p50", "p99", "max")]
    return timer, [1e3 * float(np.quantile(received, share)) for share in (0.5, 0.99, 1.0)]


def main() -> None:
    """Prints the table."""
    print("| computed by | period (ms) | timer p50 | p99 | max | received p50 | p99 | max |")
    print("|---|---|---|---|---|---|---|---|")
    for place in ("node", "service"):
        for period_s in (0.01, 0.004):
            timer, received = measure(place, period_s)
            numbers = " | ".join(f"{interval:.1f}" for interval in timer + received)
            print(f"| {place} | {1e3 * period_s:.0f} | {numbers} |", flush=True)


if __name__ == "__main__":
    main()
