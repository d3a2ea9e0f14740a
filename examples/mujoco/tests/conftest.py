"""The programs that the tests use, those of the folder JDE_TEST_BIN, and a room for robots."""

import os
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
BIN = Path(os.environ.get("JDE_TEST_BIN", str(ROOT / "target/debug")))
ROOM = """
name   = "room"
walls  = [{ name = "wall", points = [[-3, -3], [3, -3], [3, 3], [-3, 3]], closed = true }]
boxes  = [{ name = "box", center = [-1, 2], size = [0.4, 0.4] }]
movers = [{ name = "cart", radius = 0.2, way = [[-2, -2], [2, -2]], speed = 0.5 }]

[robots.robot]
start = { x = 0, y = 0, heading_deg = 0 }
"""


@pytest.fixture(autouse=True)
def _programs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(BIN), prepend=os.pathsep)
    monkeypatch.setenv("JDE_PLUGIN_PATH", str(BIN))


@pytest.fixture
def room(tmp_path: Path) -> Path:
    """Return the file of a square room with its middle at the origin."""
    file = tmp_path / "room.toml"
    file.write_text(ROOM)
    return file
