#!/usr/bin/env python3
"""Runs an experiment of jde on a Dask cluster, and joins the results.

    dask_experiment.py FILE OUT --scheduler-file scheduler.json

FILE and OUT are on a file system that this machine and all workers share; `jde` and its plugins are found
there as on this machine (PATH, JDE_PLUGIN_PATH). A second call goes on where the first one stopped.

A task is a part of the experiment, not one drive: `jde` reads the experiment and inspects its plugins once for
each part, which takes longer than a drive, and it writes each result when it is known. So a worker that dies
loses only the drives under way: Dask gives its part to another worker, and `--resume` keeps the others.
"""

import argparse
import subprocess
import sys
from pathlib import Path

from dask.distributed import Client, as_completed


def run_part(part, parts, file, folder):
    """Runs one part on a worker, or the rest of it."""
    command = ["jde", "experiment", file, "--shard", f"{part}/{parts}", "--out", folder]
    # One job: Dask runs as many parts at a time as the worker has threads.
    run = subprocess.run([*command, "--resume", "--jobs", "1"], capture_output=True, text=True)
    # 1 means that a drive failed, which is a result. Anything else is an error, after which Dask tries again.
    if run.returncode not in (0, 1):
        raise RuntimeError(f"part {part} ended with status {run.returncode}:\n{run.stderr}")
    return part


def main():
    options = argparse.ArgumentParser(description="Runs an experiment of jde on a Dask cluster.")
    options.add_argument("file", type=Path, metavar="FILE", help="the experiment")
    options.add_argument("out", type=Path, metavar="OUT", help="the folder of the results")
    options.add_argument("--scheduler-file", required=True, help="what `dask scheduler` wrote")
    # Several for each worker, so that all workers end at about the same time. Not the number of workers, which
    # may be another one when a second call looks for the parts of the first.
    options.add_argument("--parts", type=int, default=64, help="how many (default: 64)")
    given = options.parse_args()
    file, out = given.file.resolve(), given.out.resolve()
    out.mkdir(parents=True, exist_ok=True)

    numbers = range(1, given.parts + 1)
    folders = [str(out / f"part-{part}-of-{given.parts}") for part in numbers]
    with Client(scheduler_file=given.scheduler_file) as client:
        # Not pure: a second call must look at the files again instead of trusting a remembered answer.
        tasks = [
            client.submit(run_part, part, given.parts, str(file), folder, pure=False, retries=2)
            for part, folder in zip(numbers, folders)
        ]
        for done, task in enumerate(as_completed(tasks), start=1):
            print(f"part {task.result()} is done, {given.parts - done} left", flush=True)

    merge = ["jde", "experiment", "merge", *folders, "--out", str(out / "all"), "--replace"]
    return subprocess.run(merge).returncode


if __name__ == "__main__":
    sys.exit(main())
