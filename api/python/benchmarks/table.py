"""Prints a table of the lines of `steps.py`: `python table.py LINES`.

Each program has a line in each round. Times are medians over the rounds. A ratio is the median of the ratios to revprio
in the same round, so that a disturbance of a round affects both.
"""

import sys
from pathlib import Path
from statistics import median

OURS = "revprio"


def table(lines: list[str]) -> str:
    """Returns the table, the fastest program first."""
    rounds: dict[str, list[list[str]]] = {}
    for line in lines:
        name, *numbers = line.split(",")
        rounds.setdefault(name, []).append(numbers)
    ours = [float(numbers[0]) for numbers in rounds[OURS]]
    rows = []
    for name, all_numbers in rounds.items():
        medians = [float(numbers[0]) for numbers in all_numbers]
        ratio = median(time / own for time, own in zip(medians, ours, strict=True))
        p99 = median(float(numbers[1]) for numbers in all_numbers)
        cells = [f"{median(medians):.1f}", f"{p99:.1f}", f"{ratio:.2g}", *all_numbers[0][2:]]
        rows.append((median(medians), f"| {name} | {' | '.join(cells)} |"))
    head = [
        "| program | median (µs) | 99 % (µs) | median × revprio | largest limit violation (rad/s) "
        "| largest deviation of the first task (m/s) |",
        "|---|---|---|---|---|---|",
    ]
    return "\n".join([*head, *(row for _, row in sorted(rows))])


if __name__ == "__main__":
    print(table(Path(sys.argv[1]).read_text(encoding="utf-8").splitlines()))
