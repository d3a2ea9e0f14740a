"""Children: how a father wakes them, observes them and decides among them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import TYPE_CHECKING, Any, ClassVar, overload

from jde._ports import Outcome

if TYPE_CHECKING:
    from typing_extensions import Self

    from jde._schema import Schema

#: The host's answer to what makes no sense.
BAD_ARGUMENT = 4


class State(IntEnum):
    """The state of a schema."""

    SLEPT = 0
    CHECKING = 1
    READY = 2
    WINNER = 3


@dataclass(frozen=True)
class Policy:
    """How a group settles a collision (R4): `Policy.PRIORITY`, `Policy.sticky(0.5, 0.1)`, ..."""

    PRIORITY: ClassVar[Policy]
    """The first READY member in the father's order wins."""
    URGENCY: ClassVar[Policy]
    """The READY member with the highest urgency wins."""
    FATHER: ClassVar[Policy]
    """The father's function `arbitrate` chooses."""

    name: str
    time: float = 0.0
    """The dwell, or the turn, s."""
    hysteresis: float = 0.0

    def __post_init__(self) -> None:
        """Refuse what is no policy."""
        if self.name not in _POLICIES:
            raise ValueError(f"there is no policy {self.name!r}, but {', '.join(_POLICIES)}")
        if not (0.0 <= self.time < 9e9 and 0.0 <= self.hysteresis < math.inf):
            raise ValueError(
                f"a policy has a time and a hysteresis of 0 or more, not {self.time} and {self.hysteresis}"
            )
        if self.name == "round-robin" and round(self.time * 1e9) == 0:
            raise ValueError(f"a turn is longer than 0 s, and not {self.time} s")

    @classmethod
    def sticky(cls, dwell: float, hysteresis: float = 0.0) -> Policy:
        """The winner stays for `dwell` seconds, and until a rival is more urgent by more than `hysteresis`."""
        return cls("sticky", dwell, hysteresis)

    @classmethod
    def round_robin(cls, turn: float) -> Policy:
        """Each READY member in turn, in the father's order, for `turn` seconds."""
        return cls("round-robin", turn)


#: The names of the policies, in the order of their numbers.
_POLICIES = ("priority", "urgency", "sticky", "round-robin", "father")
Policy.PRIORITY, Policy.URGENCY, Policy.FATHER = Policy("priority"), Policy("urgency"), Policy("father")


class Role:
    """A role for a child, or for any number of children. The application binds instances to it."""

    many = False

    def __init__(self, group: str = "", *, perceptive: bool = False, optional: bool = False) -> None:
        self.group, self.perceptive, self.optional = group, perceptive, optional
        self.number, self.name = -1, ""

    def numbered(self, number: int, name: str) -> Self:
        """Return the role of a schema."""
        role = type(self)(self.group, perceptive=self.perceptive, optional=self.optional)
        role.number, role.name = number, name
        return role

    def __set__(self, schema: Schema, value: Any) -> None:
        raise AttributeError(f"`{self.name}` is a child of the schema and cannot be replaced")


class Child(Role):
    """A role for a child."""

    @overload
    def __get__(self, schema: None, owner: type[Schema]) -> Self: ...
    @overload
    def __get__(self, schema: Schema, owner: type[Schema]) -> BoundChild: ...
    def __get__(self, schema: Schema | None, owner: type[Schema]) -> Self | BoundChild:
        return self if schema is None else BoundChild(self, schema)


class Children(Role):
    """A role for any number of children, the last one of the schema. The application names them."""

    many = True

    @overload
    def __get__(self, schema: None, owner: type[Schema]) -> Self: ...
    @overload
    def __get__(self, schema: Schema, owner: type[Schema]) -> BoundChildren: ...
    def __get__(self, schema: Schema | None, owner: type[Schema]) -> Self | BoundChildren:
        return self if schema is None else BoundChildren(self, schema)


