"""Measures the times in the documentation of Python: `python3 programs/python/benches/costs.py`, with the package in PYTHONPATH."""

import statistics
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

import jde.gym
from jde import Actuator, Context, Import, Schema, trigger
from jde import types as t
from jde.bench import Bench

ROOT = Path(__file__).parents[3]
TURNS, STEPS, RESETS = 3000, 20_000, 200


class Reads(Schema, kind="motor", period="100ms"):
    """Reads a scan and commands a speed."""

    laser: Import[t.LaserScan] = trigger()
    base: Actuator[t.Twist]

    def check(self, cx: Context) -> bool:
        """Read the scan."""
        return self.laser.range_max > 0.0

    def iterate(self, cx: Context) -> None:
        """Read the scan and command a speed."""
        self.base.command(t.Twist.planar(0.1 if self.laser.range_max > 0.0 else 0.0, 0.0))


class Looks(Reads, kind="motor", period="100ms"):
    """Looks ahead too."""

    def check(self, cx: Context) -> bool:
        """Find the nearest hit."""
        return self.laser.nearest_ahead(0.4) is not None


def turn(schema: type[Schema]) -> float:
    """Return the median time of a check and an iteration, s."""
    bench = Bench(schema)
    bench.give("laser", t.LaserScan(angle_min=-1.5, angle_increment=3.0 / 360, range_max=8.0, ranges=[4.0] * 360))
    times = []
    for _ in range(TURNS):
        start = time.perf_counter()
        bench.check()
        bench.iterate()
        times.append(time.perf_counter() - start)
    return statistics.median(times)


def each(count: int, act: Callable[[], object]) -> float:
    """Return the mean processor time of an act, s."""
    start = time.process_time()
    for _ in range(count):
        act()
    return (time.process_time() - start) / count


def main() -> None:
    """Print the times."""
    reads, looks = turn(Reads), turn(Looks)
    print(f"check and iteration, scan of 9 kB   {reads * 1e6:7.1f} µs")
    print(f"nearest_ahead over 360 beams, more  {(looks - reads) * 1e6:7.1f} µs")
    env = jde.gym.make(
        ROOT / "examples/python/reach.toml",
        observe=["robot.truth.pose"],
        act={"policy.base.linear.x": (0.0, 0.5), "policy.base.angular.z": (-1.5, 1.5)},
        reward=lambda env: 0.0,
        limit=1e6,
    )
    seeds = iter(range(RESETS))
    print(f"reset                               {each(RESETS, lambda: env.reset(seed=next(seeds))) * 1e6:7.1f} µs")
    action = np.array([0.3, 0.1], dtype=np.float32)
    print(f"step of 100 ms                      {each(STEPS, lambda: env.step(action)) * 1e6:7.1f} µs")


if __name__ == "__main__":
    main()
