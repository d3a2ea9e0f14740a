"""How a controller leads its wheels to a command: within the limits of the robot's file, and with its lag.

The rules are those of `robotics/sim/src/drive.rs`, so that both simulators drive the same controller and differ only in
what the wheels then do.
"""

import math

import numpy as np

from jde_mujoco.model import ARMATURE_SHARE, inertia_of_wheel

#: The share of an error of speed that a step ends on a wheel without load: less than 1 for a stable control.
STEP_SHARE = 0.3
#: The time in which an error ends that a lasting load causes, s: an estimate of a well tuned controller.
INTEGRATION = 0.05


class Motors:
    """The controller of a base with wheels on two sides."""

    def __init__(self, robot):
        """Start at rest."""
        self.robot = robot
        self.command = self.target = self.speeds = (0.0, 0.0)

    def take(self, ahead, turn):
        """Take a command, m/s and rad/s, within the limits of the speeds."""
        robot = self.robot
        ahead = min(max(ahead, -robot["max_speed"]), robot["max_speed"])
        turn = min(max(turn, -robot["max_turn"]), robot["max_turn"])
        is_still = _is_held(ahead, robot["dead_band"]) and _is_held(turn, robot["turn_dead_band"])
        self.command = (0.0, 0.0) if is_still else (ahead, turn)

    def step(self, dt):
        """Return the speeds ahead, m/s, and of the turn, rad/s, to which the wheels are driven after `dt` seconds."""
        robot = self.robot
        self.target = (
            approach(self.target[0], self.command[0], robot["acceleration"] * dt, robot["deceleration"] * dt),
            approach(self.target[1], self.command[1], robot["turn_acceleration"] * dt, robot["turn_deceleration"] * dt),
        )
        share = 1.0 - math.exp(-dt / robot["lag"]) if robot["lag"] > 0 else 1.0
        self.speeds = tuple(now + share * (to - now) for now, to in zip(self.speeds, self.target))
        return self.speeds


class SpeedControl:
    """The torques by which motors bring their wheels to a speed: proportional and integral, with the load of the base."""

    def __init__(self, robot, dt):
        """Start without torque; `dt` is the time of a step, s."""
        physics = robot["physics"]
        self.most, self.dt = physics["torque"], dt
        inertia = inertia_of_wheel(physics)
        self.inertia = (1 + ARMATURE_SHARE) * inertia
        self.gain = STEP_SHARE * ARMATURE_SHARE * inertia / dt
        count = len(physics["wheels"])
        self.sums, self.wanted = np.zeros(count), np.zeros(count)

    def torques(self, wanted, speeds):
        """Return the torques of the wheels, N m, by the speeds that are wanted and those that are, rad/s."""
        ahead = self.inertia / self.dt * (wanted - self.wanted)
        self.wanted = wanted
        pulls = self.gain * (wanted - speeds)
        torques = pulls + self.sums + ahead
        limited = np.minimum(np.maximum(torques, -self.most), self.most)
        # A motor at its limit does not sum up what it cannot give.
        self.sums += (torques == limited) * pulls * (self.dt / INTEGRATION)
        return limited


def _is_held(speed, band):
    return speed == 0 or abs(speed) < band


def approach(speed, desired, gain, loss):
    """Return the next speed: it changes by at most `loss` toward zero, where it stops, and by `gain` away from it."""
    if speed != 0 and desired * speed < speed * speed:
        target = desired if desired * speed > 0 else 0.0
        return max(speed - loss, target) if speed > target else min(speed + loss, target)
    return min(speed + gain, desired) if desired > speed else max(speed - gain, desired)
