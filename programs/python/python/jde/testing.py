"""Lets pytest run the drives of an application too: each file of a folder `tests` that `jde test` would run is a test.

A `conftest.py` in the folder of the application or above it imports the hook: `from jde.testing import pytest_collect_file`.
The package does not state it as an entry point: pytest would compile its modules anew, into files that `pip` leaves behind.
"""

from __future__ import annotations

import re
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from jde import _executable

#: The folder of the drives, as `jde test` has it.
FOLDER = "tests"

#: The files that a collector has. Several plugins may have the hook: this module, and each `conftest.py`.
COLLECTED = pytest.StashKey[set[Path]]()


class DriveFailed(Exception):
    """A drive did not pass."""


class DriveFile(pytest.File):
    """A file of drives."""

    def collect(self) -> Iterator[Drive]:
        """Return its one test. With axes it has several drives, which pass or fail together."""
        name = re.search(r'^name\s*=\s*"([^"]*)"', self.path.read_text(), re.MULTILINE)
        yield Drive.from_parent(self, name=self.path.stem if name is None else name[1])


class Drive(pytest.Item):
    """The drives of a file."""

    def runtest(self) -> None:
        """Run them by `jde test`."""
        command = _executable.command("test", str(self.path), "--color", "never")
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
        if done.returncode != 0:
            raise DriveFailed(done.stdout)

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None) -> str:
        """Return what `jde test` said."""
        if isinstance(excinfo.value, DriveFailed):
            return str(excinfo.value)
        return str(super().repr_failure(excinfo, style))

    def reportinfo(self) -> tuple[Path, None, str]:
        """Return its file and its name."""
        return self.path, None, self.name


def pytest_collect_file(file_path: Path, parent: pytest.Collector) -> DriveFile | None:
    """Collect a file of a folder `tests` that names an application."""
    if file_path.suffix != ".toml" or file_path.parent.name != FOLDER:
        return None
    try:
        names_one = re.search(r"^application\s*=", file_path.read_text(), re.MULTILINE)
    except (OSError, UnicodeDecodeError):
        return None
    collected = parent.stash.setdefault(COLLECTED, set())
    is_known = file_path in collected and not parent.config.getoption("keepduplicates")
    if names_one is None or is_known:
        return None
    collected.add(file_path)
    return DriveFile.from_parent(parent, path=file_path)
