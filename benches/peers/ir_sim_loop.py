"""Measures how many times faster than real time a loop over ir-sim, a robot simulator in Python, runs, and prints it.

The request is read as JSON from the standard input: `seconds` to simulate, `step` (s), `beams` over half a circle, `range` (m).
A robot drives by ir-sim's own behaviour through a building like that of safe navigation: walls of six rooms, and four people.
"""

import json
import logging
import os
import sys
import tempfile
import time

os.environ.setdefault("MPLBACKEND", "Agg")
logging.disable(logging.CRITICAL)
# The package prints a greeting on the standard output.
output, sys.stdout = sys.stdout, sys.stderr
import irsim  # noqa: E402
import numpy as np  # noqa: E402
import yaml  # noqa: E402

WALLS = [
    [[0, 0], [20, 0], [20, 14], [0, 14], [0, 0]],
    [[0, 6], [2.8, 6]], [[4.3, 6], [8.8, 6]], [[10.3, 6], [16, 6]], [[17.5, 6], [20, 6]],
    [[0, 8.2], [2.8, 8.2]], [[4.3, 8.2], [7, 8.2]], [[9.2, 8.2], [16, 8.2]], [[17.5, 8.2], [20, 8.2]],
    [[6, 0], [6, 6]], [[13, 0], [13, 2]], [[13, 3.5], [13, 6]],
    [[7, 8.2], [7, 10.4]], [[7, 11.9], [7, 14]], [[9.2, 8.2], [9.2, 10.4]], [[9.2, 11.9], [9.2, 14]],
    [[14.5, 8.2], [14.5, 10.4]], [[14.5, 11.9], [14.5, 14]],
]

request = json.load(sys.stdin)
sensor = {
    "name": "lidar2d",
    "range_min": 0,
    "range_max": request["range"],
    "angle_range": np.pi,
    "number": request["beams"],
    "noise": True,
    "std": 0.005,
}
robot = {
    "kinematics": {"name": "diff"},
    "shape": {"name": "circle", "radius": 0.25},
    "state": [1, 7.1, 0],
    "goal": [19, 7.1, 0],
    "behavior": {"name": "dash"},
    "vel_max": [0.3, 1.0],
    "sensors": [sensor],
}
people = {
    "number": 4,
    "kinematics": {"name": "omni"},
    "distribution": {"name": "random", "range_low": [1, 9, 0], "range_high": [6, 13, 0]},
    "shape": {"name": "circle", "radius": 0.3},
    "behavior": {"name": "dash", "wander": True, "range_low": [1, 9, 0], "range_high": [6, 13, 0]},
}
walls = [{"shape": {"name": "linestring", "vertices": wall}, "state": [0, 0, 0]} for wall in WALLS]
world = {
    "world": {"height": 14, "width": 20, "step_time": request["step"], "sample_time": request["step"], "collision_mode": "stop"},
    "robot": [robot],
    "obstacle": [*walls, people],
}
with tempfile.NamedTemporaryFile("w", suffix=".yaml") as file:
    yaml.safe_dump(world, file)
    file.flush()
    env = irsim.make(file.name, display=False)
steps = round(request["seconds"] / request["step"])
start = time.perf_counter()
for _ in range(steps):
    env.step()
json.dump({"speed": request["seconds"] / (time.perf_counter() - start)}, output)
