"""Schemas: the class from which those of a plugin derive, and what it finds out about them."""

from __future__ import annotations

import inspect as signatures
import math
import pickle
import re
from dataclasses import dataclass
from numbers import Real
from typing import TYPE_CHECKING, Any, ClassVar, get_args, get_origin, get_type_hints

from jde import _jde
from jde._children import Candidate, Child, Level, Role, State, Verdict
from jde._context import Context
from jde._ports import Command, Import, Modulates, Modulation, Port, names_of
from jde._values import attribute_docs, layout_of

if TYPE_CHECKING:
    from jde.panel import Gesture, Pen

KINDS = ("perceptive", "motor", "driver")
# The functions of a schema, and their parameters beside the schema itself.
FUNCTIONS = {
    "awake": 1,
    "check": 1,
    "iterate": 1,
    "sleep": 1,
    "arbitrate": 2,
    "draw": 2,
    "touched": 2,
    "save": 1,
    "restore": 3,
    "inspect": 2,
}
# The kinds of function whose call only makes an object.
RETURN_AT_ONCE = (signatures.iscoroutinefunction, signatures.isgeneratorfunction, signatures.isasyncgenfunction)
# The end of times, ns.
LONGEST = 9e18
# The validity of a lasting export, ns.
LASTING = 2**64 - 1
UNITS = {"s": 1e9, "ms": 1e6, "us": 1e3, "ns": 1.0}


@dataclass(frozen=True)
class Precondition:
    """The result of a check: whether the schema is ready, and how urgent it is."""

    ready: bool
    urgency: float = 0.0


@dataclass(frozen=True)
class PortSpec:
    """A port, as the extension module reads it."""

    role: str
    name: str
    doc: str
    unit: str
    layout: _jde.Layout
    initial: Any
    least: float | None
    greatest: float | None
    choices: list[str]
    validity_ns: int
    attributes: list[str]
    former_name: str
    child: int


@dataclass(frozen=True)
class ChildSpec:
    """A role for a child, as the extension module reads it."""

    name: str
    doc: str
    motor: bool
    group: str
    optional: bool
    many: bool


@dataclass(frozen=True)
class SchemaSpec:
    """A schema, as the extension module reads it."""

    name: str
    doc: str
    kind: str
    period_ns: int
    budget_ns: int | None
    ports: list[PortSpec]
    children: list[ChildSpec]
    functions: list[str]
    layouts: list[_jde.Layout]


class Problems:
    """What an inspection found."""

    def __init__(self) -> None:
        self.found: list[tuple[int, bool, str]] = []

    def wrong(self, port: Modulation[Any], text: str) -> None:
        """Report what would make `awake` fail, until somebody changes it."""
        self.found.append((port.number, False, text))

    def unavailable(self, port: Modulation[Any], text: str) -> None:
        """Report what is missing at present, and for which the schema would wait."""
        self.found.append((port.number, True, text))


