"""`breakpoint()` in a schema, at a terminal that `script` of util-linux creates."""

from __future__ import annotations

import json
import os
import select
import shlex
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from conftest import BIN, HEAD, PATIENCE, Result, Robot

PROMPT = "(Pdb) "
# It stops once, after it has commanded.
STOPS = """
    since: Modulation[float] = modulation(0.0)

    def __init__(self):
        self.stopped = False

    def wait(self, cx):
        while cx.now < 4.0:
            pass

    def iterate(self, cx):
        self.base.command(t.Twist.planar(0.1, 0.0))
        if cx.now >= self.since and not self.stopped:
            breakpoint()
            self.stopped = True
"""


class Terminal:
    """A run at a terminal."""

    def __init__(self, robot: Robot, *arguments: str) -> None:
        run = shlex.join([str(BIN / "jde"), "run", "app.toml", "--debug-python", "mine", *arguments])
        # Without `exec`, Ctrl-C would end some shells with a status of their own.
        self._program = subprocess.Popen(
            ["script", "-qec", f"exec {run}", "/dev/null"],
            cwd=robot.folder,
            env={**robot.environment, "NO_COLOR": "1", "TERM": "dumb"},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            bufsize=0,
        )
        self.shown = ""

    def until(self, text: str) -> None:
        """Read until the terminal shows a text that it has not shown yet."""
        seen = len(self.shown)
        while text not in self.shown[seen:]:
            assert self._read(), f"it ends without {text!r}: {self.shown}"

    def type(self, keys: str) -> None:
        """Type keys."""
        assert self._program.stdin is not None
        self._program.stdin.write(keys.encode())

    def end(self) -> Result:
        """Read until the run ends."""
        while self._read():
            pass
        return Result(self._program.wait(PATIENCE), self.shown)

    def close(self) -> None:
        """End the run."""
        self._program.kill()
        self._program.communicate()

    def _read(self) -> bool:
        assert self._program.stdout is not None
        assert select.select([self._program.stdout], [], [], PATIENCE)[0], f"it shows nothing more: {self.shown}"
        read = os.read(self._program.stdout.fileno(), 4096)
        self.shown += read.decode()
        return bool(read)


@pytest.fixture
def start(robot: Robot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[..., Terminal]]:
    """Run the schema that stops."""
    monkeypatch.setenv("JDE_RUNTIME_DIR", str(tmp_path / "run"))
    robot.write(HEAD + STOPS, more='hang = "1s"')
    started = []

    def start(*arguments: str) -> Terminal:
        started.append(Terminal(robot, *arguments))
        return started[-1]

    yield start
    for terminal in started:
        terminal.close()


def test_a_schema_that_stops_brakes_and_is_neither_late_nor_hung(robot: Robot, start: Callable[..., Terminal]) -> None:
    # Its commands would be in force for two periods.
    terminal = start("--for", "6s", "--json", "--set", "mine.period=30s")
    terminal.until(PROMPT)
    velocity = robot.jde("get", "pioneer.velocity", "--json")
    assert velocity.status == 0 and json.loads(velocity.text)["value"]["linear"]["x"] == 0.0, velocity.text
    # Longer than its budget, and than a call that hangs.
    terminal.type("self.wait(cx)\n")
    terminal.until(PROMPT)
    terminal.type("c\n")
    ended = terminal.end()
    assert ended.status == 0, ended.text
    summary = json.loads(next(line for line in ended.text.splitlines() if line.startswith("{")))
    mine = next(schema for schema in summary["schemas"] if schema["schema"] == "mine")
    assert (mine["faults"], mine["overruns"]) == (0, 0) and mine["iterations"] == 1, mine


def test_time_stands_still_in_lockstep(start: Callable[..., Terminal]) -> None:
    terminal = start("--lockstep", "--for", "3s", "--set", "mine.since=1.0")
    for line in ("p 'at', cx.now\n", "n\n", "p 'at', cx.now\n"):
        terminal.until(PROMPT)
        terminal.type(line)
    terminal.until(PROMPT)
    terminal.type("c\n")
    ended = terminal.end()
    assert ended.status == 0 and "no faults" in ended.text, ended.text
    assert ended.text.count("('at', 1.0)") == 2, ended.text


