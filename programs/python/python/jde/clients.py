"""Running applications: their values and records, and the actions of an operator."""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import subprocess
import tempfile
import threading
from collections.abc import AsyncIterator, Iterator, Sequence
from types import TracebackType
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from jde import _executable, _jde

if TYPE_CHECKING:
    from typing_extensions import Self

#: How long an action of an operator outlives a process that dies, s.
LEASE = 1.0


class RemoteSample(NamedTuple):
    """A value of a variable; `None` if there is none."""

    value: Any
    #: When it was measured or written, s since the start of the application.
    time: float
    #: Counts the values of the variable from 1.
    sequence: int


class Watch:
    """What arrives from an application, for `for` and for `async for`. At most 1000 arrivals wait."""

    def __init__(self, native: _jde.Watch, sample: bool = False) -> None:
        """Take a subscription; the methods of `Remote` make one."""
        self._native, self._sample = native, sample

    @property
    def missed(self) -> int:
        """Arrivals that were dropped because the program took too few."""
        return self._native.missed

    def receive(self, timeout: float | None = None) -> Any:
        """Wait for the next arrival, at most so many seconds; `None` after that time or at the end."""
        arrival = self._native.receive(timeout)
        return RemoteSample(*arrival) if self._sample and arrival is not None else arrival

    def __iter__(self) -> Iterator[Any]:
        """Yield each arrival until the watch is closed or the application is gone."""
        while (arrival := self.receive()) is not None:
            yield arrival

    async def __aiter__(self) -> AsyncIterator[Any]:
        """Yield each arrival; other tasks run meanwhile."""
        while True:
            # Asked before, so that what has arrived by the end is still received.
            is_over = self._native.is_over
            # Short, so that a task that was cancelled leaves no thread behind.
            arrival = await asyncio.to_thread(self.receive, 0.1)
            if arrival is not None:
                yield arrival
            elif is_over:
                return

    def close(self) -> None:
        """End the subscription."""
        self._native.close()

    def __enter__(self) -> Self:
        """Return the watch itself, which ends with the block."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End the subscription."""
        self.close()


class Variables:
    """The variables of a schema as attributes: the newest sample, and a modulation that is written."""

    __slots__ = ("_remote", "_schema")
    _remote: Remote
    _schema: str

    def __init__(self, remote: Remote, schema: str) -> None:
        """Take a connection and the name of a schema."""
        object.__setattr__(self, "_remote", remote)
        object.__setattr__(self, "_schema", schema)

    def __dir__(self) -> list[str]:
        """Return the names of the variables."""
        before = f"{self._schema}."
        return [name.removeprefix(before) for name in self._remote.variables if name.startswith(before)]

    def __getattr__(self, name: str) -> RemoteSample:
        """Return the newest value of a variable with its time and number."""
        return self._remote.sample(self._known(name))

    def __setattr__(self, name: str, value: Any) -> None:
        """Write a modulation or the period."""
        self._remote[self._known(name)] = value

    def _known(self, name: str) -> str:
        known = dir(self)
        if name not in known:
            raise AttributeError(f"schema `{self._schema}` has no variable `{name}`, but {', '.join(known)}")
        return f"{self._schema}.{name}"


