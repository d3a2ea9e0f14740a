"""Tests of creep-python, without a robot."""

from creep_python import CreepPython

from jde import types as t
from jde.bench import Bench


def speed_at(range: float) -> float:
    """The speed with a scan of one beam, straight ahead."""
    bench = Bench(CreepPython)
    bench.give("laser", t.LaserScan(range_max=8.0, ranges=[range]))
    assert bench.check().ready
    bench.iterate()
    return bench.commanded("base").linear.x


def test_it_is_not_ready_without_a_scan():
    assert not Bench(CreepPython).check().ready


def test_it_slows_down_near_an_obstacle_and_stops_at_a_distance():
    assert speed_at(5.0) == 0.4
    assert speed_at(1.0) < 0.4
    assert speed_at(0.5) == 0.0
    assert speed_at(0.2) == 0.0
