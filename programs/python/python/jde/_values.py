"""Values: dataclasses that schemas of all languages share by their names and layouts."""

from __future__ import annotations

import ast
import dataclasses
import inspect
import itertools
import textwrap
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING, Annotated, Any, TypeVar, get_args, get_origin, get_type_hints

from jde import _jde

if TYPE_CHECKING:
    from typing import dataclass_transform
else:

    def dataclass_transform(**_: Any) -> Any:
        """Do nothing: only type checkers use it, and Python 3.10 lacks it."""
        return lambda function: function


C = TypeVar("C", bound=type)

STANDARD = _jde.Layout.standard()


@dataclass(frozen=True)
class Form:
    """The elements of a field, and how many there are."""

    form: str
    element: str | type
    capacity: int


def scalar(name: str) -> Form:
    """A number, by its name in ROS 2: `float32`."""
    return Form("one", name, 1)


def text(capacity: int) -> Form:
    """A text of up to that many bytes of UTF-8: `Annotated[str, text(32)]`."""
    return Form("text", "uint8", capacity)


def array(element: Any, count: int) -> Form:
    """Exactly so many elements: `Annotated[Sequence[float], array(f32, 36)]`."""
    return Form("array", _element(element), count)


def seq(element: Any, capacity: int) -> Form:
    """Up to that many elements: `Annotated[Sequence[float], seq(f32, 360)]`."""
    return Form("sequence", _element(element), capacity)


i8 = Annotated[int, scalar("int8")]
i16 = Annotated[int, scalar("int16")]
i32 = Annotated[int, scalar("int32")]
i64 = Annotated[int, scalar("int64")]
u8 = Annotated[int, scalar("uint8")]
u16 = Annotated[int, scalar("uint16")]
u32 = Annotated[int, scalar("uint32")]
u64 = Annotated[int, scalar("uint64")]
f32 = Annotated[float, scalar("float32")]
f64 = Annotated[float, scalar("float64")]

PLAIN: dict[Any, str] = {bool: "bool", int: "int64", float: "float64"}
ROS_NAMES = {
    "bool": "Bool",
    "int8": "Int8",
    "int16": "Int16",
    "int32": "Int32",
    "int64": "Int64",
    "uint8": "UInt8",
    "uint16": "UInt16",
    "uint32": "UInt32",
    "uint64": "UInt64",
    "float32": "Float32",
    "float64": "Float64",
}


def form_of(hint: Any) -> Form:
    """Return the form of a field with this annotation."""
    if get_origin(hint) is Annotated:
        forms = [part for part in get_args(hint)[1:] if isinstance(part, Form)]
        if forms:
            return forms[0]
        hint = get_args(hint)[0]
    if hint in PLAIN:
        return Form("one", PLAIN[hint], 1)
    if isinstance(hint, type) and "__jde_layout__" in vars(hint):
        return Form("one", hint, 1)
    raise TypeError(
        f"{_shown(hint)} is not a part of a value: use a number (float, f32, u8, ...), bool, a class with @value, "
        "Annotated[str, text(32)] or Annotated[Sequence[float], seq(f32, 360)]"
    )


def layout_of(hint: Any) -> tuple[_jde.Layout, type[Enum] | None]:
    """Return the layout of a port's type, and its class if it is a choice."""
    if isinstance(hint, type) and issubclass(hint, Enum):
        return STANDARD["std_msgs/msg/UInt8"], hint
    form = form_of(hint)
    if isinstance(form.element, type):
        layout: _jde.Layout = form.element.__jde_layout__  # type: ignore[attr-defined]
        if form.form != "one":
            raise TypeError(f"a port has one value: make {_shown(hint)} the field of a class with @value")
        return layout, None
    data = ("data", "The value.", "", form.element, form.form, form.capacity)
    if form.form == "one":
        return STANDARD[f"std_msgs/msg/{ROS_NAMES[form.element]}"], None
    if form.form == "text":
        return _jde.Layout("std_msgs/msg/String", "A text by itself.", [data]), None
    if form.form == "array":
        return _jde.Layout(f"jde_msgs/msg/{ROS_NAMES[form.element]}Array", "A fixed number of numbers.", [data]), None
    raise TypeError(f"a port has one value: make {_shown(hint)} the field of a class with @value")


