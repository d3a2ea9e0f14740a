"""The debugger of a schema, at the terminal of its host."""

from __future__ import annotations

import bdb
import os
import pdb  # noqa: T100
import signal
import sys
from types import FrameType
from typing import Any, ClassVar

from jde._context import Context


class Debugger(pdb.Pdb):
    """A debugger at the terminal. The host waits while it reads commands."""

    #: How many are reading commands. A call from the prompt, as of `debug`, may stop within the stop.
    _reading: ClassVar[int] = 0

    def stop_here(self, frame: FrameType) -> bool:
        """Return whether to stop in a frame: not in code that was generated, such as `__init__` of a dataclass."""
        is_generated = frame.f_code.co_filename.startswith("<") and frame.f_code.co_name != "<module>"
        return not is_generated and super().stop_here(frame)

    def interaction(self, *arguments: Any, **more: Any) -> None:
        """Read commands until one lets the schema go on."""
        context = Context._newest
        if context is None:
            raise RuntimeError("breakpoint() stops the functions of a schema, and not the import of its file")
        if Debugger._reading == 0:
            context.hold(True)
        before = signal.signal(signal.SIGINT, _quit)
        Debugger._reading += 1
        try:
            # Standard input is empty, and has been the host's until now.
            terminal = os.open("/dev/tty", os.O_RDONLY)
            os.dup2(terminal, 0)
            os.close(terminal)
            super().interaction(*arguments, **more)
        finally:
            Debugger._reading -= 1
            signal.signal(signal.SIGINT, before)
            if Debugger._reading == 0:
                context.hold(False)


def install() -> None:
    """Let `breakpoint()` stop the schema."""
    # Ctrl-C is for the host. It also ends what waits at the prompt.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # Each stop has a debugger of its own, since one within a stop would change the frames of the outer one.
    # A step goes over the ports of this package, and over the outcomes that they return.
    skip = ["jde.*", "enum"]
    sys.breakpointhook = lambda *_, **__: Debugger(nosigint=True, skip=skip).set_trace(sys._getframe(1))


def _quit(*_: Any) -> None:
    raise bdb.BdbQuit
