"""The policy that learn.py trains, and the schema that drives with it."""

import json
import math
from pathlib import Path

from jde import Actuator, Import, Schema
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
    base: Actuator[t.Twist]

    def awake(self, cx):
        """Read the weights."""
        self.weights = json.loads(WEIGHTS.read_text())

    def check(self, cx):
        """Drive until the middle is reached."""
        return math.hypot(self.truth.pose.x, self.truth.pose.y) >= NEAR

    def iterate(self, cx):
        """Command what the policy decides."""
        pose = self.truth.pose
        self.base.command(t.Twist.planar(*decide(self.weights, seen(pose.x, pose.y, pose.theta))))
