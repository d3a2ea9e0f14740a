"""Plugins that distributions of Python state as entry points."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path

import pytest

from conftest import HEAD, Robot
from jde._load import entry_points, load

SOURCE = (
    HEAD.replace("\nfrom jde", "\nfrom . import speeds\nfrom jde", 1)
    + """
    def iterate(self, cx):
        self.base.command(t.Twist.planar(speeds.SLOW, 0.0))
"""
)


@pytest.fixture
def installed(robot: Robot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Robot:
    """A robot, and a distribution with the plugin `slow-motion` in its package `motion`."""
    site = tmp_path / "site"
    for file, text in {
        "motion/__init__.py": "",
        "motion/slow.py": SOURCE,
        "motion/speeds.py": "SLOW = 0.1",
        "motion-1.0.dist-info/METADATA": "Name: motion\nVersion: 1.0\n",
        "motion-1.0.dist-info/entry_points.txt": "[jde.schemas]\nslow-motion = motion.slow\nlost = lost.module\n",
    }.items():
        path = site / file
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(filter(None, [str(site), os.environ.get("PYTHONPATH")])))
    return robot


def test_an_entry_point_is_found_by_its_name_described_and_listed(installed: Robot) -> None:
    described = installed.jde("describe", "slow-motion", "--json")
    assert described.status == 0, described.text
    assert json.loads(described.text)["name"] == "slow-motion"
    listed = installed.jde("plugins")
    assert "slow-motion  0.0.0  Mine" in listed.text and "lost" not in listed.text, listed.text


@pytest.mark.parametrize("text", ["[jde.schemas]\nno module\n", "[jde.schemas]\nnone = \n"])
def test_a_malformed_distribution_hides_no_other(
    text: str, installed: Robot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    malformed = tmp_path / "site/adrift-1.0.dist-info"
    malformed.mkdir()
    (malformed / "METADATA").write_text("Name: adrift\nVersion: 1.0\n")
    (malformed / "entry_points.txt").write_text(text)
    listed = installed.jde("plugins")
    assert "slow-motion  0.0.0  Mine" in listed.text, listed.text
    monkeypatch.syspath_prepend(tmp_path / "site")
    assert "slow-motion" in dict(entry_points())
    assert "the entry points of adrift cannot be read: " in capsys.readouterr().err


def test_a_distribution_that_another_shadows_counts_no_more(
    installed: Robot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shadowed = tmp_path / "old/Motion-0.9.dist-info"
    shadowed.mkdir(parents=True)
    (shadowed / "METADATA").write_text("Name: Motion\nVersion: 0.9\n")
    (shadowed / "entry_points.txt").write_text("[jde.schemas]\ngone = motion.slow\n")
    others = list(sys.path)
    for folders, known in [(("old", "site"), "gone"), (("site", "old"), "slow-motion")]:
        monkeypatch.setattr(sys, "path", [*(str(tmp_path / folder) for folder in folders), *others])
        assert list(dict(entry_points())) == [known]


def test_the_folder_of_a_module_is_a_path_once(installed: Robot, tmp_path: Path) -> None:
    file = tmp_path / "site/motion/slow.py"
    paths, modules = list(sys.path), dict(sys.modules)
    try:
        load(file, file)
        load(file, file)
        assert sys.path.count(str(file.parent)) == 1
    finally:
        sys.path[:] = paths
        for name in sys.modules.keys() - modules:
            del sys.modules[name]


def test_a_schema_of_a_package_drives_and_imports_relatively(installed: Robot) -> None:
    installed.write("", file="slow-motion/Mine")
    drive = installed.drive()
    assert drive.status == 0 and "nobody -> mine" in drive.text and "no faults" in drive.text, drive.text


def test_a_name_that_nobody_has_says_where_it_was_looked_for(robot: Robot) -> None:
    done = robot.jde("describe", "nowhere")
    assert done.status == 3 and "jde.schemas (entry points of Python)" in done.text, done.text
