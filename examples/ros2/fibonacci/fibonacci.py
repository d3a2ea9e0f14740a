"""Both ends of the action Fibonacci of ROS 2: a schema that computes it, and one that lets another node do so."""

from collections.abc import Sequence
from typing import Annotated

from jde import Actuator, Export, Import, Modulation, Schema, i8, i32, modulation, seq, trigger, value
from jde import optional as unbound

ACTION = "example_interfaces/action/Fibonacci"
SUCCEEDED, CANCELED, ABORTED = 4, 5, 6


@value(f"{ACTION}_Goal")
class Goal:
    order: i32


@value(f"{ACTION}_Feedback")
class Feedback:
    sequence: Annotated[Sequence[i32], seq(i32, 64)]


@value(f"{ACTION}_Result")
class Result:
    sequence: Annotated[Sequence[i32], seq(i32, 64)]


@value(f"{ACTION}_GetResult_Response")
class End:
    status: i8
    result: Result


class Compute(Schema, kind="motor", period="200ms"):
    """Computes the sequence of a goal, one number in each iteration."""

    goal: Import[Goal] = trigger()
    """The goal of another node, as long as it is wanted."""
    feedback: Export[Feedback]
    end: Export[End]

    def awake(self, cx):
        self.begun, self.sequence = None, []

    def check(self, cx):
        return cx.sample(Compute.goal) is not None

    def iterate(self, cx):
        goal = cx.sample(Compute.goal)
        if self.begun != goal.sequence:
            self.begun, self.sequence = goal.sequence, [0, 1]
        if len(self.sequence) <= self.goal.order and len(self.sequence) < 47:
            self.sequence.append(self.sequence[-1] + self.sequence[-2])
            self.feedback.write(Feedback(self.sequence), time=goal.time)
        else:
            status = SUCCEEDED if self.goal.order < 47 else ABORTED
            # With the time of the goal, so that it cannot end the next one.
            self.end.write(End(status, Result(self.sequence)), time=goal.time)


class Ask(Schema, kind="motor", period="100ms"):
    """Lets another node compute the sequence: its goal is a command, in force while this schema wins."""

    order: Modulation[int] = modulation(0, min=0)
    """How far; 0 for nothing."""
    end: Import[End] = unbound()
    """How it has ended."""
    goal: Actuator[Goal]

    def awake(self, cx):
        self.asked, self.since = None, 0.0

    def check(self, cx):
        if self.order != self.asked:
            self.asked, self.since = self.order, cx.now
        end = cx.sample(Ask.end)
        # A goal that was canceled because another schema won is sent again.
        has_ended = end is not None and end.time >= self.since and self.end.status != CANCELED
        return self.order > 0 and not has_ended

    def iterate(self, cx):
        self.goal.command(Goal(self.order))
