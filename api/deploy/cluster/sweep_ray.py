"""Runs `revprio sweep` in shards on a Ray cluster and merges the tables.

    pip install ray
    python sweep_ray.py --shards 16 --out revprio-out -- stiff_wall --vary loop.lag_s=lin:0..0.005:60

Every node needs the program `revprio`, and a scenario file at the same path if it is not a built-in scenario. Nodes need
no common file system. A shard whose worker ends is run again; where it finds its completed cells, it continues.
"""

from __future__ import annotations

import argparse
import subprocess
from pathlib import Path

import ray


@ray.remote(max_retries=5)
def run_shard(program: str, sweep: list[str], number: int, count: int, out: str) -> tuple[str, bytes]:
    """Runs one shard on one core. Returns name and content of its table."""
    directory = Path(out) / "shards" / f"{number}-of-{count}"
    directory.mkdir(parents=True, exist_ok=True)
    shard = ["--shard", f"{number}/{count}", "--threads", "1", "--out", str(directory)]
    with (directory / "log").open("ab") as log:
        # The program ends with its worker, so that two of them never run the same shard.
        command = ["setpriv", "--pdeathsig", "KILL", program, "sweep", *sweep, *shard]
        subprocess.run(command, check=True, stdout=log, stderr=log)
    (table,) = directory.glob("*.parquet")
    return table.name, table.read_bytes()


def main() -> None:
    """Runs all shards and merges their tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--shards", type=int, required=True, help="number of parts; some for each core of the cluster")
    parser.add_argument("--out", default="revprio-out", help="directory for table and figures")
    parser.add_argument("--program", default="revprio")
    parser.add_argument("--address", help="Ray cluster; default: the running one, or a new one on this machine")
    parser.add_argument("sweep", nargs="+", help="arguments of `revprio sweep`, after --")
    options = parser.parse_args()
    ray.init(address=options.address)
    out = Path(options.out).absolute()
    numbers = range(1, options.shards + 1)
    shards = [run_shard.remote(options.program, options.sweep, i, options.shards, str(out)) for i in numbers]
    tables = []
    (out / "tables").mkdir(parents=True, exist_ok=True)
    for name, content in ray.get(shards):
        tables.append(out / "tables" / name)
        tables[-1].write_bytes(content)
    subprocess.run([options.program, "sweep", "--out", out, "--merge", *tables], check=True)


if __name__ == "__main__":
    main()
