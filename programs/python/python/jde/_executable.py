"""The executable `jde`, which inspects plugins, runs isolated schemas and drives experiments."""

import shutil
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

from jde._jde import Error


def find() -> Path | None:
    """Return the executable: the one beside the interpreter, of the same installation, or the one on the PATH."""
    found = shutil.which("jde", path=str(Path(sys.executable).parent)) or shutil.which("jde")
    return Path(found) if found else None


def command(*arguments: str) -> list[str]:
    """Return the command that calls it."""
    executable = find()
    if executable is None:
        raise Error("the executable `jde` is neither beside the interpreter nor on the PATH")
    return [str(executable), *arguments]


def call(*arguments: str, environment: Mapping[str, str] | None = None) -> str:
    """Call it, and return what it prints."""
    done = subprocess.run(command(*arguments), env=environment, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise Error(done.stderr.strip())
    return done.stdout
