"""The extension module: `crates/python/src`."""

__version__: str
