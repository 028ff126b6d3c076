"""The commands of docs/guides/ros2.md run, and print what the page shows."""

import re
import shlex
import subprocess
from functools import partial

import numpy as np
import pytest
from harness import REPOSITORY, free_port, until
from revprio_ros.parameters import PARAMETERS

PAGE = (REPOSITORY / "docs/guides/ros2.md").read_text()
MARK = "<!-- not run: tests/ros2/run runs it -->"
BLOCK = re.compile(rf"{re.escape(MARK)}\n```sh\n(?P<commands>.*?)```(?:\n\n```text\n(?P<output>.*?)```)?", re.DOTALL)


@pytest.fixture
def clone(lab):
    """A directory with the contents of the repository."""
    directory = lab.directory / "clone"
    directory.mkdir()
    for entry in REPOSITORY.iterdir():
        if entry.name != "target" and not entry.name.startswith("."):
            (directory / entry.name).symlink_to(entry)
    return directory


def is_printed(pattern, process):
    return pattern.search(process.output())


def test_the_commands_run_and_print_the_shown_output(lab, arm, clone):
    running = {}
    port = free_port()
    outputs = 0
    for block in BLOCK.finditer(PAGE):
        *before, last = block["commands"].replace("127.0.0.1:8080", f"127.0.0.1:{port}").strip().splitlines()
        subprocess.run(["bash", "-euo", "pipefail", "-c", "\n".join(before)], cwd=clone, check=True)
        program = " ".join(shlex.split(last)[:3])
        if program in running:
            assert running[program].stop()[0] == 0
        listen = f" --listen 127.0.0.1:{port}" if program == "revprio serve" else ""
        process = lab.start(["bash", "-c", f"cd {shlex.quote(str(clone))} && exec {last}{listen}"])
        running[program] = process
        if block["output"]:
            shown = block["output"].replace("127.0.0.1:8080", f"127.0.0.1:{port}").strip()
            pattern = re.compile(".*".join(map(re.escape, shown.split("…"))), re.DOTALL)
            until(partial(is_printed, pattern, process), f"{shown}\nis printed by\n{last}")
            outputs += 1
        if outputs == 1:
            until(lambda: abs(np.linalg.norm(arm.force) - 20) < 1, "20 N at the wall")
    assert outputs == 2
    assert len(running) == 3


def test_the_page_lists_all_parameters_with_their_ranges():
    rows = {
        cells[1].strip().strip("`"): cells[3].strip()
        for cells in (line.split("|") for line in PAGE.splitlines() if line.startswith("| `"))
        if len(cells) == 6
    }
    assert set(PARAMETERS) <= set(rows)
    for name, (_, _, limits) in PARAMETERS.items():
        if name == "period_s":
            assert rows[name] == "0.001 to 0.1"
        else:
            assert rows[name] == (f"{limits[0]:g} to {limits[1]:g}" if limits else ""), name