class Remote:
    """A running application, on this machine or afar.

    `robot["pioneer.laser"]` is the newest value of a variable, as in a `Run`; `robot["goon.fast"] = "30 cm/s"` writes
    a modulation or a period as an operator (R14), until it is released. `robot.pioneer.laser` is the newest value with
    its time; `robot.goon.fast = "30 cm/s"` writes too. A schema named as a method is no attribute: `robot["stop.fast"]`.
    """

    def __init__(self, native: _jde.Remote, at: Sequence[str] = (), key: str = "") -> None:
        """Take a connection, its endpoints, and the text of a key file for them; `connect` makes one."""
        self._native, self._at, self._key = native, tuple(at), key

    @property
    def name(self) -> str:
        """The name of the application."""
        return self._native.name

    @property
    def is_alive(self) -> bool:
        """Whether the application can be reached."""
        return self._native.is_alive

    @property
    def variables(self) -> dict[str, str]:
        """The full names of the variables, and the names of their types."""
        return self._native.variables()

    def __getitem__(self, name: str) -> Any:
        """Return the newest value of a variable; `None` without one."""
        return self.sample(name).value

    def __setitem__(self, name: str, value: Any) -> None:
        """Write a modulation or a period."""
        self._native.write(name, value)

    def __getattr__(self, name: str) -> Variables:
        """Return the variables of a schema."""
        # Names with underscores are those by which Python learns what an object can do.
        known = [] if name.startswith("_") else self._schemas()
        if name not in known:
            raise AttributeError(f"no schema with variables is called `{name}`; there are {', '.join(known)}")
        return Variables(self, name)

    def __setattr__(self, name: str, value: Any) -> None:
        """Refuse names without an underscore: only the variables of a schema are written."""
        if not name.startswith("_"):
            raise AttributeError(f"`{name}` is not a variable: write one of a schema, as in `robot.goon.fast = 0.2`")
        super().__setattr__(name, value)

    def __dir__(self) -> list[str]:
        """Return the methods, and the names of the schemas that no method has."""
        return list(dict.fromkeys([*super().__dir__(), *self._schemas()]))

    def sample(self, name: str) -> RemoteSample:
        """Return the newest value of a variable with its time and number."""
        return RemoteSample(*self._native.get(name))

    def watch(self, name: str, *, rate: float | None = None) -> Watch:
        """Receive the values of a variable as samples: all, or at most `rate` a second."""
        return Watch(self._native.watch(name, rate), sample=True)

    def panel(self, schema: str, *, rate: float = 10.0) -> Watch:
        """Receive the drawings of a schema's panel, at most `rate` a second."""
        return Watch(self._native.watch_panel(schema, rate))

    def records(self, *kinds: Literal["decisions", "states", "events"], last: int = 0) -> Watch:
        """Receive the last records of these kinds and then each new one."""
        return Watch(self._native.watch_records(list(kinds), last))

    def snapshot(self) -> dict[str, Any]:
        """Return the state of every schema and group."""
        return self._native.snapshot()

    def why(self, question: str) -> str:
        """Answer a question as `jde why` does."""
        with self._target() as target:
            return _executable.call("why", *target, "--", *question.split(), environment=_environment())

    def play(self, schema: str) -> None:
        """Wake a schema as its father would."""
        self._operate("play", schema)

    def stop(self, schema: str) -> None:
        """Put a schema to sleep until it is released."""
        self._operate("stop", schema)

    def force(self, schema: str) -> None:
        """Make a schema the winner of its group while it is awake."""
        self._operate("force", schema)

    def release(self, schema: str) -> None:
        """Undo what operators did to a schema."""
        self._operate("release", schema)

    def stop_all(self) -> None:
        """Stop all schemas at once: every command is neutral until `release_all`."""
        self._native.operate(json.dumps({"action": "stop-all"}))

    def release_all(self) -> None:
        """Undo `stop_all`, whoever called it."""
        self._native.operate(json.dumps({"action": "release-all"}))

    def touch(self, schema: str, widget: str, touch: Any) -> None:
        """Apply a gesture to a widget of a schema's panel, such as `"pressed"` or `{"moved": 0.5}`."""
        gesture = {"widget": widget, "touch": touch}
        self._native.operate(json.dumps({"action": "touch", "schema": schema, "gesture": gesture}))

    @contextlib.contextmanager
    def hold(self, action: Literal["play", "stop", "force"], schema: str, *, lease: float = LEASE) -> Iterator[None]:
        """Act for the time of a block. If this process dies or the network is cut, the action ends after `lease` s."""
        with self._held(self._operate(action, schema, lease)):
            yield

    @contextlib.contextmanager
    def setting(self, name: str, value: Any, *, lease: float = LEASE) -> Iterator[None]:
        """Write a modulation or a period for the time of a block; likewise."""
        with self._held(self._native.write(name, value, lease)):
            yield

    @contextlib.contextmanager
    def record(self, file: str | os.PathLike[str], *patterns: str) -> Iterator[None]:
        """Record the variables that match, or all, to a file for the time of a block; see `jde record`."""
        said: list[str] = []
        has_begun = False
        with self._target() as target:
            command = _executable.command("record", *target, "--", os.fspath(file), *patterns)
            recorder = subprocess.Popen(
                command,
                env=_environment(),
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                text=True,
                errors="replace",
            )
            assert recorder.stdout is not None
            # It never waits for a reader.
            reader = threading.Thread(target=said.extend, args=(recorder.stdout,))
            try:
                for line in recorder.stdout:
                    said.append(line)
                    if line.startswith("recording "):
                        has_begun = True
                        reader.start()
                        yield
                        break
            finally:
                # A program that a script starts with & ignores SIGINT, and so would the recorder.
                recorder.terminate()
                if reader.is_alive():
                    reader.join()
                said.extend(recorder.stdout)
                recorder.stdout.close()
                status = recorder.wait()
        if status != 0 or not has_begun:
            raise _jde.Error("".join(said).strip())

    @contextlib.contextmanager
    def _target(self) -> Iterator[list[str]]:
        """Return the options of the executable that select this application."""
        target = ["--app", self._native.address, *(part for endpoint in self._at for part in ("--at", endpoint))]
        if not self._key:
            yield target
            return
        with tempfile.NamedTemporaryFile("w", suffix=".toml") as key:
            key.write(self._key)
            key.flush()
            yield [*target, "--key", key.name]

    def _schemas(self) -> list[str]:
        return list(dict.fromkeys(name.partition(".")[0] for name in self.variables))

    def _operate(self, action: str, schema: str, lease: float | None = None) -> _jde.Lease | None:
        return self._native.operate(json.dumps({"action": action, "schema": schema}), lease)

    @contextlib.contextmanager
    def _held(self, lease: _jde.Lease | None) -> Iterator[None]:
        assert lease is not None, "a lease was asked for"
        try:
            yield
        finally:
            lost = lease.lost
            lease.close()
            if lost is not None:
                raise _jde.Error(f"the action ended before its block: {lost}")


