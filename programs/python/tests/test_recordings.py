"""Recordings as arrays."""

import subprocess
from pathlib import Path

import numpy as np
import pytest

import jde
from conftest import Robot

RETRACTING = """
from jde import Actuator, Export, Import, Schema, export, trigger
from jde import types as t

class Mine(Schema, kind="motor", period="100ms"):
    laser: Import[t.LaserScan] = trigger()
    base: Actuator[t.Twist]
    number: Export[float] = export(lasting=True)

    def iterate(self, cx):
        if 2.0 < cx.now < 4.0:
            self.number.retract()
        else:
            self.number.write(cx.now)
"""


@pytest.fixture
def recording(navigation: Path, tmp_path: Path) -> jde.Recording:
    """Return the recording of the first 20 seconds of safe navigation."""
    file = tmp_path / "drive.mcap"
    command = ["jde", "run", str(navigation), "--lockstep", "--plain", "--for", "20s", "--record", str(file)]
    # Its status says that the mission was not done in this time.
    assert subprocess.run(command, check=False, capture_output=True, timeout=120).returncode == 1
    return jde.open(file)


def test_a_recording_has_the_values_of_its_run(navigation: Path, recording: jde.Recording) -> None:
    assert recording.metadata["application"] == "safe-navigation"
    assert recording.damage is None
    assert recording.variables["pioneer.laser"] == "sensor_msgs/msg/LaserScan"
    with jde.run(navigation, limit=20.0) as run:
        run.trace("pioneer.truth", "pioneer.laser")
        run.until(21.0)
    for name, path in [("pioneer.truth", "pose.x"), ("pioneer.laser", "ranges")]:
        recorded, computed = recording[name], run.series(name)
        assert np.array_equal(recorded.times, computed.times)
        assert np.array_equal(recorded[path], computed[path])
    choices = [[decision["choice"] for decision in of.decisions] for of in (recording, run)]
    assert choices[0] == choices[1]
    assert recording.states == run.states
    assert recording.events


def test_a_recording_is_a_picture(recording: jde.Recording) -> None:
    path = recording._repr_png_()
    numbers = recording.picture("pioneer.truth.pose.x", "goon.ahead", width=400, height=300)
    for picture in (path, numbers):
        assert picture.startswith(b"\x89PNG")
    assert path != numbers
    with pytest.raises(KeyError, match="no `pioner.truth`; did you mean `pioneer.truth`"):
        recording.picture("pioner.truth")
    with pytest.raises(ValueError, match="pixels on each side"):
        recording.picture(width=1)


def test_a_recording_answers_questions(recording: jde.Recording) -> None:
    assert "vff" in recording.why("vff")
    with pytest.raises(jde.Error, match="vfff"):
        recording.why("vfff")


def test_a_file_that_is_no_recording_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "drive.mcap"
    with pytest.raises(jde.Error, match="No such file"):
        jde.open(file)
    file.write_text("no recording")
    with pytest.raises(jde.Error, match="no MCAP file and no bag"):
        jde.open(file)


def test_values_take_the_memory_of_what_is_in_them(navigation: Path, recording: jde.Recording) -> None:
    laser = recording["pioneer.laser"]
    assert laser.data.dtype["ranges"].shape == (180,), "the scan has so many beams, and room for more"
    assert laser.data.dtype.itemsize < 2000


def test_a_value_at_a_time_is_what_a_schema_reads(recording: jde.Recording) -> None:
    movers = recording.value("pioneer.movers", at=5.0)
    assert 0 < len(movers.things) < 64, "a list has as many as there are"
    truth = recording["pioneer.truth"]
    then = int(np.searchsorted(truth.times, 5.0, side="right")) - 1
    assert recording.value("pioneer.truth", at=5.0).pose.x == truth["pose.x"][then]
    assert recording.value("pioneer.truth.pose.x") == truth["pose.x"][-1]
    with pytest.raises(KeyError, match="did you mean `pioneer.truth`"):
        recording.value("pioneer.thruth", at=5.0)


def test_a_value_that_was_retracted_is_none_until_the_next_one(robot: Robot) -> None:
    robot.write(RETRACTING)
    done = robot.drive(6, "--record", "drive.mcap")
    assert done.status == 0, done.text
    recording = jde.open(robot.folder / "drive.mcap")
    assert 1.0 < recording.value("mine.number", at=1.5) <= 1.5
    assert recording.value("mine.number", at=3.0) is None
    assert recording.value("mine.number", at=5.0) > 4.0
