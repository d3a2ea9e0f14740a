"""Declarations of schemas: mistakes are errors in words, at the line of the class, and `jde describe` shows the rest."""

from __future__ import annotations

import json
import re
from textwrap import dedent
from typing import Any

import pytest

from conftest import Robot
from jde import (
    Actuator,
    Child,
    Command,
    Export,
    Import,
    Modulates,
    Modulation,
    Schema,
    child,
    children,
    command,
    modulates,
    modulation,
    optional,
    trigger,
    unit,
)
from jde import types as t


class Whole(Schema):
    """What a schema needs at least."""

    def iterate(self, cx: Any) -> None:
        """Do nothing."""


async def asynchronous(self: Any, cx: Any) -> bool:
    """Return a coroutine."""
    return True


def generator(self: Any, cx: Any) -> Any:
    """Return a generator."""
    yield True


async def both(self: Any, cx: Any) -> Any:
    """Return an asynchronous generator."""
    yield True


def declare(body: dict[str, Any], **options: Any) -> None:
    """Declare a schema with these attributes, of which `annotations` are its annotations."""
    annotations = body.pop("annotations", {})
    type("Wrong", (Whole,), {"__module__": __name__, "__annotations__": annotations, **body}, **options)


MOTOR = {"kind": "motor", "period": "100ms"}


def test_a_class_without_iterate_is_refused() -> None:
    with pytest.raises(TypeError, match="Empty has no iterate: write def iterate"):

        class Empty(Schema, kind="motor", period="100ms"):
            pass


def test_a_type_in_the_place_of_a_value_is_refused() -> None:
    with pytest.raises(
        TypeError, match=re.escape("Assigned.base is a type, not a port of that type: write base: Actuator[Twist]")
    ):

        class Assigned(Schema, kind="motor", period="100ms"):
            base = Actuator[t.Twist]

            def iterate(self, cx: Any) -> None:
                pass


@pytest.mark.parametrize(
    ("body", "options", "message"),
    [
        ({}, {"kind": "actor", "period": 1}, "of the kind 'actor'"),
        ({}, {"kind": "motor"}, "states no period"),
        ({}, {"kind": "motor", "period": "fast"}, "Wrong: period: 'fast' is not a time"),
        ({}, {"kind": "motor", "period": "1.2.3s"}, "Wrong: period: '1.2.3s' is not a time"),
        ({}, {"kind": "motor", "period": None}, "states no period"),
        ({}, {"kind": "motor", "period": []}, r"Wrong: period: \[\] is not a time"),
        ({}, {"kind": "motor", "period": -1}, "Wrong: period: -1 is not a time of a schema: write one above 0"),
        ({}, {"kind": "motor", "period": 0}, "Wrong: period: 0 is not a time of a schema"),
        ({}, {"kind": "motor", "period": float("nan")}, "Wrong: period: nan is not a time"),
        ({}, {"kind": "motor", "period": 1, "budget": float("inf")}, "Wrong: budget: inf is not a time of a schema"),
        ({}, {"kind": "motor", "period": 1, "priod": 2}, "Wrong states priod, and a schema states kind, period"),
        ({}, {"period": 1}, "Wrong states no kind"),
        ({"check": asynchronous}, MOTOR, "Wrong.check is asynchronous or a generator.*write def check without async"),
        ({"iterate": generator}, MOTOR, "Wrong.iterate is asynchronous or a generator"),
        ({"awake": both}, MOTOR, "Wrong.awake is asynchronous or a generator"),
        ({"x": trigger()}, MOTOR, r"Wrong.x is a port .* without its type: write x: Import\[LaserScan\] = trigger"),
        ({"m": modulation(0.5)}, MOTOR, r"Wrong.m .*: write m: Modulation\[float\] = modulation\(0.5\)"),
        ({"annotations": {"m": float}, "m": modulation(0.5)}, MOTOR, r"write m: Modulation\[float\]"),
        ({"c": command(t.Twist(), validity=1)}, MOTOR, r"Wrong.c .*: write c: Command\[Twist\] = command"),
        ({"s": modulates("near", "speed")}, MOTOR, r"Wrong.s .*: write s: Modulates\[float\]"),
        ({"o": optional()}, MOTOR, r"Wrong.o .*: write o: Import\[float\] = optional"),
        ({"e": unit("m")}, MOTOR, r"Wrong.e .*: write e: Export\[float\] = unit"),
        ({"near": child(group="base")}, MOTOR, r"Wrong.near .*: write near: Child = child"),
        ({"rest": children()}, MOTOR, r"Wrong.rest .*: write rest: Children = children"),
        (
            {"annotations": {"m": Modulation[float]}, "m": 0.8},
            MOTOR,
            r"Wrong.m states 0.8: write m: Modulation\[float\] = modulation\(0.8\)",
        ),
        ({"annotations": {"m": Modulation[float]}, "m": unit("m")}, MOTOR, r"Wrong.m states no default: write"),
        ({"annotations": {"laser": Import[float]}, "laser": 3}, MOTOR, r"Wrong.laser states 3, .* Import\[float\]$"),
        ({"annotations": {"m": Modulation[float]}, "m": modulation(0.8, min="a")}, MOTOR, "Wrong.m: min is a number"),  # type: ignore[arg-type]
        (
            {"annotations": {"m": Modulation[float]}, "m": modulation(0.8, max=float("nan"))},
            MOTOR,
            "Wrong.m: max is a number, and not nan",
        ),
        ({"annotations": {"m": Modulation[float]}, "m": modulation(0.8, unit=1)}, MOTOR, "Wrong.m: unit is a text"),  # type: ignore[arg-type]
        (
            {"annotations": {"m": Modulation[float]}, "m": modulation("fast")},
            MOTOR,
            "Wrong.m has a default that is none of its type: .*not a str",
        ),
        (
            {"annotations": {"c": Command[t.Twist]}, "c": command(t.Twist(), validity=-1)},
            MOTOR,
            "Wrong.c: validity: -1 is not a time of a schema",
        ),
        (
            {"check": lambda self, cx: True},
            {"kind": "perceptive", "period": 1},
            "only motor schemas have a precondition",
        ),
        ({"iterate": lambda self: None}, MOTOR, r"iterate takes other parameters: write def iterate\(self, cx"),
        ({"save": lambda self, cx: 1}, MOTOR, "one of save and restore"),
        ({"touched": lambda self, cx, gesture: None}, MOTOR, "touched and no draw"),
        ({"judge": lambda self: None}, MOTOR, "a guard judges commands in the process of the host"),
        ({"annotations": {"laser": Import}}, MOTOR, "states no type of value"),
        ({"annotations": {"laser": Import[str]}}, MOTOR, r"str is not a part of a value: use a number.*text\(32\)"),
        (
            {"annotations": {"speed": Modulation[float]}},
            MOTOR,
            r"states nothing but its type: write .*modulation\(0.8\)",
        ),
        ({"annotations": {"speed": Command[t.Twist]}}, MOTOR, "validity"),
        ({"annotations": {"speed": Export[float]}, "speed": modulation(1.0)}, MOTOR, "declared as Export"),
        ({"annotations": {"near": Child}}, MOTOR, "states no group"),
        ({"annotations": {"speed": Modulates[float]}, "speed": modulates("near", "speed")}, MOTOR, "no such child"),
        ({"annotations": {"base": "Actuator[Nothing]"}}, MOTOR, "names what is not defined: name 'Nothing'"),
    ],
)
def test_a_mistake_is_named(body: dict[str, Any], options: dict[str, Any], message: str) -> None:
    with pytest.raises((TypeError, ValueError), match=message):
        declare(dict(body), **options)


