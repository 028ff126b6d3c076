"""Command line: `python -m behaviour simulate` runs controllers, `report` prints the tables. See `run`."""

from __future__ import annotations

import argparse
import functools
import time
from pathlib import Path

from behaviour import arm as model
from behaviour import entries, report, simulate
from behaviour.controllers.base import SETTINGS
from behaviour.families import Family, families


def run_all(out: Path, names: list[str], chosen: list[Family]) -> None:
    """Runs the entries in all settings and families and saves the records."""
    urdf = model.urdf_for_peers(out)
    for name in names:
        make = functools.partial(entries.make, name, urdf)
        for setting in SETTINGS:
            controller = make(setting)
            try:
                simulate.check_kinematics(controller)
            finally:
                controller.close()
            start_s = time.monotonic()
            for family in chosen:
                simulate.run(make, family, setting).save(entries.path_of(out, name, setting, family.name))
            print(f"{name}, {setting.name}: {time.monotonic() - start_s:.1f} s", flush=True)


def main() -> None:
    """Parses the arguments."""
    parser = argparse.ArgumentParser(prog="behaviour", description=__doc__)
    parser.add_argument("action", choices=("simulate", "report"))
    parser.add_argument("--out", type=Path, required=True, help="folder of the recorded runs")
    parser.add_argument("--entries", nargs="+", default=list(entries.MODULES), choices=list(entries.MODULES))
    parser.add_argument("--families", nargs="*", help="names of families; default: all")
    parser.add_argument("--quick", action="store_true", help="only the first 2 s of each family: a smoke test")
    parser.add_argument("--document", type=Path, help="Markdown file whose marked parts are replaced")
    arguments = parser.parse_args()
    chosen = [family for family in families(arguments.quick) if family.name in (arguments.families or family.name)]
    if arguments.action == "simulate":
        run_all(arguments.out, arguments.entries, chosen)
    else:
        report.write(arguments.out, chosen, arguments.document)


if __name__ == "__main__":
    main()
