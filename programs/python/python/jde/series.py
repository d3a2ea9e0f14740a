"""The values of a variable over time, as arrays."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

from jde import _jde

if TYPE_CHECKING:
    import numpy as np
    import pandas as pd


class Series:
    """The values of a variable, in the order of their times.

    `times` are seconds since the start of the application. `data` is a structured array with the fields of the
    type. `series["pose.x"]` is the array of one field. A sequence that always has the same length is an array of
    two dimensions, otherwise a list of arrays. In a notebook, a series is its picture.
    """

    def __init__(self, name: str, times_ns: Sequence[int], values: bytes, dtype: Any) -> None:
        """Make arrays of the times, ns, and of the bytes of the values. Needs NumPy."""
        import numpy as np

        self.name = name
        self.times: np.ndarray[Any, Any] = np.asarray(times_ns, dtype=np.int64) / 1e9
        self.data: np.ndarray[Any, Any] = np.frombuffer(values, dtype=np.dtype(dtype))

    def __len__(self) -> int:
        """Return the number of values."""
        return len(self.times)

    def __repr__(self) -> str:
        """Return the name and the extent."""
        if not len(self):
            return f"<Series {self.name}: no values>"
        return f"<Series {self.name}: {len(self)} values from {self.times[0]:.3f} s to {self.times[-1]:.3f} s>"

    def __getitem__(self, path: str) -> Any:
        """Return the array of a field, such as `twist.linear.x`."""
        data = self.data
        *parents, last = path.split(".")
        for name in parents:
            data = _field(data, name, path)
        field = _field(data, last, path)
        lengths = data[f"{last}.length"] if f"{last}.length" in _names(data) else None
        if field.dtype.kind == "S":
            return [text.decode(errors="replace") for text in field]
        if lengths is None or not len(lengths):
            return field
        if (lengths == lengths[0]).all():
            return field[:, : lengths[0]]
        return [values[:length] for values, length in zip(field, lengths, strict=True)]

    def frame(self) -> pd.DataFrame:
        """Return the numbers and texts as columns, by time. Sequences are left out. Needs pandas."""
        import pandas as pd

        columns = {path: self[path] for path in self.paths()}
        return pd.DataFrame(columns, index=pd.Index(self.times, name="time"))

    def paths(self) -> list[str]:
        """Return the paths of all numbers and texts that are no sequences."""
        return list(_paths(self.data.dtype, ""))

    def poses(self) -> list[list[float]] | None:
        """Return times, s, places, m, and headings, rad, of a type with one pose; `None` for others."""
        import numpy as np

        names = self.paths()
        for before in ("pose.", ""):
            if f"{before}theta" in names:
                x, y, heading = (self[before + name] for name in ("x", "y", "theta"))
                return np.column_stack([self.times, x, y, heading]).tolist()  # type: ignore[no-any-return]
        for before in ("pose.pose.", "pose.", ""):
            if f"{before}orientation.w" in names:
                x, y, z, w = (self[f"{before}orientation.{name}"] for name in "xyzw")
                heading = np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
                x, y = (self[f"{before}position.{name}"] for name in "xy")
                return np.column_stack([self.times, x, y, heading]).tolist()  # type: ignore[no-any-return]
        return None

    def picture(self, *fields: str, width: int = 1200, height: int = 400) -> bytes:
        """Return these numbers over time as PNG; without names the path of a pose from above, or all numbers."""
        import numpy as np

        if not fields and (poses := self.poses()) is not None:
            return _jde.draw_paths(self.name, [(self.name, poses)])
        numbers = []
        for path in fields or self.paths():
            values = self[path]
            if isinstance(values, np.ndarray) and values.ndim == 1 and values.dtype.kind in "biuf":
                numbers.append((path, values.astype(float).tolist()))
            elif fields:
                raise ValueError(f"`{path}` of {self.name} is not one number")
        return _jde.draw_numbers(self.name, np.rint(self.times * 1e9).astype(int).tolist(), numbers, (width, height))

    def _repr_png_(self) -> bytes:
        return self.picture()


def _names(data: np.ndarray[Any, Any]) -> tuple[str, ...]:
    return data.dtype.names or ()


def _field(data: np.ndarray[Any, Any], name: str, path: str) -> np.ndarray[Any, Any]:
    if name not in _names(data):
        known = ", ".join(known for known in _names(data) if not known.endswith(".length"))
        raise KeyError(f"`{path}`: there is no field `{name}`; the fields are {known}")
    return data[name]


def _paths(dtype: np.dtype[Any], before: str) -> Iterator[str]:
    for name in dtype.names or ():
        field = dtype[name]
        if field.names:
            yield from _paths(field, f"{before}{name}.")
        elif not field.shape and not name.endswith(".length"):
            yield before + name
