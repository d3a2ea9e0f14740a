"""The ports of a schema: what its attributes are declared as, and what they are during a call."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, fields, replace
from enum import Enum, IntEnum
from typing import TYPE_CHECKING, Any, Generic, TypeVar, overload

from jde._errors import NoValue

if TYPE_CHECKING:
    from typing_extensions import Self

    from jde import _jde
    from jde._schema import Schema

T = TypeVar("T")


class Outcome(IntEnum):
    """What became of a value. None of them is a fault."""

    ACCEPTED = 0
    REFUSED = 2
    """The schema has no authority at this instant, a guard refuses the command, or an operator holds the child."""
    NOT_FINITE = 3
    UNBOUND = 5
    OUT_OF_RANGE = 8

    @property
    def accepted(self) -> bool:
        """Whether the value took effect."""
        return self is Outcome.ACCEPTED


@dataclass
class Options:
    """What the declaration of a port states beside its type."""

    unit: str = ""
    optional: bool = False
    trigger: bool = False
    fixed: bool = False
    mount: bool = False
    margin: bool = False
    limit: bool = False
    default: Any = None
    min: float | None = None
    max: float | None = None
    validity: str | float = 0
    lasting: bool = False
    child: str = ""
    name: str = ""
    was: str = ""

    def attributes(self) -> list[str]:
        """The names of what the port has: the extension module knows those that are attributes."""
        return [option.name for option in fields(self) if option.type == "bool" and getattr(self, option.name)]


class Port(Generic[T]):
    """A port. Each schema has its own, with a number."""

    role = ""
    number = -1
    layout: _jde.Layout
    choice: type[Enum] | None = None

    def __init__(self, options: Options | None = None) -> None:
        self.options = options or Options()
        self.name = ""

    def numbered(self, number: int, name: str, layout: _jde.Layout, choice: type[Enum] | None) -> Self:
        """Return the port of a schema."""
        port = type(self)(replace(self.options))
        port.number, port.name, port.layout, port.choice = number, name, layout, choice
        return port

    def of(self, value: Any) -> T:
        """Return a value as the port's type: the name of a choice for its number."""
        shown: T = value if self.choice is None else list(self.choice)[value]
        return shown

    def to(self, value: T) -> Any:
        """Return what crosses the boundary for a value: the number of a choice."""
        if self.choice is None:
            return value
        if not isinstance(value, self.choice):
            raise TypeError(f"`{self.name}` is one of {', '.join(map(str, self.choice))}, not {value!r}")
        return list(self.choice).index(value)

    def __set__(self, schema: Schema, value: Any) -> None:
        raise AttributeError(f"`{self.name}` is a port of the schema and cannot be replaced")


class Input(Port[T]):
    """A port whose value the schema reads."""

    @overload
    def __get__(self, schema: None, owner: type[Schema]) -> Self: ...
    @overload
    def __get__(self, schema: Schema, owner: type[Schema]) -> T: ...
    def __get__(self, schema: Schema | None, owner: type[Schema]) -> Self | T:
        if schema is None:
            return self
        value = schema._cx._raw.read(self.number)
        if value is None:
            raise NoValue(f"{self.role} `{self.name}` has no value")
        return value if self.choice is None else self.of(value)


class Import(Input[T]):
    """A variable of another schema. Reading one without a value raises `NoValue`."""

    role = "import"


class Modulation(Input[T]):
    """An input that the father or an operator writes. It always has a value."""

    role = "modulation"


class Command(Input[T]):
    """An input of a driver that reaches an actuator: the neutral value when no command is in force."""

    role = "command"


class Output(Port[T]):
    """A port whose values the schema writes."""


class Writer(Generic[T]):
    """An output during a call."""

    __slots__ = ("_cx", "_port")

    def __init__(self, port: Output[T], schema: Schema) -> None:
        self._port = port
        self._cx = schema._cx

    def _write(self, value: T, time: float | None) -> Outcome:
        port = self._port
        if port.choice is not None:
            value = port.to(value)
        try:
            time_ns = 0 if time is None else _nanoseconds(time)
            return Outcome(self._cx._raw.write(port.number, value, time_ns))
        except (TypeError, ValueError) as error:
            raise type(error)(f"{port.role} `{port.name}`: {error}") from None


class ExportWriter(Writer[T]):
    """An export during a call."""

    __slots__ = ()

    def write(self, value: T, time: float | None = None) -> Outcome:
        """Publish a value, measured at that time, s since the application's start; now if it is left out."""
        return self._write(value, time)

    def retract(self) -> None:
        """Retract the newest value, because it is no longer valid."""
        self._cx._raw.retract(self._port.number)


