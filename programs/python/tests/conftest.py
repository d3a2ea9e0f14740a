"""The programs and plugins that the tests use, those of the folder JDE_TEST_BIN, and applications to try."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
BIN = Path(os.environ.get("JDE_TEST_BIN", str(ROOT / "target/debug")))
# A hundred times the usual time of a run.
PATIENCE = 120

WORLD = """
name  = "room"
walls = [{ name = "wall", points = [[0, 0], [6, 0], [6, 4], [0, 4]], closed = true }]

[robots.pioneer]
start = { x = 4, y = 1.5, heading_deg = 0 }
"""
# `ahead` drives towards the wall unless the schema in Python acts.
APPLICATION = """
name  = "try"
roots = ["mine", "ahead"]

[schemas.pioneer]
type  = "sim/robot"
world = "world.toml"

[schemas.mine]
type      = "{file}"
imports   = {{ laser = "pioneer.laser" }}
actuators = {{ base = "pioneer.velocity" }}
{more}

[schemas.ahead]
type      = "family/hijo2"
imports   = {{ laser = "pioneer.laser" }}
actuators = {{ base = "pioneer.velocity" }}
speed     = "20 cm/s"
period    = "100ms"
"""
HEAD = """
from jde import Actuator, Import, Modulation, Schema, modulation, trigger
from jde import types as t

class Mine(Schema, kind="motor", period="100ms"):
    laser: Import[t.LaserScan] = trigger()
    base: Actuator[t.Twist]
"""


@dataclass
class Result:
    """What a run printed, and its status."""

    status: int
    text: str


class Robot:
    """A folder with an application of one schema in Python."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        (folder / "world.toml").write_text(WORLD)

    def write(self, source: str, *, file: str = "mine.py", more: str = "") -> None:
        """Write the schema, and the application that uses it."""
        path = self.folder / file.removesuffix("/Mine")
        path.parent.mkdir(exist_ok=True)
        path.write_text(source)
        (self.folder / "app.toml").write_text(APPLICATION.format(file=file, more=more))

    @property
    def environment(self) -> dict[str, str]:
        """The environment of programs."""
        return {"JDE_PYTHON": sys.executable, **os.environ, "JDE_PLUGIN_PATH": str(BIN)}

    def jde(self, *arguments: str, **environment: str) -> Result:
        """Run a verb."""
        done = subprocess.run(
            [str(BIN / "jde"), *arguments],
            cwd=self.folder,
            env={**self.environment, **environment},
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            timeout=PATIENCE,
            check=False,
        )
        return Result(done.returncode, done.stdout)

    def drive(self, seconds: int = 6, *more: str) -> Result:
        """Run the application in lockstep."""
        return self.jde("run", "app.toml", "--lockstep", "--for", f"{seconds}s", *more)


@pytest.fixture(autouse=True)
def _programs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(BIN), prepend=os.pathsep)
    monkeypatch.setenv("JDE_PLUGIN_PATH", str(BIN))


@pytest.fixture
def navigation() -> Path:
    """Return the application of safe navigation: four schemas and a simulated Pioneer."""
    return ROOT / "apps/safe-navigation.toml"


@pytest.fixture
def reach() -> Path:
    """Return the application of the page on runs: a bare robot, and a schema that a policy replaces."""
    return ROOT / "examples/python/reach.toml"


@pytest.fixture
def robot(tmp_path: Path) -> Robot:
    """A robot without a schema."""
    return Robot(tmp_path)


@pytest.fixture
def body(robot: Robot) -> Callable[..., Result]:
    """Drives with a schema whose class has this body."""

    def drive(text: str, *, more: str = "", head: str = HEAD) -> Result:
        lines = "".join(f"    {line}\n" for line in text.splitlines())
        robot.write(head + lines, more=more)
        return robot.drive()

    return drive
