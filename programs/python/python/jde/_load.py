"""Runs the file of a plugin, and finds its schemas."""

from __future__ import annotations

import linecache
import os
import re
import sys
from importlib import metadata
from importlib.machinery import PathFinder
from pathlib import Path
from types import ModuleType

from jde._schema import Schema

#: The group of entry points that name the modules of plugins.
GROUP = "jde.schemas"


def entry_points() -> list[tuple[str, str]]:
    """Return the names of the plugins that distributions state, and the files of their modules. Import none of them."""
    found: dict[str, str] = {}
    names: set[str] = set()
    for distribution in metadata.distributions():
        try:
            # An earlier one of the same normalized name shadows it. A broken one has no name.
            name = re.sub("[-_.]+", "-", distribution.name or "").lower()
            if name and name in names:
                continue
            names.add(name)
            for point in distribution.entry_points:
                file = _file_of(point.module) if point.group == GROUP else None
                if file is not None:
                    # The first of a name is the one that Python imports.
                    found.setdefault(point.name, str(file.resolve()))
        except (AttributeError, OSError, TypeError, ValueError) as error:
            print(f"the entry points of {distribution.name} cannot be read: {error!r}", file=sys.stderr)
    return list(found.items())


def _file_of(module: str) -> Path | None:
    top, *rest = module.split(".")
    spec = PathFinder.find_spec(top)
    if spec is None or not rest:
        return None if spec is None or spec.origin is None else Path(spec.origin)
    below = [Path(folder, *rest) for folder in spec.submodule_search_locations or []]
    files = [file for path in below for file in (path.with_suffix(".py"), path / "__init__.py")]
    return next(filter(Path.is_file, files), None)


def _package_of(file: Path) -> tuple[list[str], Path]:
    """Return the names of the packages that a file is in, and the folder that holds the outermost one."""
    names: list[str] = []
    folder = file.parent
    while (folder / "__init__.py").is_file():
        names.insert(0, folder.name)
        folder = folder.parent
    return names, folder


def load(copy: os.PathLike[str], known_as: os.PathLike[str]) -> tuple[str, str, str, list[type[Schema]]]:
    """Run the file that the user knows as `known_as`, whose contents are in `copy`. Return its name, version, doc and schemas.

    The modules beside the file can be imported; in a package also relatively.
    """
    source = Path(copy).read_bytes()
    file = Path(known_as)
    path = str(file)
    package, folder = _package_of(file)
    if str(folder) not in sys.path:
        sys.path.insert(0, str(folder))
    known = file.stem
    if package and str(file.parent) not in sys.path:
        sys.path.append(str(file.parent))
    if package or any(folder.glob("*.dist-info")):
        known = next((name for name, installed in entry_points() if installed == path), known)
    name = ".".join([*package, file.stem]).removesuffix(".__init__")
    if name in sys.stdlib_module_names or name.split(".")[0] == "jde":
        # Other modules import the standard one by this name.
        name = f"schema_{name}"
    module = ModuleType(name)
    module.__file__ = path
    module.__package__ = ".".join(package)
    if file.stem == "__init__":
        module.__path__ = [str(file.parent)]
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
    return known, str(getattr(module, "__version__", "0.0.0")), doc, classes
