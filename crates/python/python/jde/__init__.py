"""Robot behaviours as schemas that run side by side, of which one acts at a time."""

from jde._jde import __version__

__all__ = ["__version__"]
