"""Robot behaviours as schemas that run side by side, of which one acts at a time."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from jde import _interpreter as _interpreter
from jde import types
from jde._children import Child, Children, Level, Policy, State, Verdict, child, children
from jde._context import Context, Sample
from jde._errors import NoValue
from jde._hysteresis import Hysteresis
from jde._jde import Error, __version__
from jde._ports import (
    Actuator,
    Command,
    Export,
    Import,
    Modulates,
    Modulation,
    Outcome,
    command,
    export,
    modulates,
    modulation,
    optional,
    trigger,
    unit,
)
from jde._schema import Precondition, Problems, Schema
from jde._values import array, f32, f64, field, i8, i16, i32, i64, seq, text, u8, u16, u32, u64, value

if TYPE_CHECKING:
    from jde.clients import Remote, RemoteSample, Watch, connect
    from jde.experiments import Results, experiment
    from jde.recordings import Recording, open
    from jde.runs import Application, Run, run
    from jde.series import Series

#: Imported when they are first used: the process of a schema needs none of them.
_ON_USE = {
    "Application": "jde.runs",
    "Recording": "jde.recordings",
    "Remote": "jde.clients",
    "RemoteSample": "jde.clients",
    "Results": "jde.experiments",
    "Run": "jde.runs",
    "Series": "jde.series",
    "Watch": "jde.clients",
    "connect": "jde.clients",
    "experiment": "jde.experiments",
    "open": "jde.recordings",
    "run": "jde.runs",
}


def __getattr__(name: str) -> Any:
    """Import a part of the package that is used for the first time."""
    if name not in _ON_USE:
        raise AttributeError(f"module 'jde' has no attribute {name!r}")
    return getattr(import_module(_ON_USE[name]), name)


__all__ = [
    "Actuator",
    "Application",
    "Child",
    "Children",
    "Command",
    "Context",
    "Error",
    "Export",
    "Hysteresis",
    "Import",
    "Level",
    "Modulates",
    "Modulation",
    "NoValue",
    "Outcome",
    "Policy",
    "Precondition",
    "Problems",
    "Recording",
    "Remote",
    "RemoteSample",
    "Results",
    "Run",
    "Sample",
    "Schema",
    "Series",
    "State",
    "Verdict",
    "Watch",
    "__version__",
    "array",
    "child",
    "children",
    "command",
    "connect",
    "experiment",
    "export",
    "f32",
    "f64",
    "field",
    "i8",
    "i16",
    "i32",
    "i64",
    "modulates",
    "modulation",
    "open",
    "optional",
    "run",
    "seq",
    "text",
    "trigger",
    "types",
    "u8",
    "u16",
    "u32",
    "u64",
    "unit",
    "value",
]
