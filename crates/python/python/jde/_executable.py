"""The executable `jde`, which inspects plugins, runs isolated schemas and drives experiments."""

import shutil
import sys
from pathlib import Path


def find() -> Path | None:
    """Return the executable: the one on the PATH, or the one beside the interpreter."""
    found = shutil.which("jde") or shutil.which("jde", path=str(Path(sys.executable).parent))
    return Path(found) if found else None
