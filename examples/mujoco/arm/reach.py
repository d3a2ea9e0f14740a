"""Three motor schemas that compete for an arm: one leaves room, one reaches for a tag, one rests. None knows the forbidden
zone: a guard judges what they command.
"""

import itertools
import math

import numpy as np

from jde import Actuator, Hysteresis, Import, Modulation, Schema, modulation, trigger
from jde import types as t

JOINTS = ["shoulder", "elbow"]


class Joints(Schema):
    """The ports of what moves the arm."""

    joints: Import[t.JointState] = trigger()
    """Angles and speeds of the joints."""
    upper_arm: Modulation[float] = modulation(0.4, unit="m", min=0.05, max=5.0)
    """Length from the shoulder to the elbow."""
    forearm: Modulation[float] = modulation(0.3, unit="m", min=0.05, max=5.0)
    """Length from the elbow to the hand."""
    fastest: Modulation[float] = modulation(1.0, unit="rad/s", min=0.05, max=10.0)
    """Greatest speed of a joint."""
    speeds: Actuator[t.JointState]

    def angles(self):
        """Return the angles of the shoulder and the elbow."""
        places = dict(zip(self.joints.name, self.joints.position))
        return np.array([places[name] for name in JOINTS])

    def points(self, angles):
        """Return the places of the shoulder, the elbow and the hand."""
        first, both = angles[0], angles.sum()
        bend = self.upper_arm * np.array([math.cos(first), math.sin(first)])
        return np.array([[0.0, 0.0], bend, bend + self.forearm * np.array([math.cos(both), math.sin(both)])])

    def command(self, speeds):
        """Command speeds, all lessened alike where one is too fast."""
        speeds = np.asarray(speeds) / max(1.0, np.abs(speeds).max() / self.fastest)
        self.speeds.command(t.JointState(name=JOINTS, velocity=speeds.tolist()))


class Retreat(Joints, kind="motor", period="40ms"):
    """Turns the arm away from somebody's hand that comes near to any part of it. Without that sense it keeps the arm still."""

    hand: Import[t.PositionFix] = trigger(optional=True)
    """Where somebody's hand is."""
    near: Modulation[float] = modulation(0.2, unit="m", min=0.0, max=2.0)
    """The distance at which it begins."""
    enough: Modulation[float] = modulation(0.28, unit="m", min=0.0, max=2.0)
    """The distance at which it ends."""

    def awake(self, cx):
        """Begin far from everybody."""
        self.is_near = Hysteresis()

    def check(self, cx):
        """Whether somebody's hand is near, or nobody knows."""
        seen = cx.sample(Retreat.hand)
        if seen is None:
            return True
        gap = self.gap(self.angles(), np.array([seen.value.x, seen.value.y]))
        return self.is_near.below(gap, self.near, self.enough)

    def iterate(self, cx):
        """Turn each joint the way that makes the distance greater."""
        seen = cx.sample(Retreat.hand)
        if seen is None:
            self.command([0.0, 0.0])
            return
        place, angles = np.array([seen.value.x, seen.value.y]), self.angles()
        step = 0.01
        slopes = [
            (self.gap(angles + step * turn, place) - self.gap(angles - step * turn, place)) / (2 * step)
            for turn in np.eye(2)
        ]
        self.command(self.fastest * np.array(slopes) / max(np.abs(slopes).max(), 0.05))

    def gap(self, angles, place):
        """Return the distance from the axes of the links to a place."""
        points = self.points(angles)
        return min(_distance(place, *link) for link in itertools.pairwise(points))


class Reach(Joints, kind="motor", period="40ms"):
    """Leads the hand to the tag that the camera sees, if the arm is long enough."""

    tag: Import[t.PositionFix] = trigger()
    """Where the tag is."""
    gain: Modulation[float] = modulation(3.0, unit="1/s", min=0.1, max=20.0)
    """The speed of the hand for each metre to the tag."""

    def check(self, cx):
        """Whether the tag is within reach."""
        return math.hypot(self.tag.x, self.tag.y) <= 0.98 * (self.upper_arm + self.forearm)

    def iterate(self, cx):
        """Command the speeds of the joints that move the hand straight to the tag (damped least squares)."""
        _, bend, hand = self.points(self.angles())
        way = np.array([self.tag.x, self.tag.y]) - hand
        # How the hand moves when a joint turns: across the line from the joint to it.
        motion = np.array([[-hand[1], bend[1] - hand[1]], [hand[0], hand[0] - bend[0]]])
        damping = 0.05**2 * np.eye(2)
        self.command(motion.T @ np.linalg.solve(motion @ motion.T + damping, self.gain * way))


class Rest(Joints, kind="motor", period="100ms"):
    """Folds the arm."""

    shoulder: Modulation[float] = modulation(-1.2, unit="rad")
    """The angle of the shoulder at rest."""
    elbow: Modulation[float] = modulation(1.5, unit="rad")
    """The angle of the elbow at rest."""

    def iterate(self, cx):
        """Turn towards rest."""
        self.command(2.0 * (np.array([self.shoulder, self.elbow]) - self.angles()))


def _distance(place, start, end):
    along = end - start
    share = min(max((place - start) @ along / (along @ along), 0.0), 1.0)
    return float(np.linalg.norm(place - start - share * along))
