"""Experiments: one application driven many times in processes of their own."""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path
from typing import TYPE_CHECKING, Any

from jde import _executable, _jde

if TYPE_CHECKING:
    import pandas as pd

#: The exit statuses of an experiment whose drives all passed, and of one with a drive that failed.
JUDGED = (0, 1)


class Results:
    """The results of an experiment: a dictionary for each drive, and the folder with the table and the page."""

    def __init__(self, folder: str | os.PathLike[str]) -> None:
        """Read the results in a folder that `jde experiment` has written."""
        self.folder = Path(folder)
        lines = (self.folder / "results.jsonl").read_text(encoding="utf-8").splitlines()
        self.drives: list[dict[str, Any]] = [json.loads(line) for line in lines]

    @property
    def passed(self) -> bool:
        """Whether every drive passed."""
        return all(drive["outcome"] == "passed" for drive in self.drives)

    def frame(self) -> pd.DataFrame:
        """Return a row for each drive: its number, the axes, the outcome, properties and measures. Needs pandas."""
        import pandas as pd

        return pd.read_csv(self.folder / "results.csv")

    def _repr_html_(self) -> str:
        return str(self.frame().to_html())


def experiment(
    file: str | os.PathLike[str], *, jobs: int | None = None, out: str | os.PathLike[str] | None = None
) -> Results:
    """Drive an experiment of a file, `jobs` processes at a time, and return its results.

    They are in the folder `out`, where they replace others; by default in `results/NAME`, whose earlier results are kept
    in `results/NAME.before`.
    """
    command = _executable.command("experiment", os.fspath(file))
    command += [] if out is None else ["--out", os.fspath(out), "--replace"]
    command += [] if jobs is None else ["--jobs", str(jobs)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode not in JUDGED:
        raise _jde.Error(done.stderr.strip())
    # The last line names the page.
    return Results(Path(done.stdout.splitlines()[-1]).parent)
