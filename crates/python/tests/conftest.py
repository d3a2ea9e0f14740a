"""The programs and plugins that the tests use: those of the folder JDE_TEST_BIN."""

import os
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]


@pytest.fixture(autouse=True)
def _programs(monkeypatch: pytest.MonkeyPatch) -> None:
    folder = os.environ.get("JDE_TEST_BIN", str(ROOT / "target/debug"))
    monkeypatch.setenv("PATH", folder, prepend=os.pathsep)
    monkeypatch.setenv("JDE_PLUGIN_PATH", folder)


@pytest.fixture
def navigation() -> Path:
    """Return the application of safe navigation: four schemas and a simulated Pioneer."""
    return ROOT / "apps/safe-navigation.toml"


@pytest.fixture
def reach() -> Path:
    """Return the application of the page on runs: a bare robot, and a schema that a policy replaces."""
    return ROOT / "examples/python/reach.toml"
