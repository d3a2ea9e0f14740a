"""The package can be imported."""

import pytest

import jde
from conftest import Robot


def test_the_package_has_the_version_of_the_executable(robot: Robot) -> None:
    said = robot.jde("--version").text.split()
    assert jde.__version__ in said, said


def test_another_interpreter_of_the_process_is_refused_with_words() -> None:
    interpreters = pytest.importorskip("_xxsubinterpreters")
    other = interpreters.create()
    with pytest.raises(interpreters.RunFailedError, match="subinterpreters"):
        interpreters.run_string(other, "import jde")
    interpreters.destroy(other)