class ActuatorWriter(Writer[T]):
    """An actuator during a call."""

    __slots__ = ()

    def command(self, value: T) -> Outcome:
        """Command the actuator. Without authority the command is refused, which is no error."""
        return self._write(value, None)


class ModulationWriter(Writer[T]):
    """A modulation of a child during a call."""

    __slots__ = ()

    def set(self, value: T) -> Outcome:
        """Set the modulation."""
        return self._write(value, None)


class Export(Output[T]):
    """A variable that this schema writes and any may read."""

    role = "export"

    @overload
    def __get__(self, schema: None, owner: type[Schema]) -> Self: ...
    @overload
    def __get__(self, schema: Schema, owner: type[Schema]) -> ExportWriter[T]: ...
    def __get__(self, schema: Schema | None, owner: type[Schema]) -> Self | ExportWriter[T]:
        return self if schema is None else ExportWriter(self, schema)


class Actuator(Output[T]):
    """A driver's command that this motor schema writes."""

    role = "actuator"

    @overload
    def __get__(self, schema: None, owner: type[Schema]) -> Self: ...
    @overload
    def __get__(self, schema: Schema, owner: type[Schema]) -> ActuatorWriter[T]: ...
    def __get__(self, schema: Schema | None, owner: type[Schema]) -> Self | ActuatorWriter[T]:
        return self if schema is None else ActuatorWriter(self, schema)


class Modulates(Output[T]):
    """A modulation of a child that this schema writes."""

    role = "modulates"

    @overload
    def __get__(self, schema: None, owner: type[Schema]) -> Self: ...
    @overload
    def __get__(self, schema: Schema, owner: type[Schema]) -> ModulationWriter[T]: ...
    def __get__(self, schema: Schema | None, owner: type[Schema]) -> Self | ModulationWriter[T]:
        return self if schema is None else ModulationWriter(self, schema)


def trigger(*, unit: str = "", optional: bool = False) -> Any:
    """An import whose new values make the schema check at once."""
    return Import(Options(unit=unit, optional=optional, trigger=True))


def export(*, lasting: bool = False, validity: str | float = 0, unit: str = "") -> Any:
    """An export whose values are valid for three periods of the schema, for `validity`, or until they are replaced."""
    return Export(Options(lasting=lasting, validity=validity, unit=unit))


def optional(*, unit: str = "") -> Any:
    """An import or an actuator that the application may leave unbound: `Import[...] = optional()`."""
    return Port(Options(unit=unit, optional=True))


def unit(symbols: str) -> Any:
    """A port of a plain number with this unit: `Export[float] = unit("m")`."""
    return Port(Options(unit=symbols))


def modulation(
    default: Any,
    *,
    unit: str = "",
    min: float | None = None,
    max: float | None = None,
    fixed: bool = False,
    mount: bool = False,
    margin: bool = False,
    limit: bool = False,
    was: str = "",
) -> Any:
    """A modulation: its default, its unit and its limits. A fixed one is read when the schema awakes.

    `mount`, `margin` and `limit` say that several schemas must agree on it.
    `was` is the name of the version before, which files and options may still use.
    """
    return Modulation(
        Options(
            default=default, unit=unit, min=min, max=max, fixed=fixed, mount=mount, margin=margin, limit=limit, was=was
        )
    )


def command(neutral: Any, *, validity: str | float, trigger: bool = False, unit: str = "") -> Any:
    """A command of a driver: the value that stops the actuator, and how long a command is in force (`"500ms"`).

    With `trigger` a new command lets the driver iterate at once.
    """
    return Command(Options(default=neutral, validity=validity, trigger=trigger, unit=unit))


def modulates(child: str, name: str, *, unit: str = "", optional: bool = False) -> Any:
    """The modulation `name` of a child, which is an attribute of the schema."""
    return Modulates(Options(child=child, name=name, unit=unit, optional=optional))


def _nanoseconds(time: float) -> int:
    if not 0.0 <= time < 9e9:
        raise ValueError(f"{time!r} is not a time: it is in seconds since the application's start")
    return round(time * 1e9)


def names_of(choice: type[Enum]) -> list[str]:
    """Return the names of a choice, as files write them: `very-fast`."""
    return [name.lower().replace("_", "-") for name in _names(choice)]


def _names(choice: Iterable[Enum]) -> list[str]:
    return [member.name for member in choice]
