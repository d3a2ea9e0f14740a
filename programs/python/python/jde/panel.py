"""Panels: what a schema draws, and the gestures of people on it.

A panel is a list of widgets, drawn anew each time. Positions are in metres, in the plane or frame of their canvas or
scene. The first mistake is shown in place of the panel.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

from jde import _jde

Point = Sequence[float] | Any
"""A position: a sequence of two or three numbers, or an object with `x` and `y`, such as a pose."""


class Ink(IntEnum):
    """A color that fits the viewer's theme."""

    PLAIN = 0
    FAINT = 1
    ACCENT = 2
    GOOD = 3
    WARN = 4
    BAD = 5
    GOAL = 6
    SEEN = 7


class Words(IntEnum):
    """The style of a text."""

    PLAIN = 0
    HEADING = 1
    FAINT = 2
    GOOD = 3
    WARNING = 4
    ERROR = 5
    CODE = 6


@dataclass(frozen=True)
class Gesture:
    """A gesture of a person on a widget."""

    kind: int
    widget: str
    by: str
    """The operator: `ana@laptop`."""
    key: str
    start: tuple[float, float, float]
    at: tuple[float, float, float]
    value: float
    number: int
    button: int
    has_ended: bool

    def pressed(self, widget: str) -> bool:
        """Whether a button was pressed."""
        return self.widget == widget and self.kind == 0

    def toggled(self, widget: str) -> bool | None:
        """Return the new state of a toggle, if it was switched."""
        return bool(self.number) if self.widget == widget and self.kind == 1 else None

    def moved(self, widget: str) -> float | None:
        """Return the new number of a slider, if it was moved."""
        return self.value if self.widget == widget and self.kind == 2 else None

    def chose(self, widget: str) -> int | None:
        """Return the index of the option of a choice, if one was chosen."""
        return self.number if self.widget == widget and self.kind == 3 else None

    def clicked(self, widget: str) -> tuple[float, float, float] | None:
        """Return where a widget was clicked, if it was."""
        return self.at if self.widget == widget and self.kind == 4 else None

    def dragged(self, widget: str) -> tuple[tuple[float, float, float], tuple[float, float, float], bool] | None:
        """Return where a drag began, where it is, and whether it has ended, if there is one."""
        return (self.start, self.at, self.has_ended) if self.widget == widget and self.kind == 5 else None

    def keyed(self, widget: str) -> tuple[str, bool] | None:
        """Return the name of a key and whether it went down, if one was used."""
        return (self.key, bool(self.number)) if self.widget == widget and self.kind == 6 else None


class Shapes:
    """The shapes of an open plot, canvas or scene."""

    def __init__(self, pen: _jde.Pen, dimensions: int) -> None:
        self._pen, self._dimensions = pen, dimensions

    def line(self, points: Iterable[Point], *, closed: bool = False, ink: int = Ink.PLAIN, width: float = 0.0) -> None:
        """Draw a line through points."""
        self._add(0, points, ink, width=width, flags=int(closed))

    def curve(self, name: str, points: Iterable[Point], *, ink: int = Ink.PLAIN) -> None:
        """Draw a curve of a plot."""
        self._add(0, points, ink, label=name)

    def points(self, points: Iterable[Point], *, ink: int = Ink.PLAIN, width: float = 0.0) -> None:
        """Draw separate points."""
        self._add(1, points, ink, width=width)

    def arrow(self, start: Point, end: Point, *, ink: int = Ink.PLAIN, width: float = 0.0) -> None:
        """Draw an arrow."""
        self._add(2, [start, end], ink, width=width)

    def label(self, at: Point, text: str, *, ink: int = Ink.PLAIN) -> None:
        """Write a text at a point."""
        self._add(3, [at], ink, label=text)

    def circle(
        self, at: Point, radius: float, *, filled: bool = False, ink: int = Ink.PLAIN, width: float = 0.0
    ) -> None:
        """Draw a circle of a canvas."""
        self._add(4, [at], ink, radius=radius, width=width, flags=2 * int(filled))

    def rectangle(self, low: Point, high: Point, *, ink: int = Ink.PLAIN, width: float = 0.0) -> None:
        """Draw the outline of a rectangle of a canvas."""
        (x, y), (right, top) = _numbers(low, 2), _numbers(high, 2)
        self.line([(x, y), (right, y), (right, top), (x, top)], closed=True, ink=ink, width=width)

    def polygon(self, corners: Iterable[Point], *, ink: int = Ink.PLAIN) -> None:
        """Draw a filled convex polygon of a canvas."""
        self._add(5, corners, ink)

    def robot(self, pose: Any, *, ink: int = Ink.PLAIN) -> None:
        """Draw the robot that the application drives at a pose of a canvas."""
        self._add(6, [pose], ink, turned=[0.0, 0.0, float(pose.theta)])

    def cuboid(
        self, at: Point, extent: Sequence[float], turned: Sequence[float] = (0, 0, 0), *, ink: int = Ink.PLAIN
    ) -> None:
        """Draw a box of a scene."""
        self._add(7, [at], ink, extent=list(map(float, extent)), turned=list(map(float, turned)))

    def sphere(self, at: Point, radius: float, *, ink: int = Ink.PLAIN) -> None:
        """Draw a sphere of a scene."""
        self._add(8, [at], ink, radius=radius)

    def cylinder(
        self, at: Point, radius: float, height: float, turned: Sequence[float] = (0, 0, 0), *, ink: int = Ink.PLAIN
    ) -> None:
        """Draw a cylinder of a scene."""
        self._add(9, [at], ink, radius=radius, extent=[0.0, 0.0, float(height)], turned=list(map(float, turned)))

    def mesh(self, corners: Iterable[Point], *, ink: int = Ink.PLAIN) -> None:
        """Draw triangles of a scene, counter-clockwise seen from outside."""
        self._add(10, corners, ink)

    def _add(self, kind: int, points: Iterable[Point], ink: int, **fields: Any) -> None:
        listed = [_numbers(point, self._dimensions) for point in points]
        flat = [number for point in listed for number in point]
        self._pen.shape(kind, flat, len(listed), color=int(ink), **fields)


