"""The executable `jde`, which inspects plugins, runs isolated schemas and drives experiments."""

import shutil
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

from jde._jde import Error


def find() -> Path | None:
    """Return the executable: the one on the PATH, or the one beside the interpreter."""
    found = shutil.which("jde") or shutil.which("jde", path=str(Path(sys.executable).parent))
    return Path(found) if found else None


def command(*arguments: str) -> list[str]:
    """Return the command that calls it."""
    executable = find()
    if executable is None:
        raise Error("the executable `jde` is neither on the PATH nor beside the interpreter")
    return [str(executable), *arguments]


def call(*arguments: str, environment: Mapping[str, str] | None = None) -> str:
    """Call it, and return what it prints."""
    done = subprocess.run(command(*arguments), env=environment, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise Error(done.stderr.strip())
    return done.stdout
