"""Recordings as arrays."""

from __future__ import annotations

import os
from typing import Any

from jde import _executable, _jde
from jde.series import Series


class Recording:
    """A recording of `jde run --record` or `jde record`, or of another program in MCAP with ROS 2 types, or a bag of ROS 2.

    `recording["pioneer.truth"]` is a `Series`. In a notebook, a recording is its picture.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        """Open a file, or the folder of a recording in parts or of a bag."""
        self._path = os.fspath(path)
        self._native = _jde.Recording(self._path)

    @property
    def metadata(self) -> dict[str, str]:
        """What the recording says of its run, such as `application` and `seed`."""
        return self._native.metadata

    @property
    def damage(self) -> str | None:
        """Why the recording ends too early; `None` if it is complete."""
        return self._native.damage

    @property
    def left_out(self) -> list[str]:
        """The files and topics of another program that cannot be read, each with the reason."""
        return self._native.left_out

    @property
    def variables(self) -> dict[str, str]:
        """The names of the variables, and of their types."""
        return self._native.variables

    def __getitem__(self, name: str) -> Series:
        """Return the values of a variable. Times are those of measurement. Needs NumPy.

        Messages of another program that are no such values are left out, and a warning says so.
        """
        return Series(name, *self._native.series(name))

    def value(self, name: str, at: float | None = None) -> Any:
        """Return the newest value that had been published `at` a time of the application, s; without one, the last.

        It is the object that a schema reads, or the part of it that the name ends with; `None` if there was none, or if it
        had ended.
        """
        return self._native.value(name, at)

    @property
    def decisions(self) -> list[dict[str, Any]]:
        """The selections, with their reasons."""
        return self._native.records("decisions")

    @property
    def states(self) -> list[dict[str, Any]]:
        """The changes of state."""
        return self._native.records("states")

    @property
    def events(self) -> list[dict[str, Any]]:
        """All other events."""
        return self._native.records("events")

    def why(self, question: str) -> str:
        """Answer a question as `jde why` does, such as `did vff take over from goon`."""
        return _executable.call("why", *question.split(), "--in", self._path)

    def picture(self, *numbers: str, width: int = 1200, height: int = 800) -> bytes:
        """Return a picture as PNG: the path of the robots, or these numbers over time, and the states below."""
        return self._native.picture(list(numbers), (width, height))

    def _repr_png_(self) -> bytes:
        return self.picture()


def open(path: str | os.PathLike[str]) -> Recording:
    """Open a recording."""
    return Recording(path)
