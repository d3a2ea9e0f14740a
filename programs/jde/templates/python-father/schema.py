"""A father with two children: it wakes them, sets the target of one, and arbitrates between them."""

from jde import Child, Context, Import, Level, Modulates, Modulation, Schema, Verdict, child, modulates, modulation
from jde import types as t


class __Name__(Schema, kind="motor", period="100ms"):
    """Drives back and forth between two places, by its children."""

    pose: Import[t.Odometry]
    """Pose of the robot."""
    first: Modulation[t.Pose2D] = modulation(t.Pose2D(1.5, 1.5, 0.0))
    """The first place, in the frame of the odometry."""
    second: Modulation[t.Pose2D] = modulation(t.Pose2D(4.5, 1.5, 0.0))
    """The second place, in the same frame."""
    tolerance: Modulation[float] = modulation(0.3, unit="m", min=0.0)
    """The robot has reached a place at this distance from it."""
    brake: Child = child(group="base")
    """Stops in front of a close obstacle."""
    cruise: Child = child(group="base")
    """Drives to its target."""
    target: Modulates[t.Target] = modulates("cruise", "target")
    """The target of `cruise`."""

    def __init__(self) -> None:
        self.returning = False

    def iterate(self, cx: Context) -> None:
        """One iteration; called every period while it is WINNER. Without a `check` it is always ready."""
        self.brake.wake()
        self.cruise.wake()
        odometry = cx.sample(__Name__.pose)
        place = self.place()
        if odometry is not None and odometry.value.pose2d().distance_to(place) < self.tolerance:
            self.returning = not self.returning
            cx.info(f"reached {place.x:.2f}, {place.y:.2f}")
        self.target.set(t.Target(self.place(), set=True))

    def arbitrate(self, cx: Context, level: Level) -> Verdict:
        """Arbitrate when both children are ready, or none is. Without it, the first child that is ready wins."""
        if level.is_ready(self.brake):
            return level.choose(self.brake, "an obstacle is too close")
        return level.nobody("no child is ready")

    def place(self) -> t.Pose2D:
        """Return the place to which the robot drives."""
        return self.first if self.returning else self.second
