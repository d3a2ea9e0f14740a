"""The program that a host starts: it runs one schema, or describes files, until the host ends it."""

from __future__ import annotations

import os
import sys

from jde import _jde


def main(what: str, version: str) -> None:
    """Serve the host at standard input. `version` is the host's own."""
    if version != _jde.__version__:
        sys.exit(
            f"the package {os.path.dirname(__file__)} has the version {_jde.__version__}, and this jde {version}: "
            "remove it from the path of Python; an installation of jde has its own"
        )
    try:
        if what == "schema":
            _jde.serve()
        else:
            _jde.inspect()
    except RuntimeError as error:
        sys.exit(str(error))
    sys.stdout.flush()
    sys.stderr.flush()
    # Threads that the schema has left running must not keep the process.
    os._exit(0)
