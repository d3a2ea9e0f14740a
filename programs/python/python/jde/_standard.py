"""The functions of standard types. `jde.types` has the types."""

from __future__ import annotations

import math
import struct
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from typing_extensions import Self

    from jde import types as t


@dataclass(frozen=True)
class LaserPoint:
    """The hit of one laser beam, in the frame of the scanner: x ahead, y to the left, m; angle in rad."""

    beam: int
    angle: float
    range: float
    x: float
    y: float


@dataclass(frozen=True)
class SonarEcho:
    """The echo of one sonar of a ring, in the frame of the base: x ahead, y to the left, m."""

    sonar: int
    range: float
    x: float
    y: float


def normalize_angle(angle: float) -> float:
    """Return `angle` in (-pi, pi], rad."""
    turned = angle % math.tau
    return turned - math.tau if turned > math.pi else turned


# At distance 0, m, an object would be in no direction.
_CLOSE = 1e-6


def _distance(range: float, least: float, greatest: float) -> float | None:
    """Return a measured distance, m, or None. By REP-117 minus infinity is something too close to measure."""
    if range == -math.inf:
        return max(least, _CLOSE)
    # The greatest distance itself is free.
    return range if 0.0 < range < greatest and least <= range else None


class LaserScanFunctions:
    """The functions of `LaserScan`."""

    angle_min: float
    angle_increment: float
    range_min: float
    range_max: float
    ranges: Sequence[float]

    def angle(self, beam: int) -> float:
        """Return the angle of a beam, rad."""
        return self.angle_min + beam * self.angle_increment

    def points(self) -> Iterator[LaserPoint]:
        """Return the hits of the beams. Beams without a hit or a measurement are left out."""
        for beam, measured in enumerate(self.ranges):
            range = _distance(measured, self.range_min, self.range_max)
            if range is not None:
                angle = self.angle(beam)
                yield LaserPoint(beam, angle, range, range * math.cos(angle), range * math.sin(angle))

    def nearest_ahead(self, half_width: float) -> float | None:
        """Return how far ahead the nearest hit within `half_width` m to either side is, m; None if there is none."""
        nearest = math.inf
        sin, cos, least, greatest = math.sin, math.cos, self.range_min, self.range_max
        start, increment = self.angle_min, self.angle_increment
        for beam, range in enumerate(self.ranges):
            if range == -math.inf:
                range = max(least, _CLOSE)
            if 0.0 < range < greatest and least <= range:
                angle = start + beam * increment
                ahead = range * cos(angle)
                if 0.0 < ahead < nearest and abs(range * sin(angle)) <= half_width:
                    nearest = ahead
        return None if nearest == math.inf else nearest


#: The bytes of a pixel, by the encodings of an image that can be shown.
PIXELS = {"rgb8": 3, "bgr8": 3, "mono8": 1, "32FC1": 4}


def _grey(depths: list[tuple[float, ...]]) -> list[bytes]:
    """Return rows of depths, m, as rows of grey."""
    greatest = max((depth for row in depths for depth in row if 0.0 < depth < math.inf), default=1.0)
    return [bytes(round(255 * depth / greatest) if 0.0 < depth < math.inf else 0 for depth in row) for row in depths]


def _chunk(kind: bytes, content: bytes) -> bytes:
    """Return a part of a PNG file."""
    return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))


class ImageFunctions:
    """The functions of `Image`."""

    height: int
    width: int
    encoding: str
    is_bigendian: int
    step: int
    data: Sequence[int]

    def png(self) -> bytes:
        """Return the image as PNG. A depth is grey: black for none, white for the greatest."""
        if self.encoding not in PIXELS:
            raise ValueError(f"an image in {self.encoding!r} cannot be shown, but {', '.join(PIXELS)}")
        data, length = bytes(self.data), self.width * PIXELS[self.encoding]
        needed = (self.height - 1) * self.step + length
        if not self.width or not self.height or self.step < length or len(data) < needed:
            raise ValueError(
                f"{len(data)} bytes in rows of {self.step} are no image of {self.width} x {self.height} pixels in "
                f"{self.encoding!r}, of {length} bytes a row"
            )
        rows = [data[start : start + length] for start in range(0, self.height * self.step, self.step)]
        if self.encoding == "32FC1":
            rows = _grey([struct.unpack(f"{'>' if self.is_bigendian else '<'}{self.width}f", row) for row in rows])
        elif self.encoding == "bgr8":
            rows = [b"".join(row[at : at + 3][::-1] for at in range(0, length, 3)) for row in rows]
        color = 0 if self.encoding in ("mono8", "32FC1") else 2
        header = struct.pack(">IIBBBBB", self.width, self.height, 8, color, 0, 0, 0)
        pixels = zlib.compress(b"".join(b"\0" + row for row in rows))
        chunks = [_chunk(b"IHDR", header), _chunk(b"IDAT", pixels), _chunk(b"IEND", b"")]
        return b"\x89PNG\r\n\x1a\n" + b"".join(chunks)

    def _repr_png_(self) -> bytes | None:
        try:
            return self.png()
        except ValueError:
            return None


