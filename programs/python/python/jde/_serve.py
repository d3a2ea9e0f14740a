"""The program that a host starts: it runs one schema, or describes files, until the host ends it."""

from __future__ import annotations

import faulthandler
import io
import os
import signal
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
    _trace()
    # The host reads what schemas print line by line.
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(line_buffering=True)
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


def _trace() -> None:
    """Write the lines that run to the file of the host when a signal ends this process."""
    file = os.environ.pop("JDE_TRACEBACK", None)
    if file is None:
        return
    try:
        descriptor = os.open(file, os.O_WRONLY | os.O_CLOEXEC)
    except OSError:
        # The host does not let others look at its descriptors.
        return
    faulthandler.enable(descriptor, all_threads=False)
    # The host sends it when a call hangs. The process ends after it has written.
    faulthandler.register(signal.SIGUSR2, descriptor, all_threads=False, chain=True)


def _refuse(*_: Any, **__: Any) -> None:
    raise RuntimeError(
        "breakpoint() needs the terminal: run the application with --debug-python and this schema's name"
    )