class Schema:
    """A schema: a class whose annotated attributes are its ports, with the functions below.

    Only `iterate` is required. Calls never overlap, and come from one thread. An error that leaves a function makes the
    schema Faulted.
    """

    __jde__: ClassVar[SchemaSpec]
    _cx: Context
    memory_version: ClassVar[int] = 1
    """The version of what `save` returns."""

    def __init_subclass__(
        cls, kind: str | None = None, period: str | float | None = None, budget: str | float | None = None, **more: Any
    ) -> None:
        try:
            super().__init_subclass__(**more)
        except TypeError as error:
            if not more:
                raise
            raise TypeError(
                f"{cls.__name__} states {', '.join(more)}, and a schema states kind, period and budget: {error}"
            ) from None
        if kind is None:
            if period is not None or budget is not None:
                raise TypeError(f'{cls.__name__} states no kind: write kind="motor", "perceptive" or "driver"')
            # A class that others extend.
            return
        if kind not in KINDS:
            raise TypeError(
                f"{cls.__name__} is of the kind {kind!r}; a schema is {', '.join(KINDS[:-1])} or {KINDS[-1]}"
            )
        if period is None:
            raise TypeError(f'{cls.__name__} states no period: write period="100ms"')
        docs: dict[str, str] = {}
        for base in reversed(cls.__mro__[:-1]):
            if base is not Schema:
                docs |= attribute_docs(base)
        ports, children = _declarations(cls)
        cls.__jde__ = SchemaSpec(
            name=cls.__name__,
            doc=signatures.cleandoc(vars(cls).get("__doc__") or ""),
            kind=kind,
            period_ns=_duration(period, f"{cls.__name__}: period"),
            budget_ns=None if budget is None else _duration(budget, f"{cls.__name__}: budget"),
            ports=[_port_spec(cls, port, docs.get(port.name, ""), children) for port in ports],
            children=[_child_spec(child, docs.get(child.name, "")) for child in children],
            functions=_functions(cls, kind),
            layouts=[port.layout for port in ports],
        )

    def awake(self, cx: Context) -> None:
        """Called when the schema leaves SLEPT: open devices, discard old data."""

    def check(self, cx: Context) -> bool | Precondition:
        """Called each period and by triggers: whether the precondition of a motor schema holds."""
        return True

    def iterate(self, cx: Context) -> None:
        """Called each period while the schema is WINNER: one step."""

    def sleep(self, cx: Context) -> None:
        """Called when the schema goes to SLEPT: stop what moves."""

    def arbitrate(self, cx: Context, level: Level) -> Verdict:
        """Called when several children of a group are ready, or none is: the father's own choice."""
        raise NotImplementedError

    def draw(self, cx: Context, pen: Pen) -> None:
        """Called while a viewer shows the panel: draw it, and change nothing."""

    def touched(self, cx: Context, gesture: Gesture) -> None:
        """Called when a person uses the panel."""

    def save(self, cx: Context) -> Any:
        """Return what the next build needs of the memory: anything that can be pickled."""

    def restore(self, cx: Context, saved: Any, version: int) -> None:
        """Take over what another build of that `memory_version` saved."""

    def inspect(self, cx: Context, problems: Problems) -> None:
        """Called before the application starts: report what the modulations name and what cannot work."""

    @classmethod
    def _make(cls, raw: _jde.Context) -> Schema:
        schema = cls.__new__(cls)
        schema._cx = Context(raw)
        schema.__init__()  # type: ignore[misc]
        return schema

    def _arbitrate(
        self, cx: Context, case: int, group: str, candidates: list[tuple[int, int, bool, float]], winner: int
    ) -> tuple[int, str]:
        found = [Candidate(number, State(state), ready, urgency) for number, state, ready, urgency in candidates]
        verdict = self.arbitrate(cx, Level(group, case == 1, found, None if winner < 0 else winner))
        if not isinstance(verdict, Verdict):
            raise TypeError("arbitrate returns level.choose(child, reason) or level.nobody(reason)")
        return (-1 if verdict.child is None else verdict.child.number), verdict.reason

    def _draw(self, cx: Context, pen: _jde.Pen) -> None:
        from jde.panel import Pen

        self.draw(cx, Pen(pen))

    def _touch(self, cx: Context, fields: dict[str, Any]) -> None:
        from jde.panel import Gesture

        self.touched(cx, Gesture(**fields))

    def _save(self, cx: Context) -> bytes:
        return pickle.dumps((self.memory_version, self.save(cx)))

    def _restore(self, cx: Context, saved: bytes) -> None:
        version, memory = pickle.loads(saved)
        self.restore(cx, memory, version)

    def _inspect(self, cx: Context) -> list[tuple[int, bool, str]]:
        problems = Problems()
        self.inspect(cx, problems)
        return problems.found


def _duration(time: str | float, what: str, *, may_be_zero: bool = False) -> int:
    """Return a time, `"100ms"` or a number of seconds, in ns."""
    nanoseconds = math.nan
    if isinstance(time, (int, float)):
        nanoseconds = time * 1e9
    elif isinstance(time, str) and (match := re.fullmatch(r"\s*(\d+\.?\d*|\.\d+)\s*(s|ms|us|ns)\s*", time)):
        nanoseconds = float(match[1]) * UNITS[match[2]]
    if math.isnan(nanoseconds):
        raise ValueError(f'{what}: {time!r} is not a time: write "100ms", "2s" or a number of seconds')
    if not (0.0 if may_be_zero else 0.5) <= nanoseconds < LONGEST:
        raise ValueError(f"{what}: {time!r} is not a time of a schema: write one above 0 and below 290 years")
    return round(nanoseconds)