def connect(
    name: str | None = None,
    *,
    at: Sequence[str] = (),
    user: str | None = None,
    password_file: str | os.PathLike[str] | None = None,
    authority: str | os.PathLike[str] | None = None,
    certificate: str | os.PathLike[str] | None = None,
    key: str | os.PathLike[str] | None = None,
) -> Remote:
    """Connect to the application of a name, or to the only one.

    Without `at` it is one of this user on this machine; otherwise one behind these endpoints, such as
    `tls/robot2.local:7447`, to which `user` and `password_file`, or `certificate` and `key`, prove who connects, and
    whose certificates `authority` has signed.
    """
    if (user is None) != (password_file is None):
        raise ValueError("`user` and `password_file` belong together")
    if (certificate is None) != (key is None):
        raise ValueError("`certificate` and `key` belong together")
    login = None if user is None or password_file is None else (user, os.fspath(password_file))
    identity = None if certificate is None or key is None else (os.fspath(certificate), os.fspath(key))
    signed_by = None if authority is None else os.fspath(authority)
    native = _jde.Remote(name, list(at), login, signed_by, identity)
    return Remote(native, at, _key_file(login, signed_by, identity) if at else "")


def _key_file(login: tuple[str, str] | None, authority: str | None, identity: tuple[str, str] | None) -> str:
    """Return the text of the key file of the executable with these credentials."""
    tls = {"authority": authority, "certificate": identity and identity[0], "key": identity and identity[1]}
    text = "" if login is None else f"user = {_quoted(login[0])}\npassword-file = {_path(login[1])}\n"
    given = [f"{name} = {_path(file)}\n" for name, file in tls.items() if file is not None]
    return text + "".join(["[tls]\n", *given] if given else [])


def _path(file: str) -> str:
    return _quoted(os.path.abspath(file))


def _quoted(text: str) -> str:
    return json.dumps(text, ensure_ascii=False)


def _environment() -> dict[str, str]:
    """Return the environment of the executable without the variables that select an application."""
    return {name: value for name, value in os.environ.items() if name not in ("JDE_APP", "JDE_AT", "JDE_KEY")}
