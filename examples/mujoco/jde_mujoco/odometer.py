"""Encoders, and the pose that a robot computes from them, with the errors that its file states.

The covariance is propagated to first order (Kelly, "Linearized error propagation in odometry", 2004). What the wheels
skid and slip on the floor is MuJoCo's, and no covariance knows of it.
"""

import math

import numpy as np


class Odometer:
    """The measurement of the wheels of two sides."""

    def __init__(self, robot, pose, random):
        """Start at a pose, with the scale errors of this robot's wheels."""
        self.robot, self.random = robot, random
        self.track = robot["track"] * robot["physics"]["track_multiplier"]
        self.scale = 1.0 + robot["wheel_error"] * random.standard_normal(2)
        self.rolled = np.zeros(2)
        self.ticks = np.zeros(2, dtype=np.int64)
        self.pose = tuple(pose)
        self.speeds = (0.0, 0.0)
        # The error of the pose for a scale error of 1 of each wheel, and its covariance for a slip of 1 m.
        self.by_scale, self.by_slip = np.zeros((2, 3)), np.zeros((3, 3))
        self.last = np.zeros(2), 1.0

    def roll(self, ways, dt):
        """Measure how far the left and the right wheels rolled in `dt` seconds, m."""
        slip = self.robot["slip"] * np.sqrt(np.abs(ways)) * self.random.standard_normal(2)
        self.rolled += self.scale * ways + slip
        before, per_meter = self.ticks, self.robot["ticks_per_meter"]
        self.ticks = np.floor(self.rolled * per_meter).astype(np.int64)
        left, right = (self.ticks - before) / per_meter
        ahead, turned = (left + right) / 2, (right - left) / self.track
        x, y, heading = self.pose
        middle = heading + turned / 2
        # The chord of an arc.
        chord = ahead * (math.sin(turned / 2) / (turned / 2) if abs(turned) > 1e-9 else 1.0)
        moved = chord * math.cos(middle), chord * math.sin(middle)
        self.pose = x + moved[0], y + moved[1], math.remainder(heading + turned, math.tau)
        self.speeds = ahead / dt, turned / dt
        self._propagate(middle, moved, np.array([left, right]), dt)

    def _propagate(self, heading, moved, ways, dt):
        self.last = ways, dt
        if not ways.any():
            return
        motion = np.array([[1, 0, -moved[1]], [0, 1, moved[0]], [0, 0, 1]])
        effects = self.effects(heading)
        self.by_scale = self.by_scale @ motion.T + effects * ways[:, None]
        self.by_slip = motion @ self.by_slip @ motion.T + (effects.T * np.abs(ways)) @ effects

    def effects(self, heading):
        """Return the motion of the pose for a metre of each wheel."""
        along = math.cos(heading) / 2, math.sin(heading) / 2
        return np.array([[*along, -1 / self.track], [*along, 1 / self.track]])

    def pose_covariance(self):
        """Return that of x, y and the heading."""
        scale = self.robot["wheel_error"] ** 2
        return self.by_slip * self.robot["slip"] ** 2 + scale * self.by_scale.T @ self.by_scale

    def twist_covariance(self):
        """Return that of the speeds ahead, to the left and of the turn."""
        (ways, dt), robot = self.last, self.robot
        rounding = 1 / (6 * robot["ticks_per_meter"] ** 2)
        variances = (robot["wheel_error"] * ways) ** 2 + robot["slip"] ** 2 * np.abs(ways) + rounding
        effects = self.effects(0.0)
        return (effects.T * (variances / dt**2)) @ effects
