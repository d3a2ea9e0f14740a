"""Mistakes in the declaration of a schema are errors in words, at the line of its class."""

from __future__ import annotations

from typing import Any

import pytest

from jde import Actuator, Child, Command, Export, Import, Modulates, Modulation, Schema, modulates, modulation
from jde import types as t


class Whole(Schema):
    """What a schema needs at least."""

    def iterate(self, cx: Any) -> None:
        """Do nothing."""


def declare(body: dict[str, Any], **options: Any) -> None:
    """Declare a schema with these attributes, of which `annotations` are its annotations."""
    annotations = body.pop("annotations", {})
    type("Wrong", (Whole,), {"__module__": __name__, "__annotations__": annotations, **body}, **options)


MOTOR = {"kind": "motor", "period": "100ms"}


def test_a_class_without_iterate_is_refused() -> None:
    with pytest.raises(TypeError, match="Empty has no iterate: write def iterate"):

        class Empty(Schema, kind="motor", period="100ms"):
            pass


@pytest.mark.parametrize(
    ("body", "options", "message"),
    [
        ({}, {"kind": "actor", "period": 1}, "of the kind 'actor'"),
        ({}, {"kind": "motor"}, "states no period"),
        ({}, {"kind": "motor", "period": "fast"}, "'fast' is no time"),
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
        ({"annotations": {"laser": Import[str]}}, MOTOR, r"str is no part of a value: use a number.*text\(32\)"),
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
