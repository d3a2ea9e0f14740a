"""Applications in lockstep, stepped from Python."""

import _thread
import importlib
import math
import signal
import threading
from pathlib import Path

import numpy as np
import pytest

import jde


def test_a_run_is_the_run_of_its_seed(navigation: Path) -> None:
    def ranges(seed: int) -> list[float]:
        with jde.run(navigation, seed=seed) as run:
            assert run.until(5.0)
            assert run.time == 5.0
            return run["pioneer.laser"].ranges.tolist()  # type: ignore[no-any-return]

    assert ranges(7) == ranges(7)
    assert ranges(7) != ranges(8)


def test_values_are_read_whole_and_in_parts(navigation: Path) -> None:
    with jde.run(navigation) as run:
        assert run["pioneer.position"] is None, "the robot has no such sensor"
        run.until(1.0)
        laser = run["pioneer.laser"]
        assert type(laser) is jde.types.LaserScan, "as a schema reads it"
        assert np.asarray(laser.ranges).dtype == np.float32
        assert len(laser.ranges) == 180
        assert max(point.range for point in laser.points()) == max(
            range for range in laser.ranges if math.isfinite(range)
        )
        assert run["pioneer.laser.ranges[3]"] == laser.ranges[3]
        assert list(run["pioneer.laser.ranges"]) == list(laser.ranges)
        assert laser.header.frame_id == run["pioneer.laser.header.frame_id"] != ""
        assert run["goon.ahead"] == 1.2, "a plain number is a number"
        assert type(run["pioneer.odometry.pose.pose"]) is jde.types.Pose
        assert run["pioneer.odometry.pose.pose"] == run["pioneer.odometry"].pose.pose
        assert run["pioneer.laser"] == laser, "both are copies"
        with pytest.raises(TypeError, match="read-only"):
            laser.ranges[0] = 1.0  # type: ignore[index]
        with pytest.raises(KeyError, match=r"pioneer.lasr.*did you mean"):
            _ = run["pioneer.lasr"]
        with pytest.raises(jde.Error, match="no field `rnges`"):
            _ = run["pioneer.laser.rnges"]
    assert run["goon.ahead"] == 1.2, "also after the end"
    assert not run.step()


DOORS = """
from collections.abc import Sequence
from typing import Annotated
from jde import Export, Schema, seq, types as t, value

@value("my_msgs/msg/Doors")
class Doors:
    \"\"\"Where the doors are.\"\"\"

    places: Annotated[Sequence[t.Pose2D], seq(t.Pose2D, 8)]
    marks: Annotated[Sequence[int], seq(int, 65)]

class Finds(Schema, kind="motor", period="1s"):
    doors: Export[Doors]
    def iterate(self, cx): pass
"""


def test_the_only_field_of_a_type_is_a_part_too(tmp_path: Path) -> None:
    one = DOORS.replace("places:", "data:").replace("    marks: Annotated[Sequence[int], seq(int, 65)]\n", "")
    (tmp_path / "finds.py").write_text(one)
    file = tmp_path / "doors.toml"
    file.write_text('name = "doors"\nroots = ["finds"]\n[schemas.finds]\ntype = "finds.py"\n')
    with jde.run(file, mocks=["finds"]) as run:
        run["finds.doors"] = {"data": [{"x": 1.0}, {"x": 2.0}]}
        run.until(2.0)
        both = [jde.types.Pose2D(x=1.0), jde.types.Pose2D(x=2.0)]
        assert run["finds.doors"] == run["finds.doors.data"] == both
        assert (run["finds.doors.data[1]"], run["finds.doors.data[1].x"]) == (both[1], 2.0)
        with pytest.raises(jde.Error, match=r"an index follows a field, as in `data\[1\]`"):
            _ = run["finds.doors[1]"]