def test_a_step_enters_neither_the_ports_nor_generated_code(robot: Robot, start: Callable[..., Terminal]) -> None:
    value = "\n@dataclass\nclass Pair:\n    one: float\n    other: float\n"
    steps = "    def iterate(self, cx):\n        breakpoint()\n        pair = Pair(0.1, 0.2)\n        self.base.command(t.Twist())\n"
    source = f"from dataclasses import dataclass\n{value}{HEAD}{steps}        last = pair.one\n"
    robot.write(source, more='restart = "never"')
    terminal = start("--lockstep", "--for", "1s")
    for line in ("s\n", "s\n", "s\n", "p 'last', pair\n", "q\n"):
        terminal.until(PROMPT)
        terminal.type(line)
    shown = terminal.end().text
    assert "('last', Pair(one=0.1, other=0.2))" in shown, shown
    assert "<string>" not in shown and "_ports.py" not in shown, shown


def test_a_call_from_the_prompt_stops_within_the_stop(start: Callable[..., Terminal]) -> None:
    terminal = start("--lockstep", "--for", "3s", "--set", "mine.since=1.0")
    terminal.until(PROMPT)
    terminal.type("debug self.iterate(cx)\n")
    terminal.until("((Pdb)) ")
    terminal.type("c\n")
    for line in ("p 'within', cx.now\n", "c\n", "p 'after', cx.now\n", "c\n"):
        terminal.until(PROMPT)
        terminal.type(line)
    ended = terminal.end()
    assert ended.status == 0 and "no faults" in ended.text, ended.text
    assert "('within', 1.0)" in ended.text and "('after', 1.0)" in ended.text, ended.text


def test_a_call_that_is_held_may_be_held_again(robot: Robot, start: Callable[..., Terminal]) -> None:
    hold = (
        "    def iterate(self, cx):\n        for held in (True, True, False, False):\n            cx._raw.hold(held)\n"
    )
    robot.write(HEAD + hold)
    ended = start("--lockstep", "--for", "1s").end()
    assert ended.status == 0 and "no faults" in ended.text, ended.text


def test_r1_a_held_call_delays_no_takeover(robot: Robot, start: Callable[..., Terminal]) -> None:
    file = robot.folder / "app.toml"
    file.write_text(file.read_text().replace('["mine", "ahead"]', '["ahead", "mine"]'))
    terminal = start("--for", "100s", "--set", "ahead.from=4.9")
    terminal.until(PROMPT)
    ready = robot.jde("set", "ahead.from=1 m")
    assert ready.status == 0, ready.text
    terminal.until("mine -> ahead")
    terminal.type("p self.base.command(t.Twist.planar(0.3, 0.0))\n")
    terminal.until("REFUSED")
    terminal.type("\x03")
    ended = terminal.end()
    assert ended.status == 0, ended.text


def test_ctrl_c_at_the_prompt_ends_the_application(start: Callable[..., Terminal]) -> None:
    terminal = start("--for", "100s")
    terminal.until(PROMPT)
    terminal.type("\x03")
    ended = terminal.end()
    assert ended.status == 0 and "BdbQuit" in ended.text, (ended.status, ended.text)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("min", "did you mean `mine`?"),
        ("ahead", "schema `ahead` is not in Python"),
        ("mine", "--debug-python needs a terminal"),
    ],
)
def test_what_cannot_be_debugged_is_refused_in_words(robot: Robot, name: str, words: str) -> None:
    robot.write(HEAD + STOPS)
    refused = robot.jde("run", "app.toml", "--debug-python", name)
    assert refused.status == 2 and words in refused.text, refused.text


def test_r11_a_call_is_held_only_for_a_debugger(body: Callable[..., Result]) -> None:
    drive = body("def iterate(self, cx):\n    cx._raw.hold(True)", more='restart = "never"')
    assert "its process sent an invalid request: Hold" in drive.text, drive.text
    assert "roots: nobody -> ahead" in drive.text, drive.text


def test_a_breakpoint_without_a_terminal_says_what_to_do(body: Callable[..., Result]) -> None:
    drive = body("def iterate(self, cx):\n    breakpoint()")
    assert "breakpoint() needs the terminal: run the application with --debug-python" in drive.text, drive.text
