"""Drivers of jde for robots that MuJoCo simulates."""

import os

# Nothing here draws, and the libraries for it take a part of the time of a start.
os.environ.setdefault("MUJOCO_GL", "disable")
