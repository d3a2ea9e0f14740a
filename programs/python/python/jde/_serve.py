"""The program that a host starts: it runs one schema, or describes files, until the host ends it."""

from __future__ import annotations

import os
import sys
from typing import Any

from jde import _jde


def main(what: str, version: str) -> None:
    """Serve the host at standard input. `version` is the host's own."""
    if version != _jde.__version__:
        sys.exit(
            f"the package {os.path.dirname(__file__)} has the version {_jde.__version__}, and this jde {version}: "
            "remove it from the path of Python; an installation of jde has its own"
        )
    try:
        if what == "debugged schema":
            from jde import _debug

            _debug.install()
        elif "PYTHONBREAKPOINT" not in os.environ:
            sys.breakpointhook = _refuse
        if what == "inspections":
            _jde.inspect()
        else:
            _jde.serve()
    except RuntimeError as error:
        sys.exit(str(error))
    sys.stdout.flush()
    sys.stderr.flush()
    # Threads that the schema has left running must not keep the process.
    os._exit(0)


def _refuse(*_: Any, **__: Any) -> None:
    raise RuntimeError(
        "breakpoint() needs the terminal: run the application with --debug-python and this schema's name"
    )