@pytest.mark.parametrize("field", ["lambda", "lambda_"])
def test_a_field_named_by_a_keyword_ends_with_one_more_underscore(tmp_path: Path, field: str) -> None:
    (tmp_path / "finds.py").write_text(DOORS.replace("places:", f"{field}_:"))
    file = tmp_path / "doors.toml"
    file.write_text('name = "doors"\nroots = ["finds"]\n[schemas.finds]\ntype = "finds.py"\n')
    with jde.run(file, mocks=["finds"]) as run:
        run["finds.doors"] = {field: [{"x": 1.0}]}
        run.until(2.0)
        doors = run["finds.doors"]
        places = getattr(doors, f"{field}_")
        assert places == run[f"finds.doors.{field}"] == [jde.types.Pose2D(x=1.0)]
        places[0].x = 7.0
        run["finds.doors"] = doors
        run.until(4.0)
        assert run[f"finds.doors.{field}[0].x"] == 7.0, "what was read can be written"


def test_a_type_of_a_schema_has_a_class_in_a_run_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "finds.py").write_text(DOORS)
    file = tmp_path / "doors.toml"
    file.write_text('name = "doors"\nroots = ["finds"]\n[schemas.finds]\ntype = "finds.py"\n')
    with jde.run(file, mocks=["finds"]) as run:
        run["finds.doors"] = {"places": [{"x": 1.0}, {"x": 2.0, "theta": 0.5}], "marks": [3, 4]}
        run.until(2.0)
        doors = run["finds.doors"]
        assert (type(doors).__name__, type(doors).__doc__) == ("Doors", "Where the doors are.")
        assert doors.places == [jde.types.Pose2D(x=1.0), jde.types.Pose2D(x=2.0, theta=0.5)]
        assert (run["finds.doors.places[1]"], list(doors.marks)) == (doors.places[1], [3, 4])
        doors.places[0].x = 7.0
        run["finds.doors"] = doors
        run.until(4.0)
        assert run["finds.doors.places[0].x"] == 7.0, "what was read can be written"
        monkeypatch.syspath_prepend(str(tmp_path))
        finds = importlib.import_module("finds")
        assert type(run["finds.doors"]) is finds.Doors, "the class of this program, once it has one"


def test_an_operator_of_the_run_writes_and_acts(navigation: Path) -> None:
    with jde.run(navigation, set={"goon.ahead": "90 cm"}) as run:
        assert run["goon.ahead"] == 0.9
        run["goon.ahead"] = 1.1
        assert run["goon.ahead"] == 1.1
        run["goon.ahead"] = "70 cm"
        assert run["goon.ahead"] == 0.7
        run["goon.period"] = "200 ms"
        assert run["goon.period"] == pytest.approx(0.2)
        with pytest.raises(jde.Error):
            run["goon.ahead"] = -3.0
        with pytest.raises(KeyError, match="no modulation `ahed`"):
            run["goon.ahed"] = 1.0
        with pytest.raises(TypeError, match="is not a value"):
            run["goon.ahead"] = object()
        run.until(2.0)
        run["teleop.want"] = {"twist": {"linear": {"x": 0.2}}, "wanted": True}
        assert run.until(lambda run: run.winner("roots") == "teleop", within=1.0)
        run.release("teleop")
        assert run.until("example.won", within=2.0)
        run.stop("goon")
        run.until(run.time + 1.0)
        assert {schema["name"]: schema["state"] for schema in run.snapshot()["schemas"]}["goon"] == "slept"
        assert any(event["by"] == "python" for event in run.events if event["kind"] == "operator")


def test_a_panel_is_drawn_and_touched(navigation: Path) -> None:
    click = {"clicked": {"at": [3.6, 4.0, 0.0], "button": "primary"}}
    with jde.run(navigation) as run:
        run.until(1.0)
        assert run.panel("example") is None, "it is drawn from now on"
        run.until(2.0)
        drawing = run.panel("example")
        assert drawing is not None
        assert drawing["items"]
        run.touch("example", "field", click)
        run.until(3.0)
        target = run["example.mission"].target
        assert (target.x, target.y) == (3.6, 4.0), "a click names a target"
        with pytest.raises(jde.Error, match="no panel"):
            run.panel("pioneer")


