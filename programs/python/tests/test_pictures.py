"""What notebooks show: numbers over time, paths and images."""

import math
import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import jde
from jde import types as t

Pixels = np.ndarray[Any, np.dtype[np.int64]]


def pixels(png: bytes) -> Pixels:
    """Return the rows, the columns and the channels of a PNG file."""
    assert png.startswith(b"\x89PNG\r\n\x1a\n")
    width, height, depth, color = struct.unpack_from(">IIBB", png, 16)
    assert depth == 8
    channels, content, at = {0: 1, 2: 3, 6: 4}[color], b"", 8
    while at < len(png):
        length, kind = struct.unpack_from(">I4s", png, at)
        part = png[at + 8 : at + 8 + length]
        assert struct.unpack_from(">I", png, at + 8 + length)[0] == zlib.crc32(kind + part)
        content, at = content + (part if kind == b"IDAT" else b""), at + length + 12
    lines = np.frombuffer(zlib.decompress(content), np.uint8).reshape(height, -1)
    above = [0] * (width * channels)
    rows = []
    for line in lines.tolist():
        above = unfiltered(line[0], line[1:], above, channels)
        rows.append(above)
    return np.array(rows).reshape(height, width, channels)


def unfiltered(kind: int, line: list[int], above: list[int], channels: int) -> list[int]:
    """Undo the filter of a row."""
    if kind == 0:
        return line
    row: list[int] = []
    for at, byte in enumerate(line):
        left, up, corner = (
            (row[at - channels], above[at], above[at - channels]) if at >= channels else (0, above[at], 0)
        )
        near = min((left, up, corner), key=lambda value: abs(left + up - corner - value))
        row.append((byte + (left, up, (left + up) // 2, near)[kind - 1]) % 256)
    return row


def marks(picture: Pixels) -> Pixels:
    """Return the rows and columns of the pixels with a colour: lines, but neither text nor grid."""
    colors = picture[:, :, :3]
    return np.argwhere(colors.max(axis=2) - colors.min(axis=2) > 60)


@pytest.fixture
def run(reach: Path) -> jde.Run:
    """Return a run in which the cart drives ahead, and traces its pose."""
    run = jde.run(reach, mocks=["policy"])
    run.trace("robot.truth", "robot.odometry")
    run["policy.base"] = t.Twist.planar(0.5, 0.0)
    run.until(8.0)
    run.close()
    return run


def test_numbers_are_lines_over_time(run: jde.Run) -> None:
    truth = run.series("robot.truth")
    speed = pixels(truth.picture("twist.linear.x", width=400, height=240))
    assert speed.shape[:2] == (240, 400)
    found = marks(speed)
    end = found[found[:, 1] == 300][:, 0]
    assert len(end) in (1, 2), "the speed is constant"
    assert found[:, 0].max() - end.max() > 100, "and was 0 at first"
    place = pixels(truth.picture("pose.x", width=400, height=240))
    assert marks(place)[:, 0].max() > 150 and not np.array_equal(place, speed)
    with pytest.raises(ValueError, match="`pose` of robot.truth is not one number"):
        truth.picture("pose")
    with pytest.raises(KeyError, match="no field `pse`"):
        truth.picture("pse")
    with pytest.raises(ValueError, match="pixels on each side"):
        truth.picture("pose.x", width=1)


def test_a_pose_is_a_path(run: jde.Run, reach: Path) -> None:
    truth, odometry = run.series("robot.truth"), run.series("robot.odometry")
    for series in (truth, odometry):
        poses = series.poses()
        assert poses is not None
        assert poses[-1] == pytest.approx([8.0, poses[0][1] + 3.7, poses[0][2], poses[0][3]], abs=0.2)
    path, both = truth._repr_png_(), run._repr_png_()
    assert both is not None and both.startswith(b"\x89PNG") and both != path
    assert run.series("robot.truth").picture() == path, "the same way is the same picture"
    straight = struct.unpack_from(">II", path, 16)
    with jde.run(reach, mocks=["policy"]) as again:
        again.trace("robot.truth")
        again["policy.base"] = t.Twist.planar(0.3, 0.4)
        again.until(12.0)
    width, height = struct.unpack_from(">II", again.series("robot.truth").picture(), 16)
    assert height / width > straight[1] / straight[0], "a curve is higher than a straight way"


def test_a_run_without_a_path_is_its_name(reach: Path) -> None:
    with jde.run(reach, mocks=["policy"]) as run:
        assert run._repr_png_() is None


def test_a_turn_is_read_from_a_quaternion(reach: Path) -> None:
    with jde.run(reach, mocks=["policy"]) as run:
        run.trace("robot.odometry")
        run["policy.base"] = t.Twist.planar(0.0, 0.5)
        run.until(3.0)
        poses = run.series("robot.odometry").poses()
        assert poses is not None
        assert poses[-1][3] == pytest.approx(run["robot.odometry"].pose2d().theta)
        assert poses[-1][3] > 0.5


COLORED = [[[255, 0, 0], [0, 128, 0]], [[1, 2, 3], [9, 8, 7]]]


@pytest.mark.parametrize(
    ("encoding", "rows", "expected"),
    [
        ("rgb8", COLORED, COLORED),
        ("bgr8", COLORED, [[pixel[::-1] for pixel in row] for row in COLORED]),
        ("mono8", [[0, 100], [200, 255]], [[[0], [100]], [[200], [255]]]),
    ],
)
def test_an_image_is_its_pixels(encoding: str, rows: list[Any], expected: list[Any]) -> None:
    padded = [*np.ravel(rows[0]), 77, *np.ravel(rows[1]), 77]
    image = t.Image(height=2, width=2, encoding=encoding, step=len(padded) // 2, data=padded)
    png = image._repr_png_()
    assert png is not None
    assert pixels(png).tolist() == expected


@pytest.mark.parametrize("order", ["<", ">"])
def test_a_depth_is_grey(order: str) -> None:
    data = struct.pack(f"{order}4f", 1.0, 2.0, math.nan, 4.0)
    image = t.Image(height=2, width=2, encoding="32FC1", is_bigendian=int(order == ">"), step=8, data=list(data))
    assert pixels(image.png()).tolist() == [[[64], [128]], [[0], [255]]]


def test_what_is_no_image_is_not_shown() -> None:
    assert t.Image()._repr_png_() is None
    image = t.Image(height=1, width=1, encoding="yuv422", step=2, data=[1, 2])
    assert image._repr_png_() is None
    with pytest.raises(ValueError, match="'yuv422' cannot be shown, but rgb8, bgr8, mono8, 32FC1"):
        image.png()


@pytest.mark.parametrize(
    ("encoding", "height", "width", "step", "count"),
    [("rgb8", 2, 2, 6, 11), ("mono8", 2, 2, 1, 8), ("mono8", 2, 2, 0, 4), ("32FC1", 1, 2, 8, 7), ("mono8", 0, 2, 2, 4)],
)
def test_an_image_whose_bytes_are_not_its_pixels_is_not_shown(
    encoding: str, height: int, width: int, step: int, count: int
) -> None:
    image = t.Image(height=height, width=width, encoding=encoding, step=step, data=[1] * count)
    assert image._repr_png_() is None
    with pytest.raises(ValueError, match=f"{count} bytes in rows of {step} are no image of {width} x {height} pixels"):
        image.png()
