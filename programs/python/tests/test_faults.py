"""Whatever a schema in Python does, the robot goes on under the rules, and the event says why."""

from __future__ import annotations

import re
import stat
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from conftest import HEAD, Result, Robot

Drive = Callable[..., Result]

NEAR = """
def check(self, cx):
    return (n := self.laser.nearest_ahead(0.4)) is not None and n < 1.5
"""
NEVER = 'restart = "never"'
BACK = """
def iterate(self, cx):
    self.base.command(t.Twist.planar(-0.2, 0.0))
"""


def test_it_drives(body: Drive) -> None:
    done = body(NEAR + BACK)
    assert "roots: ahead -> mine" in done.text
    assert "no faults, no overruns, nothing refused" in done.text
    assert done.status == 0


def test_a_run_repeats_to_the_bit_and_is_decided_again(robot: Robot, body: Drive) -> None:
    first = body(NEAR + BACK)
    assert robot.drive(6, "--record", "drive.mcap").text.splitlines()[:6] == first.text.splitlines()[:6]
    again = robot.jde("replay", "--trust", "--decide", "drive.mcap")
    assert again.text.splitlines()[-1].startswith("same: "), again.text
    (robot.folder / "mine.py").write_text((robot.folder / "mine.py").read_text().replace("-0.2", "-0.1"))
    changed = robot.jde("replay", "--trust", "--decide", "drive.mcap")
    assert "now   linear.x = -0.1" in changed.text and changed.status == 1


def test_a_check_that_fails_while_the_schema_wins_is_decided_again(robot: Robot, body: Drive) -> None:
    body("\ndef check(self, cx):\n    assert cx.now < 1.0, 'planted'\n    return True\n" + BACK, more=NEVER)
    assert "AssertionError: planted" in robot.drive(6, "--record", "drive.mcap").text
    again = robot.jde("replay", "--trust", "--decide", "drive.mcap")
    assert again.text.splitlines()[-1].startswith("same: "), again.text


@pytest.mark.parametrize("call", ["check", "iterate", "awake", "sleep"])
def test_an_error_is_a_fault_with_its_traceback(body: Drive, call: str) -> None:
    functions = {"check": NEAR, "iterate": BACK, "awake": "", "sleep": ""}
    functions[call] = f"\ndef {call}(self, cx):\n    raise KeyError('planted')\n"
    done = body("".join(functions.values()), more=NEVER)
    assert "KeyError: 'planted'" in done.text
    assert done.text.count('mine.py", line') == 1 and f"in {call}" in done.text
    if call != "sleep":
        assert "ahead" in done.text


@pytest.mark.parametrize(
    ("wrong", "reason"),
    [
        ("import sys; sys.exit(3)", "SystemExit: a schema does not end its process, and this one called exit(3)"),
        ("import os; os._exit(3)", "its process exited by itself, with status 3"),
        ("import ctypes; ctypes.string_at(0)", "its process was killed by SIGSEGV"),
        ("import os; os.abort()", "its process was killed by SIGABRT"),
        ("return self.nothing", "AttributeError: 'Mine' object has no attribute 'nothing'"),
        ("self.base = 1", "`base` is a port of the schema and cannot be replaced"),
        ("self.base.command(1)", "actuator `base`: this takes a Twist, not a int"),
        ("def deeper(): deeper()\n    deeper()", "RecursionError"),
    ],
)
def test_every_end_of_an_iteration_is_described(body: Drive, wrong: str, reason: str) -> None:
    done = body(f"{NEAR}\ndef iterate(self, cx):\n    {wrong}\n", more=NEVER)
    assert reason in done.text, done.text
    assert "roots: mine -> ahead" in done.text


ENDLESS = """
def iterate(self, cx):
    while cx.now > 0.5:
        pass
"""


def test_a_call_that_hangs_is_a_fault_that_names_its_line(robot: Robot, body: Drive) -> None:
    body(NEAR + BACK, more=NEVER)
    source = (robot.folder / "mine.py").read_text().replace(BACK.strip(), "").rstrip()
    lines = "".join(f"    {line}\n" for line in ENDLESS.splitlines())
    robot.write(source.replace("< 1.5", "< 9.0") + "\n" + lines, more=NEVER + '\nhang = "300ms"')
    done = robot.jde("run", "app.toml", "--plain", "--for", "6s")
    assert "has not returned from a call for" in done.text, done.text
    assert 'mine.py", line' in done.text and "in iterate" in done.text, done.text
    assert "_serve.py" not in done.text
    assert done.status == 1


