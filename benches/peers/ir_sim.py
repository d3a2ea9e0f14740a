"""Measures a laser scan of ir-sim, a simulator of robots in Python, and prints the time of one scan in nanoseconds.

The world is JSON on the standard input: `walls` (two points each, m), `at` (m), `beams`, `degrees`, `range` (m), `seconds`.
It also prints the ranges, so that the caller can check that it measured the same.
"""

import json
import logging
import os
import sys
import tempfile
import time

os.environ.setdefault("MPLBACKEND", "Agg")
logging.disable(logging.CRITICAL)
# ir-sim prints a greeting on the standard output.
output, sys.stdout = sys.stdout, sys.stderr
import irsim  # noqa: E402
import numpy as np  # noqa: E402
import yaml  # noqa: E402

request = json.load(sys.stdin)
walls = [{"shape": {"name": "linestring", "vertices": wall}, "state": [0, 0, 0]} for wall in request["walls"]]
sensor = {
    "name": "lidar2d",
    "range_min": 0,
    "range_max": request["range"],
    "angle_range": np.deg2rad(request["degrees"]).item(),
    "number": request["beams"],
    "noise": False,
}
robot = {
    "kinematics": {"name": "diff"},
    "shape": {"name": "circle", "radius": 0.25},
    "state": [*request["at"], 0],
    "goal": [1, 1, 0],
    "sensors": [sensor],
}
world = {"world": {"height": 50, "width": 50, "control_mode": "auto"}, "robot": [robot], "obstacle": walls}
with tempfile.NamedTemporaryFile("w", suffix=".yaml") as file:
    yaml.safe_dump(world, file)
    file.flush()
    env = irsim.make(file.name, display=False)
laser = env.robot.lidar
state = env.robot.state
laser.step(state)
times, start = [], time.perf_counter()
while time.perf_counter() - start < request["seconds"]:
    begun = time.perf_counter_ns()
    laser.step(state)
    times.append(time.perf_counter_ns() - begun)
times.sort()
json.dump({"scan_ns": times[len(times) // 2], "ranges": laser.range_data.tolist()}, output)
