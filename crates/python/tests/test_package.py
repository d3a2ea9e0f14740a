"""The package can be imported."""

import re

import jde


def test_the_package_has_the_version_of_the_workspace() -> None:
    assert re.fullmatch(r"\d+\.\d+\.\d+", jde.__version__)
