"""A laser scanner by the rays of MuJoCo. One that turns casts each beam from where the robot is at that time."""

import math

import mujoco
import numpy as np

from jde_mujoco.model import FLOOR, THINGS

#: The height of a laser whose file states none, m: it sees all things, and never the floor.
LOW = 0.05


class Scanner:
    """The first laser of a robot."""

    def __init__(self, laser, random):
        """Start before its first scan."""
        self.laser, self.random = laser, random
        beams = laser["beams"]
        self.angles = laser["angle_min"] + laser["angle_increment"] * np.arange(beams)
        self.ranges = np.zeros(beams)
        self.next, self.started = 0, 0.0
        self.due = 0.0
        self.groups = np.zeros(6, dtype=np.uint8)
        self.groups[[THINGS, FLOOR] if laser["height"] > 0 else [THINGS]] = 1

    def turn_to(self, now, model, data, pose):
        """Cast the beams of a turning laser until now. Yields each complete scan with its time."""
        laser, beams = self.laser, len(self.angles)
        while laser["turn"] is not None:
            last = self.started + laser["time_increment"] * (beams - 1)
            passed = min(int((now - self.started) / laser["time_increment"] + 1e-6) + 1, beams)
            if passed > self.next:
                self._cast(slice(self.next, passed), model, data, pose)
                self.next = passed
            if now + 1e-9 < last or self.next < beams:
                return
            yield self._measured(), self.started
            self.next, self.started = 0, self.started + laser["turn"]
            if self.started > now:
                return

    def take(self, now, model, data, pose):
        """Return a scan of one that does not turn, if one is due."""
        period = self.laser["period"]
        if self.laser["turn"] is not None or now < self.due - 1e-9:
            return None
        if period is not None:
            # Late by more than a period: it starts afresh.
            self.due = self.due + period if now < self.due + period else now + period
        self._cast(slice(0, len(self.angles)), model, data, pose)
        return self._measured()

    def restart(self, now):
        """Begin anew: time has passed in which nobody measured."""
        self.next, self.started, self.due = 0, now, now

    def _cast(self, beams, model, data, pose):
        x, y, heading = pose
        ahead, left, turned = self.laser["mount"]
        height, angles = self.laser["height"], self.angles[beams] + turned
        count = len(angles)
        if height > 0:
            # It tilts with the body.
            rotation = data.body("robot").xmat.reshape(3, 3)
            origin = data.body("robot").xpos + rotation @ (ahead, left, height)
            rays = np.stack([np.cos(angles), np.sin(angles), np.zeros(count)], axis=1) @ rotation.T
        else:
            cos, sin = math.cos(heading), math.sin(heading)
            origin = np.array([x + cos * ahead - sin * left, y + sin * ahead + cos * left, LOW])
            angles = angles + heading
            rays = np.stack([np.cos(angles), np.sin(angles), np.zeros(count)], axis=1)
        geoms, distances = np.zeros(count, dtype=np.int32), np.zeros(count)
        mujoco.mj_multiRay(
            model, data, origin, rays.ravel(), self.groups, True, -1, geoms, distances, None, count,
            self.laser["range_max"] + 1.0,
        )  # fmt: skip
        self.ranges[beams] = distances

    def _measured(self):
        """Return the ranges with noise, as the device states them."""
        laser, ranges = self.laser, self.ranges
        nothing = {"inf": math.inf, "max": laser["range_max"], "zero": 0.0, "nan": math.nan}[laser["no_return"]]
        near = {"inf": -math.inf, "max": -math.inf, "zero": 0.0, "nan": math.nan}[laser["no_return"]]
        noisy = ranges + laser["noise"] * self.random.standard_normal(len(ranges))
        lost = self.random.random(len(ranges)) < laser["dropped_beams"]
        measured = np.where(noisy < laser["range_min"], near, noisy)
        measured[(ranges < 0) | (noisy >= laser["range_max"]) | lost] = nothing
        return measured.astype(np.float32)