def test_a_mistake_is_at_the_line_of_its_class() -> None:
    with pytest.raises(ValueError, match="Late: period: -1") as raised:

        class Late(Whole, kind="motor", period=-1):
            pass

    lines = [str(entry.statement) for entry in raised.traceback if str(entry.path) == __file__]
    assert lines[-1].strip().startswith("class Late(")


def test_the_tables_are_checked_as_those_of_any_plugin() -> None:
    from jde.bench import Bench

    class Odd(Whole, kind="perceptive", period="100ms"):
        base: Actuator[t.Twist]

    class Far(Whole, kind="motor", period="100ms"):
        speed: Modulation[float] = modulation(2.0, unit="miles", max=1.0)

    with pytest.raises(ValueError, match="schema `Odd`, port `base`: only a motor schema commands actuators"):
        Bench(Odd)
    with pytest.raises(ValueError, match="port `speed`.*miles"):
        Bench(Far)


def test_a_command_that_triggers_is_described(robot: Robot) -> None:
    (robot.folder / "lock.py").write_text(
        """
from jde import Command, Schema, command

class Lock(Schema, kind="driver", period="1s"):
    \"\"\"Locks a door.\"\"\"

    place: Command[float] = command(0.0, validity="500ms", trigger=True)
    force: Command[float] = command(0.0, validity="500ms")

    def iterate(self, cx):
        pass
"""
    )
    described = robot.jde("describe", "lock.py", "--json")
    assert described.status == 0, described.text
    assert [port["trigger"] for port in json.loads(described.text)["schemas"][0]["ports"]] == [True, False]


def test_ports_of_a_class_that_others_extend_are_those_of_each_schema(robot: Robot) -> None:
    (robot.folder / "limits.py").write_text(
        dedent(
            '''
        """Two schemas with the same limits."""

        from jde import Actuator, Modulation, Schema, modulation
        from jde import types as t


        class Limits(Schema):
            speed: Modulation[float] = modulation(0.3, unit="m/s", min=0.0, was="fast")
            """Greatest speed."""


        class Base(Schema):
            base: Actuator[t.Twist]
            """Speeds of the base."""


        class Ahead(Limits, Base, kind="motor", period="100ms"):
            def iterate(self, cx):
                self.base.command(t.Twist(linear=t.Vector3(x=self.speed)))


        class Back(Limits, Base, kind="motor", period="100ms"):
            def iterate(self, cx):
                self.base.command(t.Twist(linear=t.Vector3(x=-self.speed)))
        '''
        )
    )
    described = robot.jde("describe", "limits.py", "--json")
    assert described.status == 0, described.text
    schemas = json.loads(described.text)["schemas"]
    assert [schema["name"] for schema in schemas] == ["Ahead", "Back"]
    for schema in schemas:
        ports = {port["name"]: port for port in schema["ports"]}
        assert sorted(ports) == ["base", "speed"]
        assert (ports["speed"]["doc"], ports["speed"]["former_name"]) == ("Greatest speed.", "fast")
