"""Tests of __name__, without a robot."""

from __crate__ import __Name__

from jde import State
from jde import types as t
from jde.bench import Bench


def odometry(at):
    """The odometry of a robot at a pose."""
    pose = t.Pose(t.Point(at.x, at.y), t.Quaternion.from_yaw(at.theta))
    return t.Odometry(pose=t.PoseWithCovariance(pose))


def test_it_drives_back_and_forth():
    bench = Bench(__Name__)
    first, second = t.Pose2D(1.5, 1.5, 0.0), t.Pose2D(4.5, 1.5, 0.0)
    for at, to in [(first, second), (second, first), (second, first), (first, second)]:
        bench.give("pose", odometry(at))
        bench.iterate()
        assert bench.modulated("target").get() == to
    assert bench.awake_children == ["brake", "cruise"]


def test_the_brake_wins_when_both_children_are_ready():
    bench = Bench(__Name__)
    bench.set_child("brake", State.READY)
    bench.set_child("cruise", State.WINNER)
    assert bench.arbitrate("base") == ("brake", "an obstacle is too close")
    bench.set_child("brake", State.CHECKING)
    bench.set_child("cruise", State.CHECKING)
    assert bench.arbitrate("base") == (None, "no child is ready")
