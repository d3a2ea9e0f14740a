"""What a schema learns from its host during a call."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Generic, TypeVar

if TYPE_CHECKING:
    from jde import _jde
    from jde._ports import Command, Import, Modulation

T = TypeVar("T")

NEUTRAL = 1
DEFAULT = 2


@dataclass(frozen=True)
class Sample(Generic[T]):
    """A value of an input with its stamp."""

    value: T
    time: float
    """When it was measured or written, s since the application's start."""
    sequence: int
    """The number of the value, from 1."""
    writer: int
    """The instance that wrote it, as a number of the application."""
    in_force: bool
    """Of a command: whether one is in force. Otherwise the value is the neutral one."""
    is_default: bool
    """Of a modulation: whether nobody has written it."""


class Context:
    """The context of the present call of a schema. It works during the call, on the call's thread."""

    __slots__ = ("_raw",)
    _newest: ClassVar[_jde.Context | None] = None

    def __init__(self, raw: _jde.Context) -> None:
        self._raw = raw
        Context._newest = raw

    @property
    def now(self) -> float:
        """Time since the application's start, s. In lockstep it is constant during a call."""
        return self._raw.now_ns() / 1e9

    @property
    def name(self) -> str:
        """The instance's name in the application."""
        return self._raw.name()

    @property
    def seed(self) -> int:
        """A seed for random generators, derived from the application's seed and the name alone."""
        return self._raw.seed()

    @property
    def is_real_time(self) -> bool:
        """Whether the application runs in real time."""
        return self._raw.real_time()

    def require_real_time(self) -> None:
        """Raise an error in lockstep and in a replay: for what speaks to a device, in `awake`."""
        if not self.is_real_time:
            raise RuntimeError(
                "its device runs in real time, and the application does not: run it without --lockstep, and in no replay"
            )

    def sample(self, port: Import[T] | Modulation[T] | Command[T]) -> Sample[T] | None:
        """Return the value of an input with its stamp, or None if it has no value: `cx.sample(Shy.laser)`."""
        found = self._raw.sample(port.number)
        if found is None:
            return None
        value, time_ns, sequence, writer, flags = found
        return Sample(port.of(value), time_ns / 1e9, sequence, writer, not flags & NEUTRAL, bool(flags & DEFAULT))

    def trace(self, text: Any) -> None:
        """Write a message for the developer of this schema, which may occur in every iteration."""
        self._raw.log(0, str(text))

    def debug(self, text: Any) -> None:
        """Write a message for the developer of this schema."""
        self._raw.log(1, str(text))

    def info(self, text: Any) -> None:
        """Write a message for the operator of the application."""
        self._raw.log(2, str(text))

    def warn(self, text: Any) -> None:
        """Write about a problem after which the schema continues."""
        self._raw.log(3, str(text))

    def error(self, text: Any) -> None:
        """Write about a failure."""
        self._raw.log(4, str(text))
