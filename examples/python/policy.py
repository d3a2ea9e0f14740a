"""The policy that learn.py trains, and the schema that drives with it."""

import json
import math
from pathlib import Path
from typing import Annotated

from jde import Actuator, Import, Modulation, Schema, modulation, text
from jde import types as t

#: The reach of the goal, m.
NEAR = 0.2
#: The bounds of the speed, m/s, and of the turn rate, rad/s.
BOUNDS = [(0.0, 0.5), (-1.5, 1.5)]
WEIGHTS = Path(__file__).with_name("weights.json")


def seen(x, y, heading):
    """Return the distance to the middle of the floor, m, and the cosine and sine of the angle to it."""
    bearing = math.atan2(-y, -x) - heading
    return [math.hypot(x, y), math.cos(bearing), math.sin(bearing)]


def decide(weights, observation):
    """Return the speed and the turn rate: a sum of what is seen and 1, each with its weight."""
    sums = [sum(weight * number for weight, number in zip(row, [*observation, 1.0])) for row in weights]
    return [min(max(number, low), high) for number, (low, high) in zip(sums, BOUNDS)]


class Policy(Schema, kind="motor", period="100ms"):
    """Drives to the middle of the floor. It steers by the true pose, which only a simulator knows."""

    truth: Import[t.Truth]
    weights: Modulation[Annotated[str, text(1000)]] = modulation(str(WEIGHTS), unit="path", fixed=True)
    """The file of the weights."""
    base: Actuator[t.Twist]

    def inspect(self, cx, problems):
        """Say what to do before there are weights."""
        if not Path(self.weights).exists():
            problems.wrong(Policy.weights, f"{self.weights} does not exist: learn.py in its folder writes it")

    def awake(self, cx):
        """Read the weights."""
        self.learned = json.loads(Path(self.weights).read_text())

    def check(self, cx):
        """Drive until the middle is reached."""
        return math.hypot(self.truth.pose.x, self.truth.pose.y) >= NEAR

    def iterate(self, cx):
        """Command what the policy decides."""
        pose = self.truth.pose
        self.base.command(t.Twist.planar(*decide(self.learned, seen(pose.x, pose.y, pose.theta))))
