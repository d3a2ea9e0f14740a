"""Applications whose robot is one of MuJoCo, in lockstep."""

import math
import subprocess
import sys
from pathlib import Path

import pytest

import jde
from conftest import BIN, ROOT

NAVIGATE = ROOT / "apps/navigate.toml"
ROUTE = "{ poses = [[3.55, 7.1, 0]] }"


def path(seed, seconds):
    """Return the way of the robot of the application of navigation."""
    settings = {"robot.type": "mujoco/Robot", "navigate.route": ROUTE}
    with jde.run(NAVIGATE, seed=seed, set=settings) as run:
        run.trace("robot.truth")
        run.until(seconds)
        truth = run.series("robot.truth")
        return truth["pose.x"].tolist(), truth["pose.y"].tolist(), truth["collisions"].tolist()


def test_one_seed_gives_one_drive():
    first, again, other = path(3, 15.0), path(3, 15.0), path(4, 15.0)
    assert first == again
    assert first != other
    x, y, collisions = first
    assert math.dist((x[0], y[0]), (x[-1], y[-1])) > 1.0, "it drives"
    assert collisions[-1] == 0


def test_it_reaches_a_goal_in_a_building_that_it_does_not_know():
    settings = {"robot.type": "mujoco/Robot", "navigate.route": ROUTE}
    with jde.run(NAVIGATE, seed=1, set=settings) as run:
        run.until("navigate.mission.state == 1", within=120.0)
        truth = run["robot.truth"]
        assert run.outcome == "done"
        assert math.hypot(truth.pose.x - 3.55, truth.pose.y - 7.1) < 0.5
        assert truth.collisions == 0


def jde_of(*arguments, folder: Path = ROOT):
    """Run a verb, and return its status and what it prints."""
    command = [str(BIN / "jde"), *arguments]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=300, check=False)
    return done.returncode, done.stdout + done.stderr


@pytest.fixture(autouse=True)
def _interpreter(monkeypatch):
    monkeypatch.setenv("JDE_PYTHON", sys.executable)


def test_another_world_and_robot_are_those_of_the_files():
    status, text = jde_of(
        "run", "wander", "--lockstep", "--for", "5s",
        "--set", "pioneer.type=mujoco/Robot", "--set", "pioneer.model=jackal",
    )  # fmt: skip
    assert status == 0, text


@pytest.mark.parametrize(
    ("setting", "words"),
    [
        ("robot.model=omni", "states no masses and wheels"),
        ("robot.model=turtlebot5", "turtlebot5"),
        ("robot.start=[[0, 0, 0]]", "wall"),
        ("robot.type=mujoco/Robt", "did you mean `Robot`?"),
        ("robot.type=mujco/Robot", "there is no plugin `mujco`"),
    ],
)
def test_what_cannot_work_is_said_before_the_start(setting, words):
    status, text = jde_of("check", "navigate", "--set", "robot.type=mujoco/Robot", "--set", setting)
    assert status != 0
    assert words in text, text
