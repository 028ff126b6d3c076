"""A sweep in shards, with a worker killed in the middle, gives the table of the sweep without shards.

Usage: sweep.py ray|slurm DIRECTORY PROGRAM. DIRECTORY is that of the scripts for clusters. `slurm` needs a running Slurm,
for example that of `tests/scale/slurm`.
"""

from __future__ import annotations

import contextlib
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
PATIENCE_S = 300.0  # without progress


def check(holds: bool, message: str) -> None:
    if not holds:
        sys.exit(f"sweep: {message}")


def wait_for(what: str, out: Path, is_so: Callable[[], object]) -> None:
    """Waits as long as files below `out` are written: a busy machine is slow, and no error."""
    seen, end_s = 0, 0.0
    while not is_so():
        if seen != (written := bytes_below(out)):
            seen, end_s = written, time.monotonic() + PATIENCE_S
        check(time.monotonic() < end_s, f"{what} did not happen")
        time.sleep(0.01)


def bytes_below(out: Path) -> int:
    """Returns the size of all files, plus one. Files may vanish meanwhile."""
    size = 1
    for path in out.rglob("*"):
        with contextlib.suppress(FileNotFoundError):
            size += path.stat().st_size
    return size


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
    wait_for("the first cell", out, lambda: has_rows(directory / f"sweep-stiff_wall.2-of-{SHARDS}.partial"))
    (process,) = processes_of(f"2/{SHARDS}")
    os.kill(parent(process), signal.SIGKILL)
    wait_for("the end of the sweep", out, lambda: run.poll() is not None)
    check(run.returncode == 0, "the script failed")
    check("already completed" in (directory / "log").read_text(), "the killed shard did not continue")


def with_slurm(scripts: Path, program: str, out: Path) -> None:
    """Submits the array and its merge; one task is killed and queued again, as after the failure of its node."""
    shards, log = out / "shards", f"{out}/%x-%a.log"
    shards.mkdir(parents=True)
    environment = os.environ | {"OUT": str(out), "REVPRIO": program}

    def slurm(*command: object) -> str:
        words = [str(word) for word in command]
        return subprocess.run(words, env=environment, check=True, stdout=subprocess.PIPE, text=True).stdout.strip()

    submit = ["sbatch", "--parsable", "--chdir", out]
    job = slurm(*submit, f"--array=1-{SHARDS}", "--output", log, scripts / "sweep.slurm", *SWEEP)
    merge = '"$REVPRIO" sweep --out "$OUT" --merge "$OUT"/shards/*.parquet'
    slurm(*submit, f"--dependency=afterok:{job}", "--output", f"{out}/merge.log", "--wrap", merge)
    wait_for("the first cell", out, lambda: has_rows(shards / f"sweep-stiff_wall.2-of-{SHARDS}.partial"))
    slurm("scontrol", "requeue", f"{job}_2")
    wait_for("the end of the jobs", out, lambda: not slurm("squeue", "--noheader"))
    logs = "".join(path.read_text() for path in sorted(out.glob("*.log")))
    check((out / TABLE).exists(), f"the merge failed: {logs}")
    said = (out / "revprio-sweep-2.log").read_text()
    check("already completed" in said, f"the killed task did not continue: {said}")


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
