"""A sweep in shards, with a worker killed in the middle, gives the table of the sweep without shards.

Usage: sweep.py ray|slurm DIRECTORY PROGRAM. DIRECTORY is that of the scripts for clusters.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

SWEEP = ["stiff_wall", "--vary", "environment.stiffness=log:1e3..1e5:6", "--vary", "loop.lag_s=0,0.002,0.005"]
SHARDS = 3
TABLE = "sweep-stiff_wall.parquet"
PATIENCE_S = 300.0


def check(holds: bool, message: str) -> None:
    if not holds:
        sys.exit(f"sweep: {message}")


def wait_for(what: str, is_so: Callable[[], object]) -> None:
    end_s = time.monotonic() + PATIENCE_S
    while not is_so():
        check(time.monotonic() < end_s, f"{what} did not happen")
        time.sleep(0.01)


def processes_of(shard: str) -> list[int]:
    """Returns the process ids of the sweep of a shard."""
    found = []
    for path in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            words = path.read_bytes().split(b"\0")
        except OSError:
            continue
        if b"sweep" in words and shard.encode() in words:
            found.append(int(path.parent.name))
    return found


def parent(process: int) -> int:
    return int(Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[1])


def has_rows(partial: Path) -> bool:
    """Returns whether a shard has completed a cell; the first line is the identity of the sweep."""
    return partial.exists() and partial.read_bytes().count(b"\n") >= 2


def with_ray(scripts: Path, program: str, out: Path) -> None:
    arguments = ["--shards", str(SHARDS), "--out", out, "--program", program, "--", *SWEEP]
    run = subprocess.Popen([sys.executable, scripts / "sweep_ray.py", *arguments])
    directory = out / "shards" / f"2-of-{SHARDS}"
    wait_for("the first cell", lambda: has_rows(directory / f"sweep-stiff_wall.2-of-{SHARDS}.partial"))
    (process,) = processes_of(f"2/{SHARDS}")
    os.kill(parent(process), signal.SIGKILL)
    wait_for("the end of the sweep", lambda: run.poll() is not None)
    check(run.returncode == 0, "the script failed")
    check("already completed" in (directory / "log").read_text(), "the killed shard did not continue")


def with_slurm(scripts: Path, program: str, out: Path) -> None:
    """Runs the script as the tasks of an array, with the environment that Slurm gives them."""
    shards = out / "shards"
    shards.mkdir(parents=True)

    def task(number: int) -> subprocess.Popen:
        array = {"SLURM_ARRAY_TASK_ID": str(number), "SLURM_ARRAY_TASK_COUNT": str(SHARDS)}
        environment = os.environ | array | {"OUT": str(out), "REVPRIO": program}
        return subprocess.Popen([scripts / "sweep.slurm", *SWEEP], env=environment, stderr=subprocess.PIPE, text=True)

    tasks = {number: task(number) for number in range(1, SHARDS + 1)}
    wait_for("the first cell", lambda: has_rows(shards / f"sweep-stiff_wall.2-of-{SHARDS}.partial"))
    tasks[2].kill()
    tasks[2].communicate()
    tasks[2] = task(2)
    said = {number: run.communicate()[1] for number, run in tasks.items()}
    check(all(run.returncode == 0 for run in tasks.values()), f"a task failed: {said}")
    check("already completed" in said[2], "the killed task did not continue")
    tables = sorted(shards.glob("*.parquet"))
    subprocess.run([program, "sweep", "--out", out, "--merge", *tables], check=True)


def main(engine: str, scripts: str, program: str) -> None:
    with tempfile.TemporaryDirectory() as directory:
        whole, out = Path(directory) / "whole", Path(directory) / "out"
        subprocess.run([program, "sweep", *SWEEP, "--out", whole], check=True, stdout=subprocess.DEVNULL)
        start_s = time.monotonic()
        {"ray": with_ray, "slurm": with_slurm}[engine](Path(scripts), program, out)
        check((out / TABLE).read_bytes() == (whole / TABLE).read_bytes(), "the tables differ")
        print(f"{engine}: the same table after a worker was killed, {time.monotonic() - start_s:.0f} s")


if __name__ == "__main__":
    main(*sys.argv[1:])