class RangeRingFunctions:
    """The functions of `RangeRing`."""

    min_range: float
    max_range: float
    poses: Sequence[t.Pose2D]
    ranges: Sequence[float]

    def echoes(self) -> Iterator[SonarEcho]:
        """Return the echoes of the sonars. Sonars without an echo are left out."""
        for sonar, (pose, measured) in enumerate(zip(self.poses, self.ranges, strict=False)):
            range = _distance(measured, self.min_range, self.max_range)
            if range is not None:
                x, y = pose.x + range * math.cos(pose.theta), pose.y + range * math.sin(pose.theta)
                yield SonarEcho(sonar, range, x, y)


class TwistFunctions:
    """The functions of `Twist`."""

    linear: t.Vector3
    angular: t.Vector3

    @classmethod
    def planar(cls, ahead: float, turn: float) -> Self:
        """Return a velocity of `ahead` m/s with a left turn of `turn` rad/s."""
        twist = cls()
        twist.linear.x = ahead
        twist.angular.z = turn
        return twist


class QuaternionFunctions:
    """The functions of `Quaternion`."""

    x: float
    y: float
    z: float
    w: float

    @classmethod
    def from_yaw(cls, yaw: float) -> Self:
        """Return a rotation by `yaw` rad about the axis up."""
        rotation = cls()
        rotation.z, rotation.w = math.sin(yaw / 2), math.cos(yaw / 2)
        return rotation

    def yaw(self) -> float:
        """Return the rotation about the axis up, rad, whatever its length; NaN if it has none."""
        y, z = self.y * self.y, self.z * self.z
        square = self.x * self.x + y + z + self.w * self.w
        if not square > 0.0:
            return math.nan
        return math.atan2(2.0 * (self.w * self.z + self.x * self.y), square - 2.0 * (y + z))


class Pose2DFunctions:
    """The functions of `Pose2D`."""

    x: float
    y: float
    theta: float

    def distance_to(self, other: t.Pose2D) -> float:
        """Return the distance to `other`, m."""
        return math.hypot(other.x - self.x, other.y - self.y)

    def bearing_to(self, other: t.Pose2D) -> float:
        """Return the left turn that faces `other`, rad."""
        return normalize_angle(math.atan2(other.y - self.y, other.x - self.x) - self.theta)

    def transform(self, local: t.Pose2D) -> t.Pose2D:
        """Transform a pose in the frame of `self` to the frame that `self` is in."""
        sin, cos = math.sin(self.theta), math.cos(self.theta)
        x, y = self.x + cos * local.x - sin * local.y, self.y + sin * local.x + cos * local.y
        return type(local)(x, y, normalize_angle(self.theta + local.theta))

    def localize(self, other: t.Pose2D) -> t.Pose2D:
        """Transform a pose in the frame that `self` is in to the frame of `self`."""
        sin, cos = math.sin(self.theta), math.cos(self.theta)
        x, y = other.x - self.x, other.y - self.y
        return type(other)(cos * x + sin * y, cos * y - sin * x, normalize_angle(other.theta - self.theta))


class OdometryFunctions:
    """The functions of `Odometry`."""

    pose: t.PoseWithCovariance

    def pose2d(self) -> t.Pose2D:
        """Return the position and heading in the plane."""
        from jde.types import Pose2D

        pose = self.pose.pose
        return Pose2D(pose.position.x, pose.position.y, pose.orientation.yaw())


class TargetFunctions:
    """The functions of `Target`."""

    pose: t.Pose2D
    set: bool

    def get(self) -> t.Pose2D | None:
        """Return the target, if there is one."""
        return self.pose if self.set else None


class ConnectionFunctions:
    """The functions of `Connection`."""

    state: int

    def is_up(self) -> bool:
        """Return whether the device is connected."""
        return self.state == 2


class BumpersFunctions:
    """The functions of `Bumpers`."""

    front: Sequence[bool]
    rear: Sequence[bool]

    def any(self) -> bool:
        """Return whether any bumper is pressed."""
        return any(self.front) or any(self.rear)
