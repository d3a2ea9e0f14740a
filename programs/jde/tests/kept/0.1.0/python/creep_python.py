"""Drives up to the obstacle ahead and stops in front of it."""

import math

from jde import Actuator, Context, Import, Modulation, Schema, modulation, trigger
from jde import types as t
from jde.panel import Ink, Pen

HALF_WIDTH = 0.35
"""Half the width of the area that must be free: that of the robot and a margin, m."""


class CreepPython(Schema, kind="motor", period="100ms"):
    """Drives straight ahead, slows down near an obstacle, and stops at a distance from it."""

    laser: Import[t.LaserScan] = trigger()
    """The scan of the laser. A new scan triggers a check."""
    distance: Modulation[float] = modulation(0.5, unit="m", min=0.0)
    """Distance to the obstacle at which the robot stops."""
    speed: Modulation[float] = modulation(0.4, unit="m/s", min=0.0)
    """Speed far from all obstacles."""
    base: Actuator[t.Twist]
    """Speeds of the base."""

    def check(self, cx: Context) -> bool:
        """The precondition: it can act while there is a scan."""
        return len(self.laser.ranges) > 0

    def iterate(self, cx: Context) -> None:
        """One iteration; called every period while it is WINNER."""
        nearest = self.laser.nearest_ahead(HALF_WIDTH)
        room = math.inf if nearest is None else nearest - self.distance
        # One metre is enough to slow down from full speed.
        self.base.command(t.Twist.planar(self.speed * min(max(room, 0.0), 1.0), 0.0))

    def draw(self, cx: Context, pen: Pen) -> None:
        """Its panel, which is drawn while a window or `jde panel` shows it."""
        pen.value("distance", self.distance, "m")
        with pen.canvas("ahead", forward_up=True) as ahead:
            ahead.points(self.laser.points(), ink=Ink.SEEN)
            ahead.line([(self.distance, -HALF_WIDTH), (self.distance, HALF_WIDTH)], ink=Ink.GOAL)
            ahead.robot(t.Pose2D())
