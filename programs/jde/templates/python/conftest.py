"""Lets pytest run the drives of the folder `tests`, too."""

pytest_plugins = ["jde.testing"]
