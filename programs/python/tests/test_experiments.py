"""Experiments from Python."""

from pathlib import Path

import pytest

import jde

EXPERIMENT = """
name = "starts"
application = "{application}"
for = "5s"
mission = "ignored"

[axes]
seeds = "1..3"

[must."no collision"]
never = "collisions > 0"

[measure]
driven = "distance"
"""


def test_an_experiment_returns_its_drives(navigation: Path, tmp_path: Path) -> None:
    file = tmp_path / "starts.toml"
    file.write_text(EXPERIMENT.format(application=navigation))
    results = jde.experiment(file, jobs=2, out=tmp_path / "out")
    assert results.passed
    assert len(results.drives) == 3
    pandas = pytest.importorskip("pandas")
    frame = results.frame()
    assert isinstance(frame, pandas.DataFrame)
    assert list(frame["outcome"]) == ["passed"] * 3
    assert (frame["driven"] > 0.0).all()
    assert "<table" in results._repr_html_()


def test_faults_of_an_experiment_are_named(tmp_path: Path) -> None:
    file = tmp_path / "wrong.toml"
    file.write_text("nme = 'wrong'")
    with pytest.raises(jde.Error, match="nme"):
        jde.experiment(file, out=tmp_path / "out")
