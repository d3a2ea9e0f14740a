"""Refuses the interpreters of a process beside its main one: the extension module has one state for the process."""

from __future__ import annotations

from importlib import import_module


def refuse_others() -> None:
    """Raise an `ImportError` in another interpreter than the main one."""
    # The first from Python 3.13 on.
    for name in ("_interpreters", "_xxsubinterpreters"):
        try:
            interpreters = import_module(name)
        except ModuleNotFoundError:
            continue
        if interpreters.get_current() != interpreters.get_main():
            raise ImportError(
                "jde runs in the main interpreter of a process alone, and not in subinterpreters: "
                "start another process, for example with multiprocessing"
            )
        return


refuse_others()
