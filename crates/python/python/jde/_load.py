"""Runs the file of a plugin, and finds its schemas."""

from __future__ import annotations

import linecache
import os
import sys
from pathlib import Path
from types import ModuleType

from jde._schema import Schema


def load(copy: os.PathLike[str], known_as: os.PathLike[str]) -> tuple[str, str, str, list[type[Schema]]]:
    """Run the file that the user knows as `known_as`, whose contents are in `copy`. Return its name, version, doc and schemas.

    The modules beside the file can be imported.
    """
    source = Path(copy).read_bytes()
    file = Path(known_as)
    path = str(file)
    folder = str(file.parent)
    if folder not in sys.path:
        sys.path.insert(0, folder)
    name = file.stem
    if name in sys.stdlib_module_names or name.split(".")[0] == "jde":
        # Other modules import the standard one by this name.
        name = f"schema_{name}"
    module = ModuleType(name)
    module.__file__ = path
    # What it defines can be pickled, and its modules can import it.
    sys.modules[name] = module
    # Tracebacks show the lines that run, whatever the file contains meanwhile.
    lines = source.decode(errors="replace").splitlines(keepends=True)
    linecache.cache[path] = (len(source), None, lines, path)
    exec(compile(source, path, "exec", dont_inherit=True), module.__dict__)  # noqa: S102
    classes = [
        value
        for value in vars(module).values()
        if isinstance(value, type)
        and issubclass(value, Schema)
        and value.__module__ == name
        and "__jde__" in vars(value)
    ]
    if not classes:
        raise TypeError(
            "it defines no schema: write a class that derives from jde.Schema and states its kind, "
            'as in class Shy(Schema, kind="motor", period="100ms")'
        )
    doc = (module.__doc__ or "").strip().partition("\n")[0]
    return file.stem, str(getattr(module, "__version__", "0.0.0")), doc, classes
