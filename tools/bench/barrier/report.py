"""Tables of the results in Markdown, and the results as JSON."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
from behaviour.report import fill

from barrier import entries
from barrier.plant import DRIVES, LAGGING, PERFECT, Drive
from barrier.scenes import PANDA, SCENES, STARTS, Scene, Start
from barrier.score import Score, score
from barrier.simulate import Record

Runs = dict[tuple[str, str, str, str], Score]
"""Scores by entry, scene, start and drive."""

DEEPER_MM = 0.005
"""Distance by which an arm may come nearer than at its start without being marked, mm."""
NAMES = [name for name in entries.ENTRIES if name != entries.HTTP]


def table(rows: list[list[str]], words: int) -> str:
    """Returns a Markdown table; the first row is its head, and all but the first columns (`words`) are numbers."""
    head, *body = rows
    rule = ["---" if number < words else "---:" for number in range(len(head))]
    return "\n".join("| " + " | ".join(row) + " |" for row in [head, rule, *body]) + "\n"


def read(out: Path) -> Runs:
    """Returns the scores of all recorded runs."""
    runs: Runs = {}
    for name in NAMES:
        for scene in SCENES:
            for start in STARTS:
                for drive in DRIVES:
                    path = entries.path_of(out, name, scene, start, drive)
                    if path.exists():
                        record = Record.load(path)
                        runs[name, scene.name, start.name, drive.name] = score(record, scene)
    return runs


def bold(text: str, is_bad: bool) -> str:
    """Returns a text, bold if it is bad."""
    return f"**{text}**" if is_bad else text


def zero(text: str) -> str:
    """Returns a number without the sign of a zero."""
    return text.lstrip("-") if float(text) == 0 else text


def millimetres(value: float) -> str:
    """Returns a distance."""
    return zero(f"{value:.2f}")


def over_limit(value: float) -> str:
    """Returns an acceleration as a multiple of its limit."""
    return bold(f"{value:.2f}" if value < 10 else f"{value:.0f}", value > 1.001)


def scene_table(runs: Runs, scene: Scene, starts: tuple[Start, ...], drive: Drive) -> str:
    """Returns the runs of one scene."""
    rows = [
        [
            "start",
            "program",
            "least distance, mm",
            "at the end, mm",
            "acceleration / limit",
            "refused, of 800",
            "error at the end, mm",
            "rests",
        ]
    ]
    for start in starts:
        for name in NAMES:
            result = runs.get((name, scene.name, start.name, drive.name))
            if result is None:
                continue
            is_outside = start.distance_m is None
            is_bad = result.is_too_near if is_outside else result.deeper_mm > DEEPER_MM
            rows.append(
                [
                    start.name,
                    name,
                    bold(millimetres(result.least_mm), is_bad),
                    bold(millimetres(result.end_mm), not result.has_left),
                    over_limit(result.acceleration_over_limit),
                    bold(str(result.refused), result.refused > 0),
                    bold(f"{result.error_mm:.1f}", not result.reached),
                    "yes" if result.rests else "**no**",
                ]
            )
    return f"### {scene.title}, {drive.name} drive\n\n{table(rows, 2)}"


def result_table(runs: Runs) -> str:
    """Returns what each program does over all runs."""
    rows = [
        [
            "program",
            "outside: least distance, mm",
            "too near",
            "reached",
            "too near at the start: left",
            "went deeper, mm",
            "acceleration / limit",
            "refused",
        ]
    ]
    for name in NAMES:
        of_name = {key[1:]: result for key, result in runs.items() if key[0] == name}
        outside = [result for key, result in of_name.items() if key[1] == STARTS[0].name]
        inside = [result for key, result in of_name.items() if key[1] != STARTS[0].name]
        if not outside:
            rows.append([name, "no runs", *[""] * 6])
            continue
        too_near = sum(result.is_too_near for result in outside)
        reached = sum(result.reached for result in outside)
        left = sum(result.has_left for result in inside)
        deeper = max((result.deeper_mm for result in inside), default=0.0)
        refused = sum(result.refused for result in of_name.values())
        rows.append(
            [
                name,
                bold(millimetres(min(result.least_mm for result in outside)), too_near > 0),
                bold(f"{too_near} of {len(outside)}", too_near > 0),
                bold(f"{reached} of {len(outside)}", reached < len(outside)),
                bold(f"{left} of {len(inside)}", left < len(inside)),
                bold(millimetres(deeper), deeper > DEEPER_MM),
                over_limit(max(result.acceleration_over_limit for result in of_name.values())),
                bold(f"{refused} of {800 * len(of_name)}", refused > 0),
            ]
        )
    return table(rows, 1)


def speed_table(out: Path) -> str:
    """Returns the times of a step of the Panda that starts outside."""
    times = {}
    for name in entries.ENTRIES:
        path = entries.path_of(out, name, PANDA, STARTS[0], PERFECT)
        if path.exists():
            step_s = Record.load(path).step_s
            times[name] = (float(np.median(step_s)), float(np.quantile(step_s, 0.99)))
    if entries.OURS not in times:
        return ""
    base = times[entries.OURS]
    rows = [["program", "median, µs", "99 %, µs", "median / revprio", "99 % / revprio"]]
    for name, (median, high) in sorted(times.items(), key=lambda item: item[1]):
        ratios = [f"{median / base[0]:.2f}", f"{high / base[1]:.2f}"]
        rows.append([name, f"{1e6 * median:.0f}", f"{1e6 * high:.0f}", *ratios])
    return table(rows, 1)


def write(out: Path, document: Path | None) -> None:
    """Prints the tables and writes `results.json`; fills the tables into the document, and writes to its folder too."""
    runs = read(out)
    parts = {
        "barrier:result": result_table(runs),
        "barrier:runs": "\n".join(scene_table(runs, scene, STARTS, PERFECT) for scene in SCENES),
        "barrier:lag": "\n".join(scene_table(runs, scene, STARTS, LAGGING) for scene in SCENES),
        "barrier:speed": speed_table(out),
    }
    results = [
        {"program": name, "scene": scene, "start": start, "drive": drive, **result.as_json()}
        for (name, scene, start, drive), result in runs.items()
    ]
    lines = ",\n".join(json.dumps(result, ensure_ascii=False) for result in results)
    for folder in [out] if document is None else [out, document.with_suffix("")]:
        folder.mkdir(exist_ok=True)
        (folder / "results.json").write_text(f"[\n{lines}\n]\n")
    for mark, text in parts.items():
        print(text)
        if document is not None:
            fill(document, mark, text)
