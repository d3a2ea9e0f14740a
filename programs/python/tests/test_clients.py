"""Clients of a running application."""

import asyncio
import contextlib
import math
import os
import select
import signal
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, cast

import pytest

import jde
from jde.clients import Watch

#: The longest wait for something that happens at once, s.
PATIENCE = 60.0


@pytest.fixture
def robot(navigation: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[jde.Remote]:
    """Run safe navigation in real time, and return a connection."""
    monkeypatch.setenv("JDE_RUNTIME_DIR", str(tmp_path / "run"))
    command = ["jde", "run", str(navigation), "--plain", "--for", f"{PATIENCE}s", "--set", "example.rounds=0"]
    with running(command):
        yield jde.connect()


@contextlib.contextmanager
def running(command: list[str]) -> Iterator[None]:
    """Run an application in real time."""
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as application:
        assert application.stdout is not None
        application.stdout.readline()
        try:
            yield
        finally:
            application.terminate()
            application.communicate()


def test_variables_are_attributes(robot: jde.Remote) -> None:
    with robot.watch("pioneer.truth") as watch:
        assert watch.receive(PATIENCE) is not None
    truth = robot.pioneer.truth
    assert type(truth.value) is jde.types.Truth
    assert truth.time > 0.0
    robot.goon.ahead = "90 cm"
    assert robot.goon.ahead.value == robot["goon.ahead"] == 0.9
    assert {"pioneer", "goon", "play"} <= set(dir(robot))
    assert {"ahead", "period"} <= set(dir(robot.goon))
    assert not hasattr(robot, "gone")
    with pytest.raises(AttributeError, match="no schema with variables is called `pionier`; there are .*pioneer"):
        _ = robot.pionier
    with pytest.raises(AttributeError, match="schema `goon` has no variable `ahed`, but .*ahead"):
        robot.goon.ahed = 1.0


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


def test_a_task_receives_what_has_arrived_by_the_end() -> None:
    class Over:
        """A subscription of an application that is gone."""

        is_over = True

        def __init__(self) -> None:
            self.waiting = [1, 2, 3]

        def receive(self, timeout: float | None) -> Any:
            return self.waiting.pop(0) if self.waiting else None

    async def take() -> list[int]:
        return [arrival async for arrival in Watch(cast(Any, Over()))]

    assert asyncio.run(asyncio.wait_for(take(), PATIENCE)) == [1, 2, 3]


@pytest.mark.parametrize("rate", [0.0, -1.0, math.nan, math.inf])
def test_a_rate_is_above_zero(robot: jde.Remote, rate: float) -> None:
    for watch in (robot.watch, robot.panel):
        with pytest.raises(ValueError, match="is no rate: give a number above 0"):
            watch("pioneer.truth", rate=rate)


def test_a_wait_is_a_time(robot: jde.Remote) -> None:
    with robot.watch("pioneer.truth") as watch:
        with pytest.raises(ValueError, match="nan s is not a time to wait"):
            watch.receive(math.nan)
        assert watch.receive(PATIENCE) is not None


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
    # A watch that is older than the recording may hold values that the recording missed.
    with robot.record(file, "pioneer.truth"), robot.watch("pioneer.truth") as watch:
        for _ in range(5):
            assert watch.receive(PATIENCE) is not None
    assert len(jde.open(file)["pioneer.truth"]) > 0
    begun = False
    with pytest.raises(jde.Error, match="nothing"), robot.record(tmp_path / "no.mcap", "nothing"):
        begun = True
    assert not begun, "what cannot be recorded is said before the block"


class Anywhere:
    """An application that is nowhere."""

    address = "nowhere"

    def variables(self) -> dict[str, str]:
        return {"stop.fast": "std_msgs/msg/Float64", "goon.fast": "std_msgs/msg/Float64"}


def test_a_schema_named_as_a_method_is_no_attribute() -> None:
    robot = jde.Remote(cast(Any, Anywhere()))
    assert callable(robot.stop) and dir(robot).count("stop") == 1
    assert dir(robot.goon) == ["fast"]


@pytest.mark.parametrize("name", ["goon", "stop", "name", "new"])
def test_only_the_variables_of_a_schema_are_written(name: str) -> None:
    robot = jde.Remote(cast(Any, Anywhere()))
    with pytest.raises(AttributeError, match=f"`{name}` is not a variable: write one of a schema"):
        setattr(robot, name, 1.0)


RECORDER = """
import os, signal, sys
signal.signal(signal.SIGTERM, signal.default_int_handler)
try:
    {begins}
    signal.pause()
except KeyboardInterrupt:
    os.open("ended", os.O_WRONLY | os.O_CREAT)
    sys.exit({status})
"""


@pytest.fixture
def recorder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., jde.Remote]:
    """Take a program for `jde record`."""
    monkeypatch.chdir(tmp_path)

    def take(begins: str, status: str = "0") -> jde.Remote:
        source = RECORDER.format(begins=begins, status=status)
        monkeypatch.setattr("jde._executable.command", lambda *_: [sys.executable, "-c", source])
        return jde.Remote(cast(Any, Anywhere()))

    return take


