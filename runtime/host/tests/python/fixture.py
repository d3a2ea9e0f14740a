"""The schemas of the tests in Python: each call runs the scenario's behaviour in the test, whose requests go through the ports here.

A line of the socket beside this file is a list of texts: a call; then for each request its name and arguments, and its answer; then
the result of the call.
"""

from __future__ import annotations

import json
import socket
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

from jde import (
    Actuator,
    Child,
    Command,
    Export,
    Import,
    Level,
    Modulates,
    Modulation,
    NoValue,
    Outcome,
    Policy,
    Precondition,
    Schema,
    child,
    command,
    modulates,
    modulation,
    optional,
    seq,
    text,
    u32,
    value,
)
from jde import types as t


class Failure(Exception):
    """What a behaviour reports as an error."""


class Panic(Exception):
    """A panic of a behaviour."""


@value("test_msgs/msg/Mark")
class Mark:
    """A value of a type of the tests' own."""

    places: Annotated[Sequence[t.Pose2D], seq(t.Pose2D, 4)]
    label: Annotated[str, text(12)]


class Link:
    """The connection with the test, which is made at the first call."""

    def __init__(self) -> None:
        self.lines: Any = None

    def write(self, *words: Any) -> None:
        """Write a line."""
        if self.lines is None:
            link = socket.socket(socket.AF_UNIX)
            link.connect(str(Path(__file__).parent / "socket"))
            self.lines = link.makefile("rw", encoding="utf-8")
        self.lines.write(json.dumps([str(word) for word in words]) + "\n")
        self.lines.flush()

    def read(self) -> list[str]:
        """Return the next line."""
        line: list[str] = json.loads(self.lines.readline())
        return line


LINK = Link()


class Scripted(Schema):
    """What every schema of the tests is."""

    scenario: Modulation[u32] = modulation(0, fixed=True)
    """The number of the scenario."""

    def __init__(self) -> None:
        self.calls = 0
        self.commands = [0.0, 0.0]

    def run(
        self, call: str, cx: Any, *, level: Level | None = None, gesture: str = "", pen: Any = None, saved: Any = None
    ) -> Any:
        """Run the behaviour of a call. Return the precondition, the urgency, and the role of the chosen child."""
        before = self.commands
        if call == "Iterate":
            self.commands = self.seen(cx)
        group = level.group if level is not None else ""
        LINK.write(self.scenario, call, cx.name, group, gesture, self.calls, *before, *self.commands)
        self.calls += 1
        self.saving: Any = None
        while True:
            name, *words = LINK.read()
            match name:
                case "Done":
                    ready, urgency, role = words
                    return ready == "true", float(urgency), role
                case "NoValue":
                    raise NoValue(*words)
                case "Failure":
                    raise Failure(*words)
                case "Panic":
                    raise Panic(*words)
            lent = {"Level": level, "Pen": pen, "Saved": saved}
            LINK.write(*self.request(cx, name, words[0], float(words[1]), lent))

    def seen(self, cx: Any) -> list[float]:
        """Return the commands that are in force."""
        return self.commands

    def request(self, cx: Any, name: str, words: str, number: float, lent: dict[str, Any]) -> tuple[Any, Any, Any]:
        """Perform a request. Return its code and its numbers."""
        match name:
            case "Seed":
                return 0, 0.0, cx.seed
            case "Now":
                return 0, 0.0, round(cx.now * 1e9)
            case "RealTime":
                return (0 if cx.is_real_time else Outcome.REFUSED.value), 0.0, 0
            case "Log":
                cx.info(words)
        return 0, 0.0, 0

    def awake(self, cx: Any) -> None:
        self.run("Awake", cx)

    def iterate(self, cx: Any) -> None:
        self.run("Iterate", cx)

    def sleep(self, cx: Any) -> None:
        self.run("Sleep", cx)


def holds(held: bool) -> tuple[int, float, int]:
    """Return the answer to a question."""
    return (0 if held else Outcome.REFUSED.value), 0.0, 0


def outcome(of: Outcome) -> tuple[int, float, int]:
    """Return the answer to a change."""
    return of.value, 0.0, 0


