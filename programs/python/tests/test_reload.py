"""Files that change while the robot drives."""

from __future__ import annotations

import os
import select
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from conftest import BIN, PATIENCE, Robot

FILE = """
from jde import Export, Schema

class Mine(Schema, kind="perceptive", period="50ms"):
    number: Export[float]

    def iterate(self, cx):
        self.number.write(1.0)

class Other(Schema, kind="perceptive", period="50ms"):
    number: Export[float]

    def iterate(self, cx):
        self.number.write(1.0)
"""
# An instance has the name of the file.
APPLICATION = """
name  = "try"
roots = ["stay"]
awake = ["mine", "other"]

[schemas.pioneer]
type  = "sim/robot"
world = "world.toml"

[schemas.mine]
type = "mine.py/Mine"

[schemas.other]
type = "mine.py/Other"

[schemas.stay]
type      = "family/hijo2"
imports   = { laser = "pioneer.laser" }
actuators = { base = "pioneer.velocity" }
"""


class Watched:
    """An application that runs with `--watch`."""

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        (robot.folder / "mine.py").write_text(FILE)
        (robot.folder / "app.toml").write_text(APPLICATION)
        self._program = subprocess.Popen(
            [str(BIN / "jde"), "run", "app.toml", "--plain", "--watch", "--for", f"{PATIENCE}s"],
            cwd=robot.folder,
            env=robot.environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            bufsize=0,
        )
        self.shown = ""

    def until_running(self) -> None:
        """Wait until the schemas publish."""
        while self.robot.jde("watch", "other.number", "--count", "1").status != 0:
            pass

    def until_reloaded(self, times: int) -> None:
        """Read until the run has said so often of each schema that it was reloaded."""
        self.until(lambda shown: all(shown.count(f"{schema} reloaded: runs") >= times for schema in ("mine", "other")))

    def until(self, holds: Callable[[str], bool]) -> None:
        """Read until this holds of what the run has said."""
        assert self._program.stdout is not None
        while not holds(self.shown):
            assert select.select([self._program.stdout], [], [], PATIENCE)[0], self.shown
            read = os.read(self._program.stdout.fileno(), 4096)
            assert read, self.shown
            self.shown += read.decode()

    def close(self) -> None:
        """End the run."""
        self._program.terminate()
        self._program.communicate()


@pytest.fixture
def watched(robot: Robot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Watched]:
    """Run the application."""
    monkeypatch.setenv("JDE_RUNTIME_DIR", str(tmp_path / "run"))
    watched = Watched(robot)
    yield watched
    watched.close()


def test_every_schema_of_a_changed_file_is_reloaded(watched: Watched) -> None:
    watched.until_running()
    file = watched.robot.folder / "mine.py"
    file.write_text(FILE.replace("1.0", "2.0"))
    watched.until_reloaded(1)
    file.write_text(FILE.replace("1.0", "3.0"))
    reloaded = watched.robot.jde("reload", "mine")
    assert "mine" in reloaded.text and "other" in reloaded.text, "the name of one of them is that of the file"
    watched.until_reloaded(2)
    numbers = [watched.robot.jde("get", f"{schema}.number").text.strip() for schema in ("mine", "other")]
    assert numbers == ["3", "3"]


def test_a_module_beside_the_file_is_a_part_of_it(watched: Watched) -> None:
    watched.until_running()
    folder = watched.robot.folder
    (folder / "helper.py").write_text("NUMBER = 4.0\n")
    (folder / "mine.py").write_text("import helper\n" + FILE.replace("1.0", "helper.NUMBER"))
    watched.until_reloaded(1)
    (folder / "helper.py").write_text("NUMBER = 5.0\n")
    watched.until_reloaded(2)
    assert watched.robot.jde("get", "other.number").text.strip() == "5"


def test_a_file_that_cannot_be_read_is_an_event_with_the_whole_error(watched: Watched) -> None:
    watched.until_running()
    (watched.robot.folder / "mine.py").write_text(FILE + "\ndef broken(:\n")
    watched.until(lambda shown: shown.count("SyntaxError") >= 2)
    assert "def broken(:" in watched.shown and "reload-undone" in watched.shown, watched.shown
    events = watched.robot.jde("events", "--once").text
    assert events.count("SyntaxError") == 2 and "def broken(:" in events, events
