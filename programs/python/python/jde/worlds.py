"""Worlds and robots of the simulator's files, for drivers of other simulators.

`World` is a world with one robot: what stands there, and what moves by itself. The other simulator moves the robot, and
says where it is. `robot_model` returns what a robot file says. Lengths are in metres, angles in radians.
"""

from jde._jde import World, robot_model

__all__ = ["World", "robot_model"]
