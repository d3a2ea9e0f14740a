"""The schema in Python that the example `apart` measures."""

from jde import Actuator, Import, Schema, optional
from jde import types as t


class Follow(Schema, kind="motor", period="10ms"):
    """Looks at a scan and commands a speed: what a behaviour does in an iteration."""

    laser: Import[t.LaserScan] = optional()
    """What a laser sees."""
    base: Actuator[t.Twist] = optional()
    """Speeds of the base."""

    def iterate(self, cx):
        """Look and command."""
        self.base.command(t.Twist.planar(self.laser.range_max, 0.0))
