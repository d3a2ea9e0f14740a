"""Clients of a running application."""

import asyncio
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

import jde

#: The longest wait for something that happens at once, s.
PATIENCE = 60.0


@pytest.fixture
def robot(navigation: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[jde.Remote]:
    """Run safe navigation in real time, and return a connection."""
    monkeypatch.setenv("JDE_RUNTIME_DIR", str(tmp_path / "run"))
    command = ["jde", "run", str(navigation), "--plain", "--for", f"{PATIENCE}s", "--set", "example.rounds=0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as application:
        assert application.stdout is not None
        application.stdout.readline()
        yield jde.connect()
        application.terminate()
        application.communicate()


def test_values_are_read_and_watched(robot: jde.Remote) -> None:
    assert robot.name == "safe-navigation"
    assert robot.is_alive
    assert robot.variables["pioneer.truth"] == "jde_msgs/msg/Truth"
    with robot.watch("pioneer.odometry") as watch:
        first, second = watch.receive(PATIENCE), watch.receive(PATIENCE)
    assert second.time > first.time
    assert second.sequence > first.sequence
    assert second.value.pose.pose.position.x == pytest.approx(3.55, abs=1.0)
    assert len(robot["pioneer.laser"].ranges) == 180
    assert robot["goon.ahead"] == 1.2
    with pytest.raises(jde.Error, match="did you mean"):
        _ = robot["pioneer.lasr"]


def test_a_watch_is_an_iterator_for_tasks_too(robot: jde.Remote) -> None:
    async def take() -> list[jde.RemoteSample]:
        taken: list[jde.RemoteSample] = []
        with robot.watch("pioneer.truth", rate=50.0) as watch:
            async for sample in watch:
                taken.append(sample)
                if len(taken) == 3:
                    break
        return taken

    times = [sample.time for sample in asyncio.run(asyncio.wait_for(take(), PATIENCE))]
    assert times == sorted(set(times))
    with robot.watch("pioneer.truth") as watch:
        for sample in watch:
            assert sample.value.collisions == 0
            break
    assert list(watch) == [], "it is closed"


def test_an_operator_acts_for_a_block(robot: jde.Remote) -> None:
    with robot.hold("stop", "example"), robot.setting("goon.ahead", "90 cm"):
        assert robot["goon.ahead"] == 0.9
    with robot.records("states", last=1000) as records:
        assert any(record["schema"] == "example" and record["to"] == "slept" for record in records)
    with robot.records("events", last=1000) as records:
        assert any("stop" in record["text"] for record in records if record["kind"] == "operator")
    robot["goon.ahead"] = 1.0
    assert robot["goon.ahead"] == 1.0
    robot.release("goon")
    robot.stop_all()
    robot.release_all()
    with pytest.raises(jde.Error, match="no schema"):
        robot.play("gon")
    with pytest.raises(jde.Error, match="`kg` does not convert"):
        robot["goon.ahead"] = "3 kg"


def test_panels_are_drawn_and_touched(robot: jde.Remote) -> None:
    with robot.panel("example") as panel:
        drawing = panel.receive(PATIENCE)
    assert drawing["items"]
    with pytest.raises(jde.Error, match="no panel"):
        robot.panel("pioneer")


def test_a_block_is_recorded(robot: jde.Remote, tmp_path: Path) -> None:
    file = tmp_path / "drive.mcap"
    with robot.watch("pioneer.truth") as watch, robot.record(file, "pioneer.truth"):
        while not file.exists():
            assert watch.receive(PATIENCE) is not None
        for _ in range(5):
            watch.receive(PATIENCE)
    assert len(jde.open(file)["pioneer.truth"]) > 0


def test_without_an_application_a_connection_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("JDE_RUNTIME_DIR", str(tmp_path / "run"))
    with pytest.raises(jde.Error, match="no application"):
        jde.connect()
    with pytest.raises(ValueError, match="belong together"):
        jde.connect(at=["tls/robot2.local:7447"], user="lab")
