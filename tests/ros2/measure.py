"""Measures the periods of the node with the simulated arm, and prints a table.

    tests/ros2/run measure

Interval: between two commands, as another process receives them. Latency: from the stamp of a joint state to the
arrival of the first command after it in that process. Both contain the scheduling of all processes of the machine.
"""

import json
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from harness import PACKAGE, Lab, free_port, recording, until

SECONDS = 5.0


def measure(place: str, period_s: float) -> tuple[np.ndarray, np.ndarray]:
    """Returns intervals and latencies, s."""
    scenario = json.loads((PACKAGE / "config/wall.json").read_text())
    scenario["controller"]["period_s"] = period_s
    scenario["contacts"] = []
    scenario["controller"]["tasks"][0]["law"]["damping"] = 5000
    with tempfile.TemporaryDirectory() as directory, recording() as arm:
        lab = Lab(Path(directory))
        try:
            url = lab.service(free_port())[1] if place == "service" else ""
            lab.node("simulator", scenario=lab.file("free.json", json.dumps(scenario)))
            lab.node("controller", controller=lab.file("push.json", json.dumps(scenario["controller"])), url=url)
            arm.wait_for_motion()
            until(lambda: arm.says("controls the arm"), "the node controls the arm")
            first, start_s = len(arm.commands), time.time() - time.monotonic()
            time.sleep(SECONDS)
            received = np.array([at_s for at_s, _ in arm.commands[first:]])
            stamps = [message.header.stamp for _, message in arm.states[-round(SECONDS / period_s) :]]
        finally:
            lab.end()
    measured = np.array([stamp.sec + 1e-9 * stamp.nanosec for stamp in stamps]) - start_s
    next_command = np.searchsorted(received, measured)
    is_answered = next_command < len(received)
    return np.diff(received), received[next_command[is_answered]] - measured[is_answered]


def row(place: str, period_s: float) -> str:
    """Returns a row of the table."""
    intervals, latencies = measure(place, period_s)
    numbers = [f"{1e3 * np.quantile(intervals, share):6.2f}" for share in (0.5, 0.99, 1.0)]
    delays = [f"{1e3 * np.quantile(latencies, share):6.2f}" for share in (0.5, 0.99)]
    return f"{place:<10} {1e3 * period_s:6.0f} {len(intervals):9} {' '.join(numbers)} {' '.join(delays)}"


def main() -> None:
    """Prints the table."""
    print("computed    period  commands  interval (ms)        latency (ms)")
    print("by            (ms)               p50    p99    max    p50    p99")
    for place in ("node", "service"):
        for period_s in (0.01, 0.004):
            print(row(place, period_s), flush=True)


if __name__ == "__main__":
    sys.exit(main())
