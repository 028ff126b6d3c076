"""Command line: `python -m barrier simulate` runs programs, `report` prints the tables. See `run`."""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import numpy as np

from barrier import entries, report, simulate
from barrier.controllers.base import Controller
from barrier.plant import DRIVES, PERFECT
from barrier.scenes import DURATION_S, PANDA, SCENES, STARTS

QUICK_S = 0.5
ROUNDS = 5
"""Runs of which the fastest time of each period counts."""


def run_all(out: Path, names: list[str], duration_s: float) -> None:
    """Runs the entries in all scenes, and saves the records."""
    for name in names:
        begin = time.monotonic()
        for scene in [scene for scene in SCENES if entries.runs(name, scene)]:
            controller = entries.make(name, scene, PERFECT, out)
            try:
                simulate.check_kinematics(controller, scene)
            finally:
                controller.close()
            for start in STARTS:
                for drive in DRIVES:

                    def make() -> Controller:
                        return entries.make(name, scene, drive, out)  # noqa: B023 - called before the next turn

                    record = simulate.run(make, scene, start, drive, duration_s)
                    record.save(entries.path_of(out, name, scene, start, drive))
        print(f"{name}: {time.monotonic() - begin:.1f} s", flush=True)


def time_all(out: Path, names: list[str], rounds: int, duration_s: float) -> None:
    """Runs the Panda that starts outside several times and keeps the fastest time of each period."""
    for name in [name for name in names if entries.runs(name, PANDA)]:
        records = [
            simulate.run(lambda: entries.make(name, PANDA, PERFECT, out), PANDA, STARTS[0], PERFECT, duration_s)  # noqa: B023 - called at once
            for _ in range(rounds)
        ]
        fastest = np.min([record.step_s for record in records], axis=0)
        last = records[-1]
        record = simulate.Record(last.position, last.command, last.refused, fastest)
        record.save(entries.path_of(out, name, PANDA, STARTS[0], PERFECT))


def main() -> None:
    """Parses the arguments."""
    parser = argparse.ArgumentParser(prog="barrier", description=__doc__)
    parser.add_argument("action", choices=("simulate", "time", "report"))
    parser.add_argument("--out", type=Path, required=True, help="folder of the recorded runs")
    parser.add_argument("--entries", nargs="+", default=list(entries.ENTRIES), choices=list(entries.ENTRIES))
    parser.add_argument("--quick", action="store_true", help=f"only the first {QUICK_S} s of each run: a smoke test")
    parser.add_argument("--document", type=Path, help="Markdown file whose marked parts are replaced")
    arguments = parser.parse_args()
    duration_s = QUICK_S if arguments.quick else DURATION_S
    if arguments.action == "simulate":
        run_all(arguments.out, arguments.entries, duration_s)
    elif arguments.action == "time":
        time_all(arguments.out, arguments.entries, 1 if arguments.quick else ROUNDS, duration_s)
    else:
        report.write(arguments.out, arguments.document)


if __name__ == "__main__":
    main()