class BoundChild:
    """A child during a call of its father."""

    __slots__ = ("_raw", "name", "number")

    def __init__(self, role: Role, schema: Schema, more: int = 0) -> None:
        self._raw = schema._cx._raw
        self.name, self.number = role.name, role.number + more

    def __eq__(self, other: object) -> bool:
        return isinstance(other, BoundChild) and other.number == self.number

    def __hash__(self) -> int:
        return hash(self.number)

    def wake(self) -> Outcome:
        """Wake the child. It may be awake already."""
        return Outcome(self._raw.wake(self.number))

    def sleep(self) -> Outcome:
        """Put the child and everything below it to sleep."""
        return Outcome(self._raw.sleep(self.number))

    @property
    def state(self) -> State:
        """The state of the child; SLEPT if nobody has the role."""
        found = self._raw.child(self.number)
        return State.SLEPT if found is None else State(found[0])

    @property
    def is_faulted(self) -> bool:
        """Whether the child is Faulted."""
        found = self._raw.child(self.number)
        return found is not None and found[1]

    def set_policy(self, policy: Policy) -> Outcome:
        """Change the policy of the group in which the child competes."""
        if not isinstance(policy, Policy):
            raise TypeError(f"`{self.name}` takes a Policy, such as Policy.URGENCY, not {policy!r}")
        code, time_ns = _POLICIES.index(policy.name), round(policy.time * 1e9)
        status = self._raw.set_policy(self.number, code, time_ns, policy.hysteresis)
        if status == BAD_ARGUMENT:
            raise ValueError(f"`{self.name}` competes in no group, so there is no policy to set")
        return Outcome(status)


class BoundChildren:
    """The children of a role during a call of their father."""

    __slots__ = ("_role", "_schema")

    def __init__(self, role: Role, schema: Schema) -> None:
        self._role, self._schema = role, schema

    def __iter__(self) -> Any:
        number = 0
        while self._schema._cx._raw.child(self._role.number + number) is not None:
            yield BoundChild(self._role, self._schema, number)
            number += 1

    def wake(self) -> None:
        """Wake all of them."""
        for child in self:
            child.wake()

    def sleep(self) -> None:
        """Put all of them to sleep."""
        for child in self:
            child.sleep()


def child(group: str = "", *, perceptive: bool = False, optional: bool = False) -> Any:
    """A role for a motor child, which competes in a group, or for a perceptive one."""
    return Child(group, perceptive=perceptive, optional=optional)


def children(group: str = "all") -> Any:
    """A role for any number of motor children, which the application names."""
    return Children(group)


@dataclass(frozen=True)
class Candidate:
    """A child that competes."""

    number: int
    state: State
    ready: bool
    """Whether its precondition held at its last check."""
    urgency: float


@dataclass(frozen=True)
class Verdict:
    """The father's choice, and the reason for it in words."""

    child: BoundChild | None
    reason: str


@dataclass(frozen=True)
class Level:
    """One arbitration."""

    group: str
    is_collision: bool
    """Whether two or more children are ready; otherwise none is."""
    candidates: Sequence[Candidate]
    """The awake children of the group, in the father's order."""
    winner: int | None
    """The number of the present winner."""

    def candidate(self, child: BoundChild) -> Candidate | None:
        """Return the candidate of a child; None if it does not compete."""
        return next((candidate for candidate in self.candidates if candidate.number == child.number), None)

    def is_ready(self, child: BoundChild) -> bool:
        """Whether a child is ready."""
        candidate = self.candidate(child)
        return candidate is not None and candidate.ready

    def is_winner(self, child: BoundChild) -> bool:
        """Whether a child is the present winner."""
        return self.winner == child.number

    def choose(self, child: BoundChild, reason: str) -> Verdict:
        """Choose a child."""
        return Verdict(child, reason)

    def nobody(self, reason: str) -> Verdict:
        """Choose no child."""
        return Verdict(None, reason)