class Motor(Scripted, kind="motor", period="10ms"):
    """A motor schema."""

    input: Import[float] = optional()
    """An input."""
    other: Import[float] = optional()
    """Another input."""
    mark: Import[Mark] = optional()
    """A value of a type of the tests' own."""
    gain: Modulation[float] = modulation(0.0)
    """A modulation for a father or an operator."""
    grip: Modulation[float] = modulation(0.0, fixed=True)
    """A modulation that is read at the awakening."""
    base: Actuator[t.Twist] = optional()
    """A command with a long validity."""
    arm: Actuator[t.Twist] = optional()
    """A command with a short validity."""
    mission: Export[t.Mission]
    """The progress of the mission."""
    a: Child = child(group="base", optional=True)
    """A child."""
    b: Child = child(group="base", optional=True)
    """Another child."""
    c: Child = child(group="base", optional=True)
    """A third child."""
    helper: Child = child(perceptive=True, optional=True)
    """A perceptive child."""
    gain_of_a: Modulates[float] = modulates("a", "gain", optional=True)
    """The modulation of child a."""
    period_of_a: Modulates[float] = modulates("a", "period", optional=True)
    """The period of child a."""

    def check(self, cx: Any) -> Precondition:
        ready, urgency, _ = self.run("Check", cx)
        return Precondition(ready, urgency)

    def arbitrate(self, cx: Any, level: Level) -> Any:
        _, _, role = self.run("Arbitrate", cx, level=level)
        if not role:
            return level.nobody("the scenario chose no child")
        return level.choose(getattr(self, role), f"{cx.name} chose {role}")

    def request(self, cx: Any, name: str, words: str, number: float, lent: dict[str, Any]) -> tuple[Any, Any, Any]:
        kind = type(self)
        match name:
            case "Input" | "Other":
                sample = cx.sample(getattr(kind, name.lower()))
                return holds(False) if sample is None else (0, sample.value, sample.sequence)
            case "Mark":
                found = cx.sample(kind.mark)
                if found is None or found.value.label != words:
                    return holds(False)
                return 0, found.value.places[-1].x, len(found.value.places)
            case "Gain" | "Grip":
                return 0, getattr(self, name.lower()), 0
            case "Command":
                return outcome(self.base.command(t.Twist.planar(number, 0.0)))
            case "Reach":
                return outcome(self.arm.command(t.Twist.planar(number, 0.0)))
            case "Wake":
                return outcome(getattr(self, words).wake())
            case "Sleep":
                return outcome(getattr(self, words).sleep())
            case "State":
                of = getattr(self, words)
                return 0, float(of.is_faulted), of.state.value
            case "SetPolicy":
                return outcome(getattr(self, words).set_policy(Policy.URGENCY))
            case "ModulateA":
                return outcome(self.gain_of_a.set(number))
            case "RetimeA":
                return outcome(self.period_of_a.set(number))
            case "IsReady":
                return holds(lent["Level"].is_ready(getattr(self, words)))
            case "Collides":
                return holds(lent["Level"].is_collision)
            case "Urgency":
                return 0, lent["Level"].candidate(getattr(self, words)).urgency, 0
            case "Text":
                lent["Pen"].text(words)
            case "Value":
                lent["Pen"].value(words, number, "m")
            case "Button":
                lent["Pen"].button(words, words)
            case "Save":
                self.saving = number
            case "Restore":
                return 0, lent["Saved"], 0
            case _:
                return super().request(cx, name, words, number, lent)
        return holds(True)


class AbleMotor(Motor, kind="motor", period="10ms"):
    """A motor schema with a panel and a memory."""

    def draw(self, cx: Any, pen: Any) -> None:
        self.run("Draw", cx, pen=pen)

    def touched(self, cx: Any, gesture: Any) -> None:
        switched = gesture.toggled(gesture.widget)
        end = "" if switched is None else " on" if switched else " off"
        verb = "pressed" if switched is None else "switched"
        self.run("Touch", cx, gesture=f"{gesture.by} {verb} `{gesture.widget}` of {cx.name}{end}")

    def save(self, cx: Any) -> Any:
        self.run("Save", cx)
        return self.saving

    def restore(self, cx: Any, saved: Any, version: int) -> None:
        self.run("Restore", cx, saved=saved)


class Eye(Scripted, kind="perceptive", period="10ms"):
    """A perceptive schema."""

    gain: Modulation[float] = modulation(0.0)
    """A modulation for an operator."""
    input: Import[float] = optional()
    """An input."""
    out: Export[float]
    """The value that the test publishes."""
    mark: Export[Mark]
    """A value of a type of the tests' own."""

    def request(self, cx: Any, name: str, words: str, number: float, lent: dict[str, Any]) -> tuple[Any, Any, Any]:
        match name:
            case "Publish":
                self.out.write(number)
            case "Retract":
                self.out.retract()
            case "PublishMark":
                self.mark.write(Mark(places=[t.Pose2D(number, 0.0, 0.0)], label=words))
            case _:
                return super().request(cx, name, words, number, lent)
        return holds(True)


class Robot(Scripted, kind="driver", period="10ms"):
    """A driver. It records each change of its commands."""

    velocity: Command[t.Twist] = command(t.Twist(), validity="1000s")
    """A command that is in force for long."""
    reach: Command[t.Twist] = command(t.Twist(), validity="50ms")
    """A command that must be repeated."""

    def seen(self, cx: Any) -> list[float]:
        found = [cx.sample(Robot.velocity), cx.sample(Robot.reach)]
        return [sample.value.linear.x if sample.in_force else 0.0 for sample in found]


class FailsToCreate(Scripted, kind="motor", period="10ms"):
    """A schema that cannot be created."""

    def __init__(self) -> None:
        raise Failure("there is no such device")
