"""Errors of schemas, and their texts in events."""

from __future__ import annotations

import sys
import traceback
from pathlib import Path

PACKAGE = str(Path(__file__).parent)


class NoValue(RuntimeError):
    """An import has no value: nothing has been published yet, it was retracted, or the import is unbound.

    A precondition that reads such an import is false. An iteration that reads one ends there, without a fault: the
    exports of the schema that are not lasting end, and a motor schema is not READY (R19).
    """


def describe(error: BaseException) -> str:
    """Return an error with its traceback, as it is shown in events: the error first, the frames of this package left out."""
    if isinstance(error, SystemExit):
        # Its own text is the bare status.
        words = f"SystemExit: a schema does not end its process, and this one called exit({error.code!r})"
    else:
        words = "".join(traceback.format_exception_only(error)).strip()
    if isinstance(error, ModuleNotFoundError):
        words += f"; the interpreter is {sys.executable}, and JDE_PYTHON names another"
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if not frame.filename.startswith(PACKAGE)]
    return "\n".join([words, *(line.rstrip() for line in traceback.format_list(frames))])