class Pen:
    """Draws the widgets of a panel, one below the other."""

    def __init__(self, pen: _jde.Pen) -> None:
        self._pen = pen

    def heading(self, text: str) -> None:
        """Add a heading."""
        self.text(text, Words.HEADING)

    def text(self, text: str, style: Words = Words.PLAIN) -> None:
        """Add a text."""
        self._pen.add(0, label=text, number=int(style))

    def value(self, label: str, value: float, unit: str = "") -> None:
        """Add a number with its name."""
        self._pen.add(1, label=label, value=value, unit=unit)

    def button(self, id: str, label: str, *, enabled: bool = True) -> None:
        """Add a button."""
        self._pen.add(2, id=id, label=label, flags=0 if enabled else 16)

    def toggle(self, id: str, label: str, on: bool) -> None:
        """Add a toggle."""
        self._pen.add(3, id=id, label=label, number=int(on))

    def slider(self, id: str, label: str, value: float, least: float, greatest: float, unit: str = "") -> None:
        """Add a slider."""
        self._pen.add(4, id=id, label=label, value=value, least=least, greatest=greatest, unit=unit)

    def choice(self, id: str, label: str, options: Sequence[str], chosen: int) -> None:
        """Add a choice among options."""
        self._pen.add(5, id=id, label=label, texts=list(options), number=chosen)

    def image(self, id: str, pixels: Any, width: int, height: int, channels: int, *, clicks: bool = False) -> None:
        """Add an image: rows of pixels from the top, of 1 (grey), 3 (red, green, blue) or 4 bytes."""
        data = bytes(memoryview(pixels).cast("B"))
        self._pen.add(
            6, id=id, pixels=data, width=width, height=height, channels=channels, flags=_wants(clicks, False, False)
        )

    def table(self, id: str, headings: Sequence[str], rows: Iterable[Sequence[str]]) -> None:
        """Add a table."""
        cells = [str(cell) for row in rows for cell in row]
        self._pen.add(7, id=id, texts=[*headings, *cells], number=len(headings))

    @contextmanager
    def row(self) -> Iterator[None]:
        """Put the widgets within beside each other."""
        self._pen.add(8)
        yield
        self._pen.close()

    @contextmanager
    def group(self, id: str, label: str, *, folded: bool = False) -> Iterator[None]:
        """Put the widgets within below a label."""
        self._pen.add(9, id=id, label=label, flags=32 if folded else 0)
        yield
        self._pen.close()

    @contextmanager
    def plot(self, id: str, label: str, *, axes: tuple[str, str] = ("", "")) -> Iterator[Shapes]:
        """Add a plot of the curves within."""
        self._pen.add(10, id=id, label=label, texts=list(axes))
        yield Shapes(self._pen, 2)
        self._pen.close()

    @contextmanager
    def canvas(
        self,
        id: str,
        *,
        area: Sequence[float] = (0, 0, 0, 0),
        forward_up: bool = False,
        clicks: bool = False,
        drags: bool = False,
        keys: bool = False,
    ) -> Iterator[Shapes]:
        """Add a plane in metres with the shapes within. `area` is its least x and y, and its greatest, at first."""
        flags = _wants(clicks, drags, keys) | (8 if forward_up else 0)
        self._pen.add(11, id=id, area=list(map(float, area)), flags=flags)
        yield Shapes(self._pen, 2)
        self._pen.close()

    @contextmanager
    def scene(
        self, id: str, frame: str, *, clicks: bool = False, drags: bool = False, keys: bool = False
    ) -> Iterator[Shapes]:
        """Add a space in metres, in a frame of REP-105, with the shapes within."""
        self._pen.add(12, id=id, label=frame, flags=_wants(clicks, drags, keys))
        yield Shapes(self._pen, 3)
        self._pen.close()


def _wants(clicks: bool, drags: bool, keys: bool) -> int:
    return int(clicks) | 2 * int(drags) | 4 * int(keys)


def _numbers(point: Point, dimensions: int) -> list[float]:
    named_point: Any = point
    if hasattr(point, "x"):
        named = [float(named_point.x), float(named_point.y), float(getattr(point, "z", 0.0))]
        return named[:dimensions]
    numbers = [float(number) for number in point]
    if len(numbers) != dimensions:
        raise ValueError(f"a point here has {dimensions} numbers, not {len(numbers)}")
    return numbers
