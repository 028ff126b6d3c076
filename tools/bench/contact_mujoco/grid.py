"""Walls of unknown stiffness: conditions drawn from a grid, for two arms and four velocity loops."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

from contact_mujoco import pressing
from contact_mujoco.arm import Drive
from contact_mujoco.conditions import BANDWIDTHS, Conditions, draw
from contact_mujoco.robots import PANDA, ROBOTS, SAWYER
from contact_mujoco.score import HEAD, Score, row, score
from contact_mujoco.tables import short, table

FAST = 100.0
"""Smallest bandwidth of the velocity loops in the table over stiffnesses, rad/s."""


@dataclasses.dataclass(frozen=True)
class Result:
    """A run and how good it is."""

    arm: str
    bandwidth: float
    stiffness: float
    words: str
    """All conditions."""
    score: Score


def measure(count: int, out: Path) -> list[Result]:
    """Runs `count` conditions of each arm and velocity loop; writes each result to the file of this count."""
    results = []
    with results_file(out, count).open("w") as file:
        for robot in ROBOTS:
            for bandwidth in BANDWIDTHS:
                for terms in draw(robot, bandwidth, count):
                    found = score(terms, pressing.run(terms))
                    results.append(Result(robot.name, bandwidth, terms.stiffness, terms.words, found))
                    file.write(json.dumps(dataclasses.asdict(results[-1])) + "\n")
                    file.flush()
    return results


def results_file(out: Path, count: int) -> Path:
    """Returns the file of a grid: a quick one leaves the results of the whole one."""
    return out / f"grid-{count}.jsonl"


def read(count: int, out: Path) -> list[Result]:
    """Reads the results of `measure`."""
    rows = [json.loads(line) for line in results_file(out, count).read_text().splitlines()]
    return [Result(**{**fields, "score": Score(**fields["score"])}) for fields in rows]


def tables(results: list[Result]) -> dict[str, str]:
    """Returns the tables by their marks."""
    by_arm: dict[tuple[str, str], list[Score]] = {}
    by_stiffness: dict[float, list[Score]] = {}
    for result in results:
        by_arm.setdefault((result.arm, f"{result.bandwidth:.0f} rad/s"), []).append(result.score)
        if result.bandwidth >= FAST:
            by_stiffness.setdefault(result.stiffness, []).append(result.score)
    arms = [row(list(names), scores) for names, scores in by_arm.items()]
    walls = [row([short(value)], scores) for value, scores in sorted(by_stiffness.items())]
    missed = [f"| {result.words} | {', '.join(result.score.misses)} |" for result in results if result.score.misses]
    return {
        "grid": "\n".join([HEAD.format("arm | velocity loop", "---|---"), *arms]),
        "stiffness": "\n".join([HEAD.format("K, N/m", "---"), *walls]),
        "misses": "\n".join(["| run | misses |", "|---|---|", *missed]),
    }


FAILURES = {
    "the noise is as large as the force for long": Conditions(
        PANDA, Drive(400.0, 0.02, 1), 0.001, 1e3, 0.01, 5.0, seed=7
    ),
    "an impact stops the motors at their torques": Conditions(
        SAWYER, Drive(400.0, 0.02, 2), 0.002, 1e6, 0.1, 5.0, seed=48
    ),
}
"""Runs that are hard to settle, and why."""


def failures() -> str:
    """Returns the table of the runs that are hard to settle."""
    rows = []
    for cause, terms in FAILURES.items():
        trace = pressing.run(terms)
        found = score(terms, trace)
        rows.append([cause, terms.words, "yes" if found.settled else "no", f"{found.error:.1f}", trace.state])
    return table(["what is hard", "run", "settled", "error, N", "state at the end"], rows)
