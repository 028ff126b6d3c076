"""Recordings of simulated runs as CSV files: `python -m behaviour.traces --out FOLDER --to FOLDER`.

The page of the service shows them as ghosts; docs/dashboard.md describes the format.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from behaviour import arm as model
from behaviour import entries
from behaviour.controllers.base import SETTINGS, Setting
from behaviour.families import PERIOD_S, Family, families
from behaviour.simulate import Record

SETTING = SETTINGS[1]
"""Real conditions with measured positions."""
STEP = 5
"""Periods between two rows: 20 rows per second keep a file small."""


def csv_of(record: Record, name: str, family: Family, setting: Setting) -> str:
    """Returns time, joint positions and the place of the target, one row per `STEP` periods."""
    lines = [
        f"# {name}, {family.title}, {setting.name}; tools/bench/behaviour/run --traces",
        ",".join(["time_s", *model.load().names, "target_x_m", "target_y_m", "target_z_m"]),
    ]
    for number in range(0, len(record.position), STEP):
        time_s = number * PERIOD_S
        place = family.pose(time_s)[:3, 3]
        values = [f"{time_s:.2f}"] + [text_of(value, 5) for value in record.position[number]]
        lines.append(",".join(values + [text_of(value, 4) for value in place]))
    return "\n".join(lines) + "\n"


def text_of(value: float, digits: int) -> str:
    """Returns a number without trailing zeros and without a negative zero."""
    return np.format_float_positional(round(float(value), digits) + 0.0, trim="-")


def main() -> None:
    """Writes one file per entry and family."""
    parser = argparse.ArgumentParser(prog="behaviour.traces", description=__doc__)
    parser.add_argument("--out", type=Path, required=True, help="folder of the recorded runs")
    parser.add_argument("--to", type=Path, required=True, help="folder of the CSV files")
    parser.add_argument("--entries", nargs="+", required=True, choices=list(entries.MODULES))
    parser.add_argument("--families", nargs="+", required=True, help="names of families")
    arguments = parser.parse_args()
    arguments.to.mkdir(parents=True, exist_ok=True)
    for family in (family for family in families(quick=False) if family.name in arguments.families):
        for name in arguments.entries:
            record = Record.load(entries.path_of(arguments.out, name, SETTING, family.name))
            path = arguments.to / f"{family.name}-{name.replace(',', '').replace(' ', '_')}.csv"
            path.write_text(csv_of(record, name, family, SETTING))
            print(f"{path}: {path.stat().st_size} bytes")


if __name__ == "__main__":
    main()