def _declarations(cls: type[Schema]) -> tuple[list[Port[Any]], list[Role]]:
    """Number the ports and the children of a class, and make them its attributes."""
    ports: list[Port[Any]] = []
    children: list[Role] = []
    try:
        hints = get_type_hints(cls, include_extras=True)
    except NameError as error:
        raise TypeError(f"{cls.__name__}: an annotation names what is not defined: {error}") from None
    for name, hint in hints.items():
        origin = get_origin(hint) or hint
        if not isinstance(origin, type) or not issubclass(origin, (Port, Role)):
            continue
        given = getattr(cls, name, None)
        if issubclass(origin, Role):
            if not isinstance(given, origin):
                raise TypeError(
                    f'{cls.__name__}.{name} states no group: write child(group="base") or child(perceptive=True)'
                )
            role = given.numbered(len(children), name)
            setattr(cls, name, role)
            children.append(role)
            continue
        is_port = isinstance(given, (Port, Role))
        if is_port and not isinstance(given, origin) and type(given) is not Port:
            raise TypeError(
                f"{cls.__name__}.{name} is declared as {origin.__name__}, and its value makes it another port"
            )
        if not isinstance(given, origin) and issubclass(origin, (Modulation, Command, Modulates)):
            how = {
                Modulation: f"modulation({0.8 if is_port or given is None else given!r})",
                Command: 'command(Twist(), validity="500ms")',
                Modulates: 'modulates("cruise", "speed")',
            }
            states = "nothing but its type" if given is None else "no default" if is_port else repr(given)
            raise TypeError(f"{cls.__name__}.{name} states {states}: write {name}: {_written(hint)} = {how[origin]}")
        if given is not None and not is_port:
            raise TypeError(
                f"{cls.__name__}.{name} states {given!r}, and has no value of its own: write {name}: {_written(hint)}"
            )
        arguments = get_args(hint)
        if not arguments:
            raise TypeError(f"{cls.__name__}.{name} states no type of value: write {origin.__name__}[LaserScan]")
        try:
            layout, choice = layout_of(arguments[0])
        except TypeError as error:
            raise TypeError(f"{cls.__name__}.{name}: {error}") from None
        if choice is not None and not issubclass(origin, (Modulation, Modulates)):
            raise TypeError(f"{cls.__name__}.{name}: only modulations are choices")
        declared = origin(given.options) if given is not None else origin()
        port = declared.numbered(len(ports), name, layout, choice)
        setattr(cls, name, port)
        ports.append(port)
    _refuse_undeclared(cls)
    return ports, children


def _refuse_undeclared(cls: type[Schema]) -> None:
    """Refuse ports and children that no annotation declares."""
    for name in dir(cls):
        given = signatures.getattr_static(cls, name)
        kind = get_origin(given)
        if isinstance(kind, type) and issubclass(kind, (Port, Role)):
            raise TypeError(
                f"{cls.__name__}.{name} is a type, not a port of that type: write {name}: {_written(given)}"
            )
        if not isinstance(given, (Port, Role)) or given.number >= 0:
            continue
        if isinstance(given, Role):
            how = "Child = child(...)" if isinstance(given, Child) else "Children = children(...)"
        elif isinstance(given, Import):
            how = "Import[LaserScan] = trigger()"
        elif isinstance(given, Modulation):
            how = f"Modulation[{type(given.options.default).__name__}] = modulation({given.options.default!r})"
        elif isinstance(given, Command):
            how = f"Command[{type(given.options.default).__name__}] = command(...)"
        elif isinstance(given, Modulates):
            how = "Modulates[float] = modulates(...)"
        else:
            how = "Import[float] = optional()" if given.options.optional else 'Export[float] = unit("m")'
        raise TypeError(f"{cls.__name__}.{name} is a port or a child without its type: write {name}: {how}")


