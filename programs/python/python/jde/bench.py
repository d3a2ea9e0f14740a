"""A bench for tests of a schema: it hosts one schema, without plugins, threads or a clock of its own.

It selects nothing: the test decides whether a motor schema is WINNER and what its children do.
"""

from __future__ import annotations

import json
import warnings
from typing import Any, Generic, TypeVar

from jde import _jde
from jde._children import Policy, State
from jde._ports import Port
from jde._schema import Precondition, Schema

S = TypeVar("S", bound=Schema)


class Bench(Generic[S]):
    """A schema under test. At first it is asleep, at time 0, with authority over its actuators and children.

    Ports and children have their names in the schema. A failure of the schema raises `RuntimeError` with its reason.
    """

    def __init__(self, schema: type[S]) -> None:
        self._class = schema
        self._bench = _jde.Bench(schema)

    def awake(self) -> None:
        """Call `awake`."""
        self._bench.awake()

    def check(self) -> Precondition:
        """Call `check`. A schema without one is always ready."""
        return Precondition(*self._bench.check())

    def iterate(self) -> None:
        """Call `iterate`, after it has cleared what `commanded` returns."""
        self._bench.iterate()

    def sleep(self) -> None:
        """Call `sleep`."""
        self._bench.sleep()

    def arbitrate(self, group: str) -> tuple[str | None, str]:
        """Call `arbitrate` for a group. Return the chosen child and the reason."""
        return self._bench.arbitrate(group)

    def draw(self) -> list[dict[str, Any]]:
        """Draw the panel. Return its widgets as a recording has them."""
        items: list[dict[str, Any]] = json.loads(self._bench.draw())["items"]
        return items

    def touch(self, widget: str, touch: Any) -> None:
        """Perform a gesture on a widget, in the form of a recording: `"pressed"`, `{"moved": 0.5}`."""
        self._bench.touch(widget, json.dumps(touch))

    def save(self) -> tuple[int, bytes]:
        """Save the memory, as before a reload."""
        return self._bench.save()

    def restore(self, saved: tuple[int, bytes]) -> None:
        """Restore what another instance saved, as after a reload."""
        self._bench.restore(*saved)

    def inspect(self) -> list[tuple[str, str]]:
        """Call `inspect`. Return the modulation and the text of each problem."""
        return self._bench.inspect()

    def give(self, name: str, value: Any) -> None:
        """Give an import, a modulation or a command a value, measured now.

        What is no measurement is no value, as in an application. The log says why, and so does a warning of Python.
        """
        logged = len(self._bench.log())
        port = self._port(name, "import", "modulation", "command")
        encoded = port.layout.encode(port.to(value))
        try:
            self._bench.put(port.number, encoded)
        except ValueError as error:
            raise ValueError(f"`{name}` {error}") from None
        for _, text in self._bench.log()[logged:]:
            warnings.warn(text, stacklevel=2)

    def retract(self, name: str) -> None:
        """Retract the newest value of an import, as its writer would."""
        self._bench.remove(self._port(name, "import").number)

    def unbind(self, name: str) -> None:
        """Leave an optional import or actuator unbound, as an application may."""
        self._bench.unbind(self._port(name, "import", "actuator").name)

    def commanded(self, name: str) -> Any:
        """Return the last command since the last `iterate` began; None if there was none, or it was refused."""
        return self._written(self._port(name, "actuator"))

    def exported(self, name: str) -> Any:
        """Return the newest value of an export; None if there is none, or it was retracted."""
        return self._written(self._port(name, "export"))

    def exported_at(self, name: str) -> float | None:
        """Return when the newest value of an export was measured, s."""
        found = self._bench.written(self._port(name, "export").number)
        return None if found is None else found[1] / 1e9

    def modulated(self, name: str) -> Any:
        """Return the newest value that the schema wrote to a modulation of a child."""
        return self._written(self._port(name, "modulates"))

    def set_now(self, now: float) -> None:
        """Set the clock, s since the application's start."""
        self._bench.set_now(round(now * 1e9))

    def set_real_time(self, real_time: bool) -> None:
        """Set whether the application runs in real time, as it does on a new bench, or in lockstep."""
        self._bench.set_real_time(real_time)

    def set_authority(self, authority: bool) -> None:
        """Give the schema authority over actuators and children, or withdraw it."""
        self._bench.set_authority(authority)

    def set_child(self, role: str, state: State) -> None:
        """Set the state of a child. Its precondition then holds if the state is READY or WINNER."""
        self._bench.set_child(self._child(role), int(state))

    def set_faulted(self, role: str, faulted: bool = True) -> None:
        """Set whether a child is Faulted."""
        self._bench.set_faulted(self._child(role), faulted)

    def name_children(self, **groups: str) -> None:
        """Name the children of a role that any number of children may have, each with its group."""
        self._bench.name_children(list(groups.items()))

    @property
    def awake_children(self) -> list[str]:
        """The children that are awake, in the order of their roles."""
        return self._bench.awake_children()

    def policy(self, child: str) -> Policy | None:
        """Return the policy that the schema set through a child; None if it set none."""
        found = self._bench.policy(self._child(child))
        return None if found is None else Policy(found[0], found[1] / 1e9, found[2])

    @property
    def log(self) -> list[tuple[str, str]]:
        """The messages since the creation of the bench: the level and the text."""
        return self._bench.log()

    def _port(self, name: str, *roles: str) -> Port[Any]:
        port = getattr(self._class, name, None)
        if not isinstance(port, Port) or port.role not in roles:
            raise ValueError(f"{self._class.__name__} has no {' or '.join(roles)} `{name}`")
        return port

    def _child(self, role: str) -> str:
        children = [child.name for child in self._class.__jde__.children]
        many = any(child.many for child in self._class.__jde__.children)
        if role not in children and not many:
            raise ValueError(f"{self._class.__name__} has no child `{role}`")
        return role

    def _written(self, port: Port[Any]) -> Any:
        found = self._bench.written(port.number)
        return None if found is None else port.of(port.layout.decode(found[0]))
