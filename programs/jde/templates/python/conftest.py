"""Lets pytest run the drives of the folder `tests`, too."""

from jde.testing import pytest_collect_file  # noqa: F401
