"""The package can be imported."""

import jde
from conftest import Robot


def test_the_package_has_the_version_of_the_executable(robot: Robot) -> None:
    said = robot.jde("--version").text.split()
    assert jde.__version__ in said, said
