"""A perceptive schema that finds the nearest obstacle, and a motor schema that turns to it."""

from jde import Actuator, Context, Export, Import, Modulation, Schema, modulation, trigger
from jde import types as t


class __Name__(Schema, kind="perceptive", period="100ms"):
    """Finds the nearest obstacle in a laser scan."""

    laser: Import[t.LaserScan] = trigger()
    """The scan of the laser. A new scan triggers an iteration."""
    farthest: Modulation[float] = modulation(5.0, unit="m", min=0.0)
    """Obstacles at a greater distance are ignored."""
    nearest: Export[t.Pose2D]
    """Position of the nearest obstacle in the frame of the laser. It has no value while there is none."""

    def iterate(self, cx: Context) -> None:
        """One iteration; called every period while an awake schema imports its export."""
        scan = cx.sample(__Name__.laser)
        if scan is None:
            return
        near = [point for point in scan.value.points() if point.range <= self.farthest]
        if near:
            point = min(near, key=lambda point: point.range)
            # The export is as old as the scan that it results from.
            self.nearest.write(t.Pose2D(point.x, point.y, 0.0), time=scan.time)
        else:
            self.nearest.retract()


class Face(Schema, kind="motor", period="100ms"):
    """Turns to the nearest obstacle, which the other schema finds."""

    nearest: Import[t.Pose2D] = trigger()
    """Position of the nearest obstacle."""
    base: Actuator[t.Twist]
    """Speeds of the base."""

    def check(self, cx: Context) -> bool:
        """The precondition: there is an obstacle."""
        return cx.sample(Face.nearest) is not None

    def iterate(self, cx: Context) -> None:
        """One iteration; called every period while it is WINNER."""
        bearing = t.Pose2D().bearing_to(self.nearest)
        self.base.command(t.Twist.planar(0.0, min(max(bearing, -0.5), 0.5)))
