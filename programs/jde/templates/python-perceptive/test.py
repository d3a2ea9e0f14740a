"""Tests of __name__, without a robot."""

import math

from __crate__ import Face, __Name__

from jde import types as t
from jde.bench import Bench


def scan(right, ahead, left):
    """A scan with three beams."""
    quarter = math.pi / 2
    return t.LaserScan(angle_min=-quarter, angle_increment=quarter, range_max=8.0, ranges=[right, ahead, left])


def test_it_finds_the_nearest_obstacle():
    bench = Bench(__Name__)
    bench.give("laser", scan(3.0, 2.0, 1.0))
    bench.iterate()
    assert bench.exported("nearest").distance_to(t.Pose2D(0.0, 1.0, 0.0)) < 1e-3


def test_it_retracts_its_export_when_there_is_no_obstacle():
    bench = Bench(__Name__)
    for range, found in [(4.0, True), (6.0, False)]:
        bench.give("laser", scan(range, range, range))
        bench.iterate()
        assert (bench.exported("nearest") is not None) == found, f"{range} m"


def test_the_robot_turns_to_the_nearest_obstacle():
    bench = Bench(Face)
    assert not bench.check().ready, "there is no obstacle"
    bench.give("nearest", t.Pose2D(0.0, 1.0, 0.0))
    assert bench.check().ready
    bench.iterate()
    assert bench.commanded("base") == t.Twist.planar(0.0, 0.5)
