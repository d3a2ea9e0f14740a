"""What `jde new schema NAME --python` writes passes its own tests and drives."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from conftest import Robot


@pytest.mark.parametrize(
    ("more", "name", "shown"),
    [
        ([], "follow-wall", ["nobody -> follow-wall"]),
        (["--perceptive"], "find-near", ["nobody -> face"]),
        (["--father"], "patrol", ["nobody -> goon", "reached 4.50, 1.50", "reached 1.50, 1.50"]),
    ],
)
def test_a_new_schema_passes_its_test_and_drives(tmp_path: Path, more: list[str], name: str, shown: list[str]) -> None:
    robot = Robot(tmp_path)
    made = robot.jde("new", "schema", name, "--python", *more)
    assert made.status == 0 and "run app.toml" in made.text, made.text
    robot.folder = tmp_path / name
    done = pytest_in(robot.folder)
    assert done.returncode == 0, done.stdout
    drive = robot.drive(60, "--log", f"{name}=info")
    assert drive.status == 0 and all(part in drive.text for part in shown), drive.text
    assert "no contact" in drive.text and "no faults" in drive.text


def pytest_in(folder: Path, *options: str) -> subprocess.CompletedProcess[str]:
    """Run the tests of a folder."""
    tests = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *options]
    return subprocess.run(tests, cwd=folder, capture_output=True, text=True, timeout=120, check=False)


def test_an_application_with_a_schema_in_python_has_tests(tmp_path: Path) -> None:
    robot = Robot(tmp_path)
    robot.jde("new", "schema", "follow-wall", "--python")
    robot.folder = tmp_path / "follow-wall"
    (robot.folder / "tests").mkdir()
    (robot.folder / "tests/drives.toml").write_text(
        'name = "it drives"\napplication = "../app.toml"\nfor = "5s"\n[must."it acts"]\nnever = "ahead.won"\n'
    )
    done = robot.jde("test")
    assert done.status == 0 and "1 passed" in done.text, done.text
    assert pytest_in(robot.folder).returncode == 0, "the drive and the tests of the schema are one verdict"
    (robot.folder / "tests/fails.toml").write_text(
        'name = "it stands"\napplication = "../app.toml"\nfor = "5s"\n[must."it stands"]\nnever = "follow-wall.won"\n'
    )
    tested = pytest_in(robot.folder)
    assert tested.returncode == 1 and "1 failed" in tested.stdout and "it drives" not in tested.stdout, tested.stdout
    assert "it stands" in tested.stdout and "see it: jde experiment" in tested.stdout, tested.stdout


def test_drives_below_a_folder_of_two_schemas_are_each_collected_once(tmp_path: Path) -> None:
    robot = Robot(tmp_path)
    for name in ("follow-wall", "keep-away"):
        robot.jde("new", "schema", name, "--python")
        (tmp_path / name / "tests").mkdir()
        (tmp_path / name / "tests/drives.toml").write_text(
            'name = "it drives"\napplication = "../app.toml"\nfor = "5s"\n'
        )
    # As where pip installed the package, and as elsewhere.
    for plugins in ([], ["-p", "jde.testing"]):
        done = pytest_in(tmp_path, "--collect-only", *plugins)
        assert done.returncode == 0 and done.stdout.count("::it drives") == 2, done.stdout


def test_a_name_that_hides_the_package_is_refused(tmp_path: Path) -> None:
    done = Robot(tmp_path).jde("new", "schema", "jde", "--python")
    assert done.status == 2 and "the name `jde` is taken" in done.text, done.text


@pytest.mark.parametrize("name", ["class", "lambda", "random", "pytest"])
def test_a_word_of_python_is_refused_for_a_schema_in_python_alone(tmp_path: Path, name: str) -> None:
    robot = Robot(tmp_path)
    done = robot.jde("new", "schema", name, "--python")
    assert done.status == 2 and not (tmp_path / name).exists()
    assert f"the name `{name}` is taken: Python has a keyword or a module of that name" in done.text, done.text
    assert robot.jde("new", "schema", name).status == 0