def test_an_interrupted_recording_ends(
    recorder: Callable[..., jde.Remote], tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    # A shell without job control has the programs that it starts with & ignore the signal.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    request.addfinalizer(lambda: signal.signal(signal.SIGINT, before))
    robot = recorder("os.kill(os.getppid(), signal.SIGINT)")
    with pytest.raises(KeyboardInterrupt), robot.record("drive.mcap"):
        pass
    assert (tmp_path / "ended").exists()


def test_a_recorder_that_says_much_neither_waits_nor_is_forgotten(
    recorder: Callable[..., jde.Remote], tmp_path: Path
) -> None:
    os.mkfifo(tmp_path / "said")
    said = os.open(tmp_path / "said", os.O_RDONLY | os.O_NONBLOCK)
    much = "print('recording drive.mcap', '\\nmissed' * 100_000, flush=True); os.write(os.open('said', os.O_WRONLY), b'all')"
    robot = recorder(much, "'the disk is full'")
    with pytest.raises(jde.Error, match=r"^recording drive.mcap(?s:.*)\nthe disk is full$"), robot.record("drive.mcap"):
        assert select.select([said], [], [], PATIENCE)[0], "it waits for a reader"
    os.close(said)


def afar(folder: Path, reach: Path, name: str, protocol: str, link: str) -> tuple[str, list[str]]:
    """Write an application with the schema `idle`. Return its endpoint, and the command that runs it."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        endpoint = f"{protocol}/127.0.0.1:{free.getsockname()[1]}"
    head = "from jde import Actuator, Schema\nfrom jde import types as t\n"
    idle = "class Idle(Schema, kind='motor', period='100ms'):\n    base: Actuator[t.Twist]\n"
    (folder / "idle.py").write_text(head + idle + "    def iterate(self, cx): pass\n")
    (folder / "afar.toml").write_text(
        f'name = "{name}"\nroots = ["idle"]\n[link]\nlisten = ["{endpoint}"]\n{link}\n'
        '[schemas.robot]\ntype = "sim/robot"\n'
        f'model = "{reach.parent / "cart.toml"}"\nworld = "{reach.parent / "empty.toml"}"\n'
        '[schemas.idle]\ntype = "idle.py"\nactuators = { base = "robot.velocity" }\n'
    )
    return endpoint, ["jde", "run", str(folder / "afar.toml"), "--plain", "--for", f"{PATIENCE}s"]


def test_an_application_afar_is_asked_and_recorded_rather_than_its_namesake(
    robot: jde.Remote, reach: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    here = str(tmp_path / "run")
    endpoint, command = afar(tmp_path, reach, robot.name, "tcp", "insecure = true")
    monkeypatch.setenv("JDE_RUNTIME_DIR", str(tmp_path / "afar"))
    with running(command):
        monkeypatch.setenv("JDE_RUNTIME_DIR", here)
        monkeypatch.setenv("JDE_AT", "tcp/127.0.0.1:1")
        away = jde.connect(robot.name, at=[endpoint])
        assert "example" in robot.why("example")
        assert "idle" in away.why("idle")
        with pytest.raises(jde.Error, match="vff"):
            away.why("vff")
        file = tmp_path / "afar.mcap"
        with away.watch("robot.truth") as watch, away.record(file, "robot.truth"):
            for _ in range(5):
                assert watch.receive(PATIENCE) is not None
    assert len(jde.open(file)["robot.truth"]) > 0


@pytest.fixture
def keys(tmp_path: Path) -> dict[str, Path]:
    """Make the files of docs/link.md: an authority, and the certificate and the key of this machine."""
    files = {name: tmp_path / name for name in ("ca.key", 'the "ca".pem', "me.key", "me.csr", "me.pem")}
    ca_key, ca, key, request, certificate = map(str, files.values())
    new = ["req", "-newkey", "ed25519", "-nodes"]
    for arguments in (
        [*new, "-x509", "-subj", "/CN=our robots", "-keyout", ca_key, "-out", ca],
        [*new, "-subj", "/CN=here", "-addext", "subjectAltName=IP:127.0.0.1", "-keyout", key, "-out", request],
        ["x509", "-req", "-in", request, "-CA", ca, "-CAkey", ca_key, "-copy_extensions", "copy", "-out", certificate],
    ):
        subprocess.run(["openssl", *arguments], check=True, capture_output=True)
    return {"authority": Path(ca), "certificate": Path(certificate), "key": Path(key)}


@pytest.mark.parametrize("proof", ["password", "certificate"])
def test_a_client_proves_who_it_is_within_tls(
    proof: str, keys: dict[str, Path], reach: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    password = tmp_path / "lab.password"
    password.write_text("secret\n")
    tls = ", ".join(f"{name} = '{file}'" for name, file in keys.items())
    if proof == "password":
        link = f"user = 'lab'\npassword-file = '{password}'\ntls = {{ {tls}, clients = false }}"
        known: dict[str, Any] = {"user": "lab", "password_file": password.name, "authority": keys["authority"].name}
    else:
        link = f"tls = {{ {tls} }}"
        known = {name: file.name for name, file in keys.items()}
    monkeypatch.setenv("JDE_RUNTIME_DIR", str(tmp_path / "run"))
    endpoint, command = afar(tmp_path, reach, "afar", "tls", link)
    with running(command):
        monkeypatch.setenv("JDE_RUNTIME_DIR", str(tmp_path / "elsewhere"))
        monkeypatch.chdir(tmp_path)
        robot = jde.connect(at=[endpoint], **known)
        monkeypatch.chdir(tmp_path.parent)
        assert "robot.truth" in robot.variables
        assert "idle" in robot.why("idle")
        with pytest.raises(jde.Error):
            jde.connect(at=[endpoint], authority=keys["authority"])


def test_without_an_application_a_connection_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("JDE_RUNTIME_DIR", str(tmp_path / "run"))
    with pytest.raises(jde.Error, match="no application"):
        jde.connect()
    with pytest.raises(ValueError, match="belong together"):
        jde.connect(at=["tls/robot2.local:7447"], user="lab")