def test_a_signal_that_ends_the_process_is_a_fault_that_names_its_line(body: Drive) -> None:
    done = body(f"{NEAR}\ndef iterate(self, cx):\n    import ctypes; ctypes.string_at(0)\n", more=NEVER)
    assert "its process was killed by SIGSEGV" in done.text
    assert 'mine.py", line' in done.text and "in iterate" in done.text, done.text


# Nothing else in a recording contains four of these letters in this order.
RARE = "xzvkjwqx"


def test_a_fault_is_said_once_and_the_log_is_in_the_recording(robot: Robot, body: Drive) -> None:
    wrong = f"{NEAR}\ndef iterate(self, cx):\n    print('about to fail: q{RARE}q')\n    raise KeyError('planted')\n"
    done = body(wrong, more=NEVER)
    assert done.text.count("KeyError: 'planted'") == 1, done.text
    assert "            |   File " in done.text, "the traceback has lines of its own"
    robot.drive(6, "--record", "drive.mcap")
    topics = robot.jde("info", "drive.mcap").text
    assert "/rosout" in topics and "rcl_interfaces/msg/Log" in topics, topics
    # The chunks of the file are compressed by LZ4, which leaves what has not occurred before as it is.
    assert RARE.encode() in (robot.folder / "drive.mcap").read_bytes()
    assert "rosout" not in robot.jde("vars", "--in", "drive.mcap").text


def test_a_contact_is_said_with_what_and_when(robot: Robot, body: Drive) -> None:
    done = body("\ndef iterate(self, cx):\n    self.base.command(t.Twist.planar(0.5, 0.0))\n")
    assert "it touches wall at" in done.text, done.text
    assert re.search(r"1 contact, the first at \d+\.\d s", done.text), done.text


def test_a_run_with_a_fault_has_failed_unless_the_application_expects_it(robot: Robot, body: Drive) -> None:
    wrong = NEAR + "\ndef iterate(self, cx):\n    raise KeyError('planted')\n"
    assert body(wrong).status == 1
    application = robot.folder / "app.toml"
    application.write_text('faults = "ignored"\n' + application.read_text())
    done = robot.drive()
    assert "KeyError: 'planted'" in done.text and done.status == 0, done.text


TEST = """
name = "it drives"
application = "../app.toml"
for = "6s"
"""


def judged(robot: Robot, more: str = "", *options: str) -> Result:
    """Run a test of an application."""
    (robot.folder / "tests").mkdir(exist_ok=True)
    (robot.folder / "tests/drives.toml").write_text(TEST + more)
    return robot.jde("test", *options)


def test_a_test_in_which_a_schema_faults_fails_with_the_error_and_its_line(robot: Robot, body: Drive) -> None:
    body(NEAR + "\ndef iterate(self, cx):\n    raise KeyError('planted')\n")
    done = judged(robot)
    assert "mine faulted at" in done.text and "KeyError: 'planted'" in done.text, done.text
    assert 'mine.py", line' in done.text and "0 passed, 1 failed" in done.text and done.status == 1
    assert judged(robot, 'faults = "ignored"').status == 0
    (robot.folder / "right.py").write_text((robot.folder / "mine.py").read_text().replace("raise KeyError", "str"))
    application = (robot.folder / "app.toml").read_text()
    (robot.folder / "right.toml").write_text(application.replace("mine.py", "right.py"))
    assert judged(robot, "", "--application", "right.toml").status == 0
    (robot.folder / "app.toml").rename(robot.folder / "wrong.toml")
    done = judged(robot, "", "--application", "wrong.toml")
    assert "KeyError: 'planted'" in done.text and " --application wrong.toml --record" in done.text, done.text


def test_a_turn_that_would_overrun_in_real_time_is_shown_in_lockstep(robot: Robot, body: Drive) -> None:
    done = body(NEAR + "\ndef iterate(self, cx):\n    import time; time.sleep(0.15)\n")
    assert "by this machine's clock, and its budget is 100.0 ms: in real time it overruns" in done.text, done.text
    assert done.status == 0
    assert judged(robot).status == 0
    done = judged(robot, 'budgets = "judged"')
    assert "of the turns of mine took longer than its budget" in done.text and done.status == 1, done.text


def test_what_a_schema_prints_is_in_its_log(body: Drive) -> None:
    done = body(NEAR + "\ndef iterate(self, cx):\n    print('near', round(cx.now)); cx.warn('and warned')\n")
    printed = [line for line in done.text.splitlines() if "mine: near" in line]
    assert printed and all(" s  info  mine: near " in line for line in printed), done.text
    # In its order, at the time of the call.
    assert float(printed[0].split()[0]) > 1.0
    assert done.text.index("mine: near") < done.text.index("mine: and warned")


