"""Command line: `python -m contact_mujoco` measures and prints the tables of docs/contact-mujoco.md. See `run`."""

from __future__ import annotations

import argparse
import functools
import re
from collections.abc import Callable
from pathlib import Path

from contact_mujoco import door, encoders, events, friction, grid, peg, play, surfaces, turning, weights, yielding

RUNS = 21
"""Conditions of each arm and velocity loop."""
QUICK_RUNS = 2


LIMITS = {
    "rotations": turning.rotations,
    "yielding": yielding.yielding,
    "encoders": encoders.encoders,
    "friction": friction.friction,
    "play": play.play,
    "doors": door.doors,
    "edges": peg.edges,
    "holes": peg.holes,
    "weights": weights.weights,
    "postures": weights.postures,
}


def one(mark: str, table: Callable[[], str]) -> dict[str, str]:
    """Returns one table by its mark."""
    return {mark: table()}


def parts(count: int, out: Path, options: argparse.Namespace) -> dict[str, Callable[[], dict[str, str]]]:
    """Returns what can be measured: functions that return tables by their marks."""
    return {
        "grid": lambda: grid.tables(grid.read(count, out) if options.reuse else grid.measure(count, out)),
        "events": functools.partial(one, "events", events.settled_again),
        "moving": functools.partial(one, "moving", events.moving),
        "wiping": functools.partial(one, "wiping", surfaces.wiping),
        **{name: functools.partial(one, name, table) for name, table in LIMITS.items()},
        "failures": functools.partial(one, "failures", grid.failures),
        "understated": functools.partial(one, "understated", functools.partial(events.understated, 2 * count)),
    }


def fill(document: Path, mark: str, text: str) -> None:
    """Replaces the part of a Markdown file between `<!-- bench:contact_mujoco:mark -->` and `<!-- end -->`."""
    pattern = re.compile(rf"(<!-- bench:contact_mujoco:{mark} -->\n).*?(<!-- end -->)", re.DOTALL)
    source = document.read_text()
    if not pattern.search(source):
        raise ValueError(f"{document} has no part marked <!-- bench:contact_mujoco:{mark} -->")
    document.write_text(pattern.sub(lambda match: f"{match[1]}\n{text}\n\n{match[2]}", source))


def main() -> None:
    """Parses the arguments."""
    parser = argparse.ArgumentParser(prog="contact_mujoco", description=__doc__)
    parser.add_argument("parts", nargs="*", help="what to measure; default: all")
    parser.add_argument("--out", type=Path, required=True, help="folder of results")
    parser.add_argument("--quick", action="store_true", help="few runs: a smoke test")
    parser.add_argument("--reuse", action="store_true", help="print the results of the last grid again")
    parser.add_argument("--document", type=Path, help="Markdown file whose marked parts are replaced")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    known = parts(QUICK_RUNS if options.quick else RUNS, options.out, options)
    unknown = [name for name in options.parts if name not in known]
    if unknown:
        parser.error(f"there is no part {unknown[0]}; give some of {', '.join(known)}")
    for name in options.parts or (["grid"] if options.quick else known):
        for mark, table in known[name]().items():
            print(f"\n{mark}\n\n{table}", flush=True)
            if options.document:
                fill(options.document, mark, table)


if __name__ == "__main__":
    main()