def _written(hint: Any) -> str:
    """Return an annotation as the source has it: `Modulation[float]`."""
    names = [getattr(argument, "__name__", str(argument)) for argument in get_args(hint)]
    return f"{(get_origin(hint) or hint).__name__}[{', '.join(names) or 'float'}]"


def _port_spec(cls: type[Schema], port: Port[Any], doc: str, children: list[Role]) -> PortSpec:
    options = port.options
    what = f"{cls.__name__}.{port.name}"
    for limit in ("min", "max"):
        given = getattr(options, limit)
        if given is not None and (not isinstance(given, Real) or math.isnan(given)):
            raise TypeError(f"{what}: {limit} is a number, and not {given!r}")
    if not isinstance(options.unit, str):
        raise TypeError(f'{what}: unit is a text such as "m", and not {options.unit!r}')
    try:
        initial = None if options.default is None else port.to(options.default)
        if initial is not None:
            port.layout.encode(initial)
    except (TypeError, ValueError) as error:
        raise type(error)(f"{what} has a default that is none of its type: {error}") from None
    child = 0
    if isinstance(port, Modulates):
        found = [role for role in children if role.name == options.child]
        if not found:
            raise TypeError(f"{what} modulates the child `{options.child}`, and the schema has no such child")
        child = found[0].number
    least, greatest = options.min, options.max
    if port.choice is not None and isinstance(port, Modulation):
        least, greatest = 0.0, len(port.choice) - 1.0
    return PortSpec(
        role=port.role,
        name=options.name or port.name,
        doc=doc,
        unit=options.unit,
        layout=port.layout,
        initial=initial,
        least=least,
        greatest=greatest,
        choices=names_of(port.choice) if port.choice is not None and isinstance(port, Modulation) else [],
        validity_ns=_validity(port, what),
        attributes=options.attributes(),
        former_name=options.was,
        child=child,
    )


def _validity(port: Port[Any], what: str) -> int:
    """Return how long a command is in force, or a value of an export valid, in ns."""
    options = port.options
    if not options.lasting:
        return _duration(options.validity, f"{what}: validity", may_be_zero=not isinstance(port, Command))
    if options.validity:
        raise TypeError(f"{what} is lasting, and a lasting value has no validity: state one of the two")
    return LASTING


def _child_spec(role: Role, doc: str) -> ChildSpec:
    return ChildSpec(role.name, doc, not role.perceptive, role.group, role.optional, role.many)


def _functions(cls: type[Schema], kind: str) -> list[str]:
    """Return the functions that a class has, after a check of their parameters."""
    has = {name for name in FUNCTIONS if getattr(cls, name) is not getattr(Schema, name)}
    if "iterate" not in has:
        raise TypeError(f"{cls.__name__} has no iterate: write def iterate(self, cx), one step of the schema")
    if "check" in has and kind != "motor":
        raise TypeError(f"{cls.__name__} is a {kind} schema, and only motor schemas have a precondition: remove check")
    if ("save" in has) != ("restore" in has):
        raise TypeError(f"{cls.__name__} has one of save and restore: a memory needs both")
    if "touched" in has and "draw" not in has:
        raise TypeError(f"{cls.__name__} has touched and no draw: a panel is drawn, or is none")
    if hasattr(cls, "judge"):
        raise TypeError(
            f"{cls.__name__} has judge: a guard judges commands in the process of the host, in microseconds, "
            "so it is written in Rust, C or C++"
        )
    for name in has:
        function = getattr(cls, name)
        if any(is_kind(function) for is_kind in RETURN_AT_ONCE):
            raise TypeError(
                f"{cls.__name__}.{name} is asynchronous or a generator, which would do nothing when it is called: "
                f"write def {name} without async, await and yield"
            )
        try:
            signatures.signature(function).bind(*[None] * (FUNCTIONS[name] + 1))
        except TypeError:
            expected = str(signatures.signature(getattr(Schema, name)))
            raise TypeError(f"{cls.__name__}.{name} takes other parameters: write def {name}{expected}") from None
    return sorted(has)
