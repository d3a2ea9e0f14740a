"""A father without code lets schemas in Python act one after another, and its mission says how that ended."""

from __future__ import annotations

import pytest

from conftest import Robot

ACTS = '''
from jde import Actuator, Context, Modulation, Schema, modulation
from jde import types as t


class Acts(Schema, kind="motor", period="100ms"):
    """Turns for a second."""

    base: Actuator[t.Twist]
    """Speeds of the base."""
    endless: Modulation[int] = modulation(0)
    """Whether it has no end."""

    def awake(self, cx: Context) -> None:
        self.left = 10

    def check(self, cx: Context) -> bool:
        return self.left > 0 or self.endless > 0

    def iterate(self, cx: Context) -> None:
        self.left -= 1
        self.base.command(t.Twist.planar(0.0, 0.5))
'''
APPLICATION = """
name = "errand"
roots = ["errand"]
mission = "errand.mission"
[schemas.pioneer]
type = "sim/robot"
world = "world.toml"
[schemas.errand]
type = "sequence/steps"
children = { first = "turn", then = "again" }
timeout = "3s"
retries = 1
[schemas.turn]
type = "acts.py/Acts"
actuators = { base = "pioneer.velocity" }
[schemas.again]
type = "acts.py/Acts"
actuators = { base = "pioneer.velocity" }
"""


@pytest.mark.parametrize(
    ("more", "status", "end", "tries"),
    [("", 0, "the mission is done", 1), ("endless = 1\n", 1, "the mission failed", 2)],
)
def test_children_act_one_after_another(robot: Robot, more: str, status: int, end: str, tries: int) -> None:
    (robot.folder / "acts.py").write_text(ACTS)
    (robot.folder / "app.toml").write_text(APPLICATION + more)
    done = robot.drive(30, "--plain")
    assert done.status == status and end in done.text, done.text
    assert done.text.count("errand/step: nobody -> turn") == 1, done.text
    assert done.text.count("errand/step: nobody -> again") == tries, done.text
    assert done.text.index("-> turn") < done.text.index("-> again"), done.text