def test_a_check_that_returns_nothing_is_a_fault(body: Drive) -> None:
    done = body("def check(self, cx):\n    pass\n" + BACK, more=NEVER)
    assert "check returns True, False or a Precondition, not a NoneType" in done.text


def test_memory_beyond_the_limit_is_an_error_of_python(body: Drive) -> None:
    wrong = f"{NEAR}\ndef iterate(self, cx):\n    bytearray(4_000_000_000)\n"
    done = body(wrong, more=NEVER + '\nisolate = { memory = "500 MB" }')
    assert "MemoryError" in done.text
    assert "roots: mine -> ahead" in done.text


def test_a_thread_that_is_left_running_ends_with_the_schema(body: Drive) -> None:
    endless = """
def awake(self, cx):
    import threading
    threading.Thread(target=threading.Event().wait).start()
"""
    done = body(endless + NEAR + BACK)
    assert done.status == 0 and "no faults" in done.text


def test_a_port_on_another_thread_is_an_error(body: Drive) -> None:
    wrong = """
def iterate(self, cx):
    import concurrent.futures
    with concurrent.futures.ThreadPoolExecutor() as pool:
        pool.submit(lambda: self.laser).result()
"""
    done = body(NEAR + wrong, more=NEVER)
    assert "only on the thread on which their schema is called" in done.text


@pytest.mark.parametrize(
    ("source", "reason"),
    [
        ("import nothing_like_it\n", "ModuleNotFoundError: No module named 'nothing_like_it'"),
        ("class Mine(\n", "SyntaxError"),
        ("x = 1\n", "it defines no schema: write a class that derives from jde.Schema"),
        (HEAD, "Mine has no iterate"),
        ("import sys; sys.exit('no')\n", "SystemExit"),
        ("import os; os._exit(4)\n", "its process exited by itself, with status 4"),
        ("import os; os.abort()\n", "its process was killed by SIGABRT"),
    ],
)
def test_a_file_that_cannot_be_used_is_named(robot: Robot, source: str, reason: str) -> None:
    robot.write(source)
    done = robot.jde("check", "app.toml")
    assert done.status != 0
    assert reason in done.text and "mine.py" in done.text and "app.toml:" in done.text, done.text


def test_an_error_names_the_line_of_the_file(robot: Robot) -> None:
    robot.write("\n\nraise ValueError('planted')\n")
    done = robot.jde("check", "app.toml")
    assert "ValueError: planted" in done.text and 'mine.py", line 3' in done.text


def test_a_file_in_a_folder_and_a_module_beside_it_are_found(robot: Robot) -> None:
    robot.write(
        "from helper import Mine\n" + HEAD + "    def iterate(self, cx):\n        pass\n", file="parts/mine.py/Mine"
    )
    (robot.folder / "parts/helper.py").write_text("Mine = 1\n")
    assert robot.jde("check", "app.toml").status == 0


def test_python_that_is_not_there_is_named(robot: Robot) -> None:
    robot.write("")
    done = robot.jde("check", "app.toml", JDE_PYTHON="/nowhere/python3")
    assert "/nowhere/python3 cannot be started: No such file" in done.text
    assert "install Python 3.10 or newer, or name its interpreter in JDE_PYTHON" in done.text


def interpreter(folder: Path, before: str) -> str:
    """An interpreter that runs some lines before anything else."""
    path = folder / "python3"
    (folder / "sitecustomize.py").write_text(before)
    path.write_text(f'#!/bin/sh\nPYTHONPATH={folder} exec {sys.executable} "$@"\n')
    path.chmod(path.stat().st_mode | stat.S_IXUSR)
    return str(path)


def test_the_package_of_the_executable_is_found_without_a_path(robot: Robot) -> None:
    robot.write(HEAD + "    def iterate(self, cx): pass\n")
    done = robot.jde("check", "app.toml", PYTHONPATH="")
    assert done.status == 0, done.text


def test_an_older_python_is_named(robot: Robot) -> None:
    robot.write("")
    old = interpreter(robot.folder, "import sys\nsys.version_info = (3, 9, 2)\n")
    done = robot.jde("check", "app.toml", JDE_PYTHON=old)
    assert "is Python 3.9, and jde needs 3.10 or newer; name another interpreter in JDE_PYTHON" in done.text


def test_a_python_without_the_package_is_told_how_to_get_it(robot: Robot) -> None:
    robot.write("")
    bare = interpreter(robot.folder, "import sys\nsys.modules['jde'] = None\n")
    done = robot.jde("check", "app.toml", JDE_PYTHON=bare)
    assert "has no package jde, and there is none in" in done.text
    assert "run `cargo xtask package --only python`" in done.text