def test_conditions_are_those_of_breakpoints(navigation: Path) -> None:
    with jde.run(navigation) as run:
        assert run.until("vff.won", within=30.0)
        then = run.time
        assert run.winner("example/base") == "vff"
        assert run.until("time > 20.0")
        assert run.time == pytest.approx(max(20.0, then), abs=0.1)
        assert not run.until("collisions > 0", within=1.0)
        assert run.time == pytest.approx(max(20.0, then) + 1.0, abs=0.2)
        with pytest.raises(jde.Error, match="no variable is called `vfff.won`"):
            run.until("vfff.won")
        decision = next(decision for decision in run.decisions if decision["choice"] == "vff")
        assert decision["reason"]


@pytest.fixture
def still(tmp_path: Path, reach: Path) -> Path:
    """Return an application whose schemas sleep, so that nothing is ever due."""
    source = "from jde import Export, Schema\nclass Never(Schema, kind='motor', period='1s'):\n"
    (tmp_path / "never.py").write_text(source + "    number: Export[float]\n    def iterate(self, cx): pass\n")
    file = tmp_path / "still.toml"
    file.write_text('name = "still"\nroots = ["never"]\n[schemas.never]\ntype = "never.py"\n')
    return file


def test_a_function_is_not_waited_for_when_nothing_is_due(still: Path) -> None:
    with jde.run(still, mocks=["never"]) as run:
        run.stop("never")
        run.until(1.0)
        assert not run.step(), "nothing is due"
        assert not run.until(lambda run: False)
        assert not run.until("time > 5.0")
        assert run.time == 1.0
        assert not run.until(lambda run: False, within=2.0)
        assert run.time == 3.0
        assert run.outcome is None
        run.release("never")
        assert run.step(), "its check is due"
        assert run.time == pytest.approx(3.0, abs=1.0)


def test_a_time_is_reached_to_the_nanosecond(navigation: Path) -> None:
    with jde.run(navigation) as run:
        assert 0.1 + 0.2 > 0.3
        assert run.until(0.1 + 0.2)
        assert run.time == 0.3
        assert not run.until(lambda run: False, within=0.033)
        assert run.time == pytest.approx(0.333)


def test_a_mission_ends_the_run(navigation: Path) -> None:
    with jde.run(navigation) as run:
        assert not run.until(1e4), "it ends before"
        assert run.outcome == "done"
        assert run["example.mission.reached"] == 8
        assert not run.step()
    with jde.run(navigation, limit=2.0) as run:
        assert not run.until(3.0)
        assert (run.outcome, run.time) == ("time up", 2.0)


def test_traces_are_arrays(navigation: Path) -> None:
    with jde.run(navigation) as run:
        run.trace("pioneer.truth", "pioneer.laser")
        run.until(3.0)
        truth, laser = run.series("pioneer.truth"), run.series("pioneer.laser")
    assert len(truth) == len(truth["pose.x"]) == 61
    assert np.all(np.diff(truth.times) > 0.0)
    assert truth["pose.x"][-1] == run["pioneer.truth"].pose.x
    assert laser["ranges"].shape == (len(laser), 180)
    assert (laser["ranges"][-1] == run["pioneer.laser"].ranges).all()
    assert laser["header.frame_id"][0] == run["pioneer.laser"].header.frame_id
    with pytest.raises(KeyError, match="no field `pse`; the fields are"):
        _ = truth["pse.x"]
    pandas = pytest.importorskip("pandas")
    frame = truth.frame()
    assert isinstance(frame, pandas.DataFrame)
    assert frame["pose.x"].iloc[-1] == truth["pose.x"][-1]


def test_the_world_changes_while_it_runs(reach: Path) -> None:
    with jde.run(reach, mocks=["policy"]) as run:
        run.until(1.0)
        run.edit("robot", place={"x": -2.0, "y": 0.5, "heading_deg": 90.0})
        run.edit("robot", add={"name": "crate", "center": [-2.0, 2.0], "size": [0.4, 0.4]})
        run["policy.base"] = {"linear": {"x": 0.5}}
        assert run.until("collisions > 0", within=10.0)
        assert run["robot.truth.pose.y"] == pytest.approx(1.65, abs=0.02)
        run.edit("robot", remove="crate")
        assert run.until(lambda run: run["robot.truth.pose.y"] > 2.5, within=10.0)
        assert run["robot.edits"].refused == 0
        with pytest.raises(jde.Error, match="wrk"):
            run.edit("robot", wrk=1)


