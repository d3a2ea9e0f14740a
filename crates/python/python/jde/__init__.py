"""Robot behaviours as schemas that run side by side, of which one acts at a time."""

from jde._jde import Error, Value, __version__
from jde.runs import Application, Run, run
from jde.series import Series

__all__ = ["Application", "Error", "Run", "Series", "Value", "__version__", "run"]
