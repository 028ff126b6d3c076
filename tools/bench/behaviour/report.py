"""Tables of the results in Markdown, and the results as JSON."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from behaviour import entries
from behaviour.controllers.base import SETTINGS, Setting
from behaviour.families import Family
from behaviour.score import Score, score
from behaviour.simulate import Record

Scores = dict[tuple[str, str], dict[str, Score]]
"""Scores by family and setting, then by entry."""

TRACKING_MARGIN = 1.05
ACCELERATION_PART = 0.2
RESOLUTION_MM = 0.1
"""Smaller tracking errors count as this: the noise of the positions moves the tool by about as much."""


@dataclass(frozen=True)
class Column:
    """One number of the score: smaller is better."""

    title: str
    text: Callable[[Score], str]
    value: Callable[[Score], float]


def recovery_text(result: Score) -> str:
    """Returns the longest recovery time, or how many recoveries are missing."""
    if result.recoveries_missed:
        return f"**{result.recoveries_missed} never**"
    return "–" if result.recovery_s is None else f"{result.recovery_s:.2f}"


def counted(number: int) -> str:
    """Returns a number of faults, bold unless it is zero."""
    return f"**{number}**" if number else "0"


COLUMNS = (
    Column("tracking, mm", lambda s: f"{s.tracking_mm:.2f}", lambda s: s.tracking_mm),
    Column("acceleration, rad/s²", lambda s: f"{s.acceleration:.2f}", lambda s: s.acceleration),
    Column(
        "largest / limit",
        lambda s: f"{s.acceleration_over_limit:.2f}",
        lambda s: max(1.0, s.acceleration_over_limit),
    ),
    Column("power above 3 Hz, 10⁻³ (rad/s)²", lambda s: f"{1e3 * s.vibration:.2f}", lambda s: s.vibration),
    Column("violations", lambda s: counted(s.violations), lambda s: s.violations),
    Column("freezes", lambda s: counted(s.freezes), lambda s: s.freezes),
    Column("failures", lambda s: counted(s.failures), lambda s: s.failures),
    Column("recovery, s", recovery_text, lambda s: np.inf if s.recoveries_missed else s.recovery_s or 0.0),
)


def read(out: Path, families: list[Family]) -> Scores:
    """Returns the scores of all recorded runs."""
    scores: Scores = {}
    for family in families:
        for setting in SETTINGS:
            paths = {name: entries.path_of(out, name, setting, family.name) for name in entries.MODULES}
            found = {name: score(Record.load(path), family) for name, path in paths.items() if path.exists()}
            if found:
                scores[family.name, setting.name] = found
    return scores


def table(rows: list[list[str]]) -> str:
    """Returns a Markdown table; the first row is its head, and all but the first two columns are numbers."""
    head, *body = rows
    rule = ["---" if number < 2 else "---:" for number in range(len(head))]
    return "\n".join("| " + " | ".join(row) + " |" for row in [head, rule, *body]) + "\n"


def runs_table(scores: Scores, family: Family) -> str:
    """Returns the table of one family."""
    rows = [["setting", "controller", *(column.title for column in COLUMNS)]]
    for setting in SETTINGS:
        for name, result in scores.get((family.name, setting.name), {}).items():
            rows.append([setting.name, name, *(column.text(result) for column in COLUMNS)])
    return f"### {family.title[0].upper() + family.title[1:]}\n\n{table(rows)}"


def ranks(results: dict[str, Score]) -> dict[str, float]:
    """Returns the mean rank of each entry over the columns. Numbers that agree to two digits share their rank."""
    totals = dict.fromkeys(results, 0.0)
    for column in COLUMNS:
        values = {name: float(f"{column.value(result):.2g}") for name, result in results.items()}
        for name, value in values.items():
            better = sum(other < value for other in values.values())
            equal = sum(other == value for other in values.values())
            totals[name] += better + (equal + 1) / 2
    return {name: total / len(COLUMNS) for name, total in totals.items()}


def is_faulty(result: Score) -> bool:
    """Returns whether a run has a violation, a freeze, a failure or a missed recovery."""
    return bool(result.violations or result.freezes or result.failures or result.recoveries_missed)


def overall_table(scores: Scores, families: list[Family]) -> str:
    """Returns the mean ranks over the families, for each setting and over all, and how many runs have faults."""
    rows = [["place", "controller", *(setting.name for setting in SETTINGS), "all", "runs with faults"]]
    means: dict[str, list[float]] = {}
    for setting in SETTINGS:
        found = [
            ranks(scores[family.name, setting.name]) for family in families if (family.name, setting.name) in scores
        ]
        for name in entries.MODULES:
            values = [of_family[name] for of_family in found if name in of_family]
            means.setdefault(name, []).append(float(np.mean(values)) if values else float("nan"))
    order = sorted(means, key=lambda name: np.mean(means[name]))
    for place, name in enumerate(order, start=1):
        numbers = [*means[name], float(np.mean(means[name]))]
        runs = [found[name] for found in scores.values() if name in found]
        faulty = sum(is_faulty(result) for result in runs)
        rows.append([str(place), name, *(f"{number:.2f}" for number in numbers), f"{faulty} of {len(runs)}"])
    return table(rows)


def peers_of(results: dict[str, Score]) -> dict[str, Score]:
    """Returns the results of the other programs."""
    return {name: result for name, result in results.items() if not name.startswith(entries.OURS)}


def aim_row(family: Family, setting: Setting, results: dict[str, Score]) -> list[str]:
    """Returns whether revprio reaches the aim in one family."""
    ours = results[entries.OURS]
    peers = peers_of(results)
    best = min(peers, key=lambda name: peers[name].tracking_mm)
    tracking = max(ours.tracking_mm, RESOLUTION_MM) / max(peers[best].tracking_mm, RESOLUTION_MM)
    acceleration = ours.acceleration / peers[best].acceleration
    faults = ours.violations + ours.freezes + ours.failures
    recovered = recovery_text(ours) if family.recoveries_s else "–"
    met = not (faults or ours.recoveries_missed) and tracking <= TRACKING_MARGIN and acceleration <= ACCELERATION_PART
    return [
        family.title,
        setting.name,
        str(faults),
        recovered,
        best,
        f"{tracking:.2f}",
        f"{acceleration:.2f}",
        "yes" if met else "**no**",
    ]


def aim_table(scores: Scores, families: list[Family]) -> str:
    """Returns the comparison with the aim."""
    head = [
        "family",
        "setting",
        "faults",
        "recovery, s",
        "best peer in tracking",
        "tracking / its",
        "acceleration / its",
        "aim reached",
    ]
    rows = [head]
    for family in families:
        for setting in SETTINGS:
            results = scores.get((family.name, setting.name), {})
            if entries.OURS in results and peers_of(results):
                rows.append(aim_row(family, setting, results))
    return table(rows)


def fill(document: Path, mark: str, text: str) -> None:
    """Replaces the part of a Markdown file between `<!-- bench:mark -->` and `<!-- end -->`."""
    pattern = re.compile(rf"(<!-- bench:{mark} -->\n).*?(<!-- end -->)", re.DOTALL)
    source = document.read_text()
    if not pattern.search(source):
        raise ValueError(f"{document} has no part marked <!-- bench:{mark} -->")
    document.write_text(pattern.sub(lambda match: f"{match[1]}\n{text}\n{match[2]}", source))


def write(out: Path, families: list[Family], document: Path | None) -> None:
    """Prints the tables and writes `results.json`; fills the tables into the document, and writes to its folder too."""
    scores = read(out, families)
    parts = {
        "behaviour:overall": overall_table(scores, families),
        "behaviour:aim": aim_table(scores, families),
        "behaviour:runs": "\n".join(runs_table(scores, family) for family in families),
    }
    results = [
        {"family": family, "setting": setting, "controller": name, **result.as_json()}
        for (family, setting), found in scores.items()
        for name, result in found.items()
    ]
    lines = ",\n".join(json.dumps(result, ensure_ascii=False) for result in results)
    folders = [out] if document is None else [out, document.with_suffix("")]
    for folder in folders:
        folder.mkdir(exist_ok=True)
        (folder / "results.json").write_text(f"[\n{lines}\n]\n")
    for mark, text in parts.items():
        print(text)
        if document is not None:
            fill(document, mark, text)
