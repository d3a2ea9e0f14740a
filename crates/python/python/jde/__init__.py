"""Robot behaviours as schemas that run side by side, of which one acts at a time."""

from jde._jde import Error, Value, __version__
from jde.clients import Remote, Sample, Watch, connect
from jde.experiments import Results, experiment
from jde.recordings import Recording, open
from jde.runs import Application, Run, run
from jde.series import Series

__all__ = [
    "Application",
    "Error",
    "Recording",
    "Remote",
    "Results",
    "Run",
    "Sample",
    "Series",
    "Value",
    "Watch",
    "__version__",
    "connect",
    "experiment",
    "open",
    "run",
]
