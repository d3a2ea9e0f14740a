"""Runs: an application in lockstep that a program steps, reads and operates."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping, Sequence
from types import TracebackType
from typing import TYPE_CHECKING, Any

from jde import _executable, _jde
from jde.series import Series

if TYPE_CHECKING:
    from typing_extensions import Self


class Application:
    """An application that was loaded and checked, and that can be started many times."""

    def __init__(
        self,
        file: str | os.PathLike[str],
        *,
        set: Mapping[str, Any] | None = None,
        mocks: Sequence[str] = (),
    ) -> None:
        """Load the application of a file.

        `set` gives modulations and periods other values than the file: numbers, lists, dictionaries, or texts as
        `jde run --set` takes them, such as `{"goon.fast": "30 cm/s"}`. Paths start in the working directory. The
        schemas in `mocks` are not called: the run writes what they export and command.
        """
        self._native = _jde.Application(os.fspath(file), dict(set or {}), list(mocks), _executable.find())

    @property
    def name(self) -> str:
        """The name of the application."""
        return self._native.name

    @property
    def schemas(self) -> list[str]:
        """The names of the schemas."""
        return self._native.schemas

    @property
    def variables(self) -> dict[str, str]:
        """The full names of the variables, and the names of their types."""
        return self._native.variables

    def run(self, *, seed: int | None = None, limit: float | None = None, records: bool = True) -> Run:
        """Start the application at time 0. It ends after `limit` seconds of its time.

        Without `records`, decisions, events, traces and conditions are not available, and time passes faster.
        """
        return Run(self._native.run(seed, limit, records))


class Run:
    """An application in lockstep. Time passes only in `step` and `until`.

    `run["pioneer.laser"]` is the newest value of a variable, or `None`; its fields are attributes, and sequences of
    numbers are read-only arrays. `run["pioneer.truth.pose.x"]` is a part of it. `run["goon.fast"] = "30 cm/s"`
    writes a modulation as an operator (R14), a period, or what a mock exports or commands. In a notebook, a run is the
    paths of its traced poses.
    """

    def __init__(self, native: _jde.Run) -> None:
        """Take a started application; `jde.run` starts one."""
        self._native = native
        self._traced: list[str] = []

    def __enter__(self) -> Self:
        """Return the run itself, which ends with the block."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Bring the application to rest."""
        self.close()

    @property
    def name(self) -> str:
        """The name of the application."""
        return self._native.name

    @property
    def time(self) -> float:
        """The time since the start, s."""
        return self._native.time

    @property
    def outcome(self) -> str | None:
        """How the application ended; `None` while it runs."""
        return self._native.outcome

    def step(self) -> bool:
        """Run the next instant at which anything is due. Return whether there was one and the application goes on."""
        return self._native.step()

    def until(self, target: float | str | Callable[[Run], object], *, within: float | None = None) -> bool:
        """Run until a time in seconds, a condition in words, or until a function of the run returns a true value.

        A condition is one of `jde run --break`, such as `"vff.won and clearance < 0.2"`. `within` limits the time
        for a condition or a function, s. Return whether the target was reached. An exception of the function, and
        Ctrl-C, bring the application to rest.
        """
        end = None if within is None else self.time + within
        if isinstance(target, str):
            return self._native.until_condition(target, end)
        if not callable(target):
            self._native.until_time(float(target))
            return self._native.has_reached(float(target))
        try:
            while not target(self):
                if (end is not None and self._native.has_reached(end)) or not self._native.step(end):
                    return False
        except BaseException:
            self.close()
            raise
        return True

    def close(self) -> None:
        """Bring the application to rest. Its variables and records can still be read."""
        self._native.close()

    def __getitem__(self, name: str) -> Any:
        """Return the newest value of a variable or of a part of it."""
        return self._native[name]

    def __setitem__(self, name: str, value: Any) -> None:
        """Write a modulation, a period, or a port of a mock."""
        self._native[name] = value

    def play(self, schema: str) -> None:
        """Wake a schema as its father would."""
        self._native.play(schema)

    def stop(self, schema: str) -> None:
        """Put a schema to sleep until it is released."""
        self._native.stop(schema)

    def force(self, schema: str) -> None:
        """Make a schema the winner of its group while it is awake."""
        self._native.force(schema)

    def release(self, schema: str) -> None:
        """Undo what operators did to a schema."""
        self._native.release(schema)

    def edit(self, driver: str, **edit: Any) -> None:
        """Change the world of a simulated robot, through the driver of the robot, at its next iteration.

        `run.edit("pioneer", add={"name": "door", "center": [2, 1], "size": [0.9, 0.1]})`; likewise `remove`,
        `place`, `halt`, `resume`, `raise` and `lower`. `run["pioneer.edits"]` counts the edits that were refused, and says why.
        """
        self._native.edit(driver, **edit)

    def panel(self, schema: str) -> dict[str, Any] | None:
        """Return the newest drawing of a schema's panel; it is drawn from the first call on, while time passes."""
        return self._native.panel(schema)

    def touch(self, schema: str, widget: str, touch: Any) -> None:
        """Apply a gesture to a widget of a schema's panel, such as `"pressed"` or `{"moved": 0.5}`."""
        self._native.touch(schema, json.dumps({"widget": widget, "touch": touch}))

    def winner(self, group: str) -> str | None:
        """Return the winner of a group such as `roots` or `example/base`."""
        return self._native.winner(group)

    def has_authority(self, schema: str) -> bool:
        """Return whether what a schema commands now takes effect: it and all its fathers are WINNER (R7)."""
        return self._native.has_authority(schema)

    def snapshot(self) -> dict[str, Any]:
        """Return the state of every schema and group."""
        return self._native.snapshot()

    @property
    def decisions(self) -> list[dict[str, Any]]:
        """The selections so far, with their reasons; at most the newest 100 000, likewise below."""
        return self._native.records("decisions")

    @property
    def states(self) -> list[dict[str, Any]]:
        """The changes of state so far."""
        return self._native.records("states")

    @property
    def events(self) -> list[dict[str, Any]]:
        """All other events so far."""
        return self._native.records("events")

    def trace(self, *names: str) -> None:
        """Keep the values of these variables from now on, in memory: of each instant the last."""
        for name in names:
            self._native.start_trace(name)
            self._traced.append(name)

    def series(self, name: str) -> Series:
        """Return the values of a traced variable as arrays. Needs NumPy."""
        return Series(name, *self._native.trace(name))

    def _repr_png_(self) -> bytes | None:
        """Return the paths of the traced poses from above, which a notebook shows."""
        traced = [self.series(name) for name in dict.fromkeys(self._traced)]
        paths = [(series.name, poses) for series in traced if (poses := series.poses()) is not None]
        return _jde.draw_paths(self.name, paths) if paths else None


def run(
    file: str | os.PathLike[str],
    *,
    seed: int | None = None,
    set: Mapping[str, Any] | None = None,
    limit: float | None = None,
    mocks: Sequence[str] = (),
) -> Run:
    """Start an application in lockstep; the arguments are those of `Application` and of its `run`."""
    return Application(file, set=set, mocks=mocks).run(seed=seed, limit=limit)