def field(*, default: Any = dataclasses.MISSING, default_factory: Any = dataclasses.MISSING, unit: str = "") -> Any:
    """Describe a field of a value: its default, and its unit in SI symbols."""
    return dataclasses.field(default=default, default_factory=default_factory, metadata={"unit": unit})


@dataclass_transform(field_specifiers=(field,))
def value(name: str) -> Callable[[C], C]:
    """Make a class a value of the type `name`, in the notation of ROS 2: `my_msgs/msg/Doors`.

    Its fields are laid out as those of a structure in C, so that Rust and C share the type.
    """

    def define(cls: C) -> C:
        hints = get_type_hints(cls, include_extras=True)
        docs = attribute_docs(cls)
        fields = []
        for attribute, hint in hints.items():
            form = _form_of_field(cls, attribute, hint)
            default = getattr(cls, attribute, dataclasses.MISSING)
            unit = default.metadata.get("unit", "") if isinstance(default, dataclasses.Field) else ""
            if default is dataclasses.MISSING or (
                isinstance(default, dataclasses.Field)
                and default.default is dataclasses.MISSING
                and default.default_factory is dataclasses.MISSING
            ):
                setattr(cls, attribute, _zero(form, unit))
            element = form.element.__jde_layout__ if isinstance(form.element, type) else form.element  # type: ignore[attr-defined]
            fields.append((attribute, docs.get(attribute, ""), unit, element, form.form, form.capacity))
        made: C = dataclass(cls)  # type: ignore[assignment]
        _bind(made, _jde.Layout(name, inspect.cleandoc(vars(cls).get("__doc__") or "").partition("\n")[0], fields))
        return made

    return define


@dataclass_transform(field_specifiers=(field,))
def standard(name: str) -> Callable[[C], C]:
    """Make a class the standard type of that name."""

    def define(cls: C) -> C:
        made: C = dataclass(cls)  # type: ignore[assignment]
        _bind(made, STANDARD[name])
        return made

    return define


def make(name: str, doc: str, fields: list[str]) -> type:
    """Return a class for the values of a type that no class has."""
    return dataclasses.make_dataclass(name.rpartition("/")[2], fields, namespace={"__doc__": doc})


def attribute_docs(cls: type) -> dict[str, str]:
    """Return the texts below the attributes of a class; none if its source is unknown."""
    try:
        tree = ast.parse(textwrap.dedent(inspect.getsource(cls)))
    except (OSError, TypeError, SyntaxError):
        return {}
    body = tree.body[0].body if isinstance(tree.body[0], ast.ClassDef) else []
    docs = {}
    for attribute, below in itertools.pairwise(body):
        if (
            isinstance(attribute, ast.AnnAssign)
            and isinstance(attribute.target, ast.Name)
            and isinstance(below, ast.Expr)
            and isinstance(below.value, ast.Constant)
            and isinstance(below.value.value, str)
        ):
            docs[attribute.target.id] = inspect.cleandoc(below.value.value)
    return docs


def _bind(cls: type, layout: _jde.Layout) -> None:
    layout.bind(cls)
    cls.__jde_layout__ = layout  # type: ignore[attr-defined]


def _element(element: Any) -> str | type:
    form = form_of(element)
    if form.form != "one":
        raise TypeError("the elements of a sequence are numbers or values of a class with @value")
    return form.element


def _form_of_field(cls: type, name: str, hint: Any) -> Form:
    try:
        return form_of(hint)
    except TypeError as error:
        raise TypeError(f"field `{name}` of {cls.__name__}: {error}") from None


def _zero(form: Form, unit: str) -> Any:
    """The default of a field without one: zero, empty, or the default of its class."""
    if form.form == "text":
        return field(default="", unit=unit)
    if form.form == "sequence":
        return field(default_factory=list, unit=unit)
    make: Callable[[], Any] = (
        form.element
        if isinstance(form.element, type)
        else {"bool": bool}.get(form.element, float if form.element.startswith("float") else int)
    )
    if form.form == "array":
        return field(default_factory=lambda: [make() for _ in range(form.capacity)], unit=unit)
    return field(default_factory=make, unit=unit)


def _shown(hint: Any) -> str:
    return getattr(hint, "__name__", None) or str(hint)