def test_a_mock_commands_what_it_is_given(reach: Path) -> None:
    with jde.run(reach, mocks=["policy"]) as run:
        run["policy.base"] = {"linear": {"x": 0.4}}
        run.until(3.0)
        assert run["robot.velocity"].linear.x == 0.4
        run["policy.base"] = {"angular": {"z": 0.3}}
        run.until(4.0)
        assert (run["robot.velocity"].linear.x, run["robot.velocity"].angular.z) == (0.0, 0.3)
        twist = run["robot.velocity"]
        run["policy.base"] = twist
        run["policy.base"] = jde.types.Twist.planar(0.2, 0.1)
        run.until(4.5)
        assert (run["robot.velocity"].linear.x, run["robot.velocity"].angular.z) == (0.2, 0.1)
        with pytest.raises(jde.Error, match="no field `lin`"):
            run["policy.base"] = {"lin": 1.0}
        run["policy.base"] = {"linear": {"x": math.nan}}
        run.until(4.8)
        assert run["robot.velocity"].linear.x == 0.2, "the host refuses it"
        run.until(6.0)
        assert run["robot.velocity"] is None, "what is not renewed is over"
        assert run["robot.truth.twist.linear.x"] == pytest.approx(0.0, abs=1e-6), "no command is in force"
        assert any(event["kind"] == "refused" and event["schema"] == "policy" for event in run.events)


def test_an_exception_of_a_condition_ends_the_run_in_order(navigation: Path) -> None:
    with jde.run(navigation) as run:
        with pytest.raises(ZeroDivisionError):
            run.until(lambda run: 1 / 0)
        assert run.outcome == "stopped"


def test_ctrl_c_ends_the_run_in_order(navigation: Path, request: pytest.FixtureRequest) -> None:
    # A shell that starts this in the background lets it ignore the signal.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    request.addfinalizer(lambda: signal.signal(signal.SIGINT, before))
    with jde.run(navigation, set={"example.rounds": 0}) as run:
        interruption = threading.Timer(0.2, _thread.interrupt_main)
        interruption.start()
        with pytest.raises(KeyboardInterrupt):
            run.until(1e6)
        interruption.join()
        assert run.outcome == "stopped"


def test_other_threads_of_python_go_on_while_time_passes(navigation: Path) -> None:
    with jde.run(navigation, set={"example.rounds": 0}) as run:
        seen = []
        observer = threading.Thread(target=lambda: seen.append(run.until(lambda run: run.time >= 20.0, within=60.0)))
        observer.start()
        while observer.is_alive():
            run.step()
        observer.join()
        assert seen == [True]


def test_faults_of_an_application_are_named(tmp_path: Path, reach: Path) -> None:
    with pytest.raises(jde.Error, match="no.toml"):
        jde.run(tmp_path / "no.toml")
    with pytest.raises(jde.Error, match="polcy"):
        jde.run(reach, mocks=["policy"], set={"polcy.period": "1 s"})
    with pytest.raises(jde.Error, match="no such schema"):
        jde.run(reach, mocks=["policy", "polcy"])
    with pytest.raises(ValueError, match="not a time"):
        jde.run(reach, mocks=["policy"]).until(-1.0)


def test_an_application_says_what_it_has(reach: Path) -> None:
    application = jde.Application(reach, mocks=["policy"])
    assert (application.name, application.schemas) == ("reach", ["robot", "policy"])
    assert application.variables["robot.truth"] == "jde_msgs/msg/Truth"


def test_what_contains_itself_is_no_value(navigation: Path) -> None:
    itself: list[object] = []
    itself.append(itself)
    dictionary: dict[str, object] = {}
    dictionary["me"] = dictionary
    deep: object = 1.0
    for _ in range(10_000):
        deep = [deep]
    with jde.run(navigation) as run:
        for value in (itself, dictionary, deep):
            with pytest.raises(ValueError, match="64 levels deep"):
                run["goon.ahead"] = value


def test_a_field_that_fits_into_no_memory_is_refused() -> None:
    with pytest.raises(ValueError, match="more than 256 MiB"):
        jde._jde.Layout("my/msg/Huge", "", [("data", "", "", "uint8", "sequence", 2**62)])
