"""Every part of a schema, on the bench."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Sequence
from enum import Enum
from typing import Annotated, Any, ClassVar

import numpy
import pytest

from jde import (
    Actuator,
    Child,
    Children,
    Command,
    Context,
    Export,
    Hysteresis,
    Import,
    Level,
    Modulates,
    Modulation,
    Outcome,
    Policy,
    Precondition,
    Problems,
    Schema,
    State,
    Verdict,
    child,
    children,
    command,
    f32,
    field,
    modulates,
    modulation,
    optional,
    seq,
    text,
    trigger,
    u8,
    unit,
    value,
)
from jde import types as t
from jde.bench import Bench
from jde.panel import Gesture, Ink, Pen


@value("my_msgs/msg/Door")
class Door:
    """A door."""

    at: t.Pose2D
    """Where it is."""
    width: f32 = field(unit="m")
    """How wide it is."""
    is_open: bool = False
    name: Annotated[str, text(16)] = ""
    marks: Annotated[Sequence[int], seq(u8, 200)] = field(default_factory=list)


class Gait(Enum):
    """How to go."""

    SLOW = "slow"
    VERY_FAST = "fast"


class Shy(Schema, kind="motor", period="100ms"):
    """Backs away from whatever comes too near."""

    laser: Import[t.LaserScan] = trigger()
    """What the laser sees ahead."""
    distance: Modulation[float] = modulation(0.8, unit="m", min=0.0)
    gait: Modulation[Gait] = modulation(Gait.SLOW)
    base: Actuator[t.Twist]

    def __init__(self) -> None:
        self.near = Hysteresis()
        self.kept: Any = None
        self.steps = 0

    def check(self, cx: Context) -> Precondition:
        nearest = self.laser.nearest_ahead(0.4)
        near = self.near.below(math.inf if nearest is None else nearest, self.distance, self.distance + 0.3)
        return Precondition(near, urgency=2.0)

    def iterate(self, cx: Context) -> None:
        self.kept = self.laser.ranges
        self.steps += 1
        speed = -0.2 if self.gait is Gait.SLOW else -0.5
        if self.base.command(t.Twist.planar(speed, 0.0)) is Outcome.REFUSED:
            cx.warn(f"no authority at {cx.now:.1f} s")

    def save(self, cx: Context) -> dict[str, int]:
        return {"steps": self.steps}

    def restore(self, cx: Context, saved: dict[str, int], version: int) -> None:
        self.steps = saved["steps"]

    def inspect(self, cx: Context, problems: Problems) -> None:
        if self.distance > 5:
            problems.wrong(Shy.distance, f"{self.distance} m is farther than the laser sees")

    def draw(self, cx: Context, pen: Pen) -> None:
        pen.heading("Shy")
        pen.slider("distance", "Distance", self.distance, 0.0, 3.0, "m")
        with pen.row():
            pen.button("go", "Go")
        with pen.canvas("area", forward_up=True, clicks=True) as area:
            area.points(self.laser.points(), ink=Ink.SEEN)
            area.robot(t.Pose2D())
        pen.image("picture", numpy.zeros((2, 3), dtype=numpy.uint8), 3, 2, 1)

    def touched(self, cx: Context, gesture: Gesture) -> None:
        if gesture.pressed("go"):
            cx.info(f"{gesture.by} pressed")
        if (at := gesture.clicked("area")) is not None:
            cx.info(f"clicked at {at[0]:.1f}")


@value("my_msgs/msg/Places")
class Places:
    """Fields of all sizes one after another."""

    count: u8 = 0
    spots: Annotated[Sequence[float], seq(float, 3)] = field(default_factory=list)
    word: Annotated[str, text(5)] = ""
    last: u8 = 0


class Remember(Schema, kind="perceptive", period="100ms"):
    """Gives back what it takes."""

    places: Import[Places]
    kept: Export[Places]

    def iterate(self, cx: Context) -> None:
        self.kept.write(self.places)


def test_fields_have_the_places_that_they_have_in_rust_and_c() -> None:
    bench = Bench(Remember)
    places = Places(1, [0.5, -2.0], "fünf", 7)
    bench.give("places", places)
    bench.iterate()
    assert bench.exported("kept") == places


def scan(range: float) -> t.LaserScan:
    """A scan of one beam ahead."""
    return t.LaserScan(range_max=8.0, ranges=[range])


def test_it_is_ready_while_something_is_near() -> None:
    bench = Bench(Shy)
    assert not bench.check().ready, "without a scan"
    for range, ready in [(1.5, False), (0.7, True), (1.0, True), (1.2, False)]:
        bench.give("laser", scan(range))
        assert bench.check() == Precondition(ready, 2.0), f"{range} m"


def test_it_commands_with_authority_alone() -> None:
    bench = Bench(Shy)
    bench.give("laser", scan(0.5))
    bench.iterate()
    assert bench.commanded("base") == t.Twist.planar(-0.2, 0.0)
    bench.give("gait", Gait.VERY_FAST)
    bench.iterate()
    assert bench.commanded("base").linear.x == -0.5
    bench.set_authority(False)
    bench.set_now(2.0)
    bench.iterate()
    assert bench.commanded("base") is None
    assert bench.log == [("warn", "no authority at 2.0 s")]


def test_an_iteration_without_its_input_does_nothing() -> None:
    bench = Bench(Shy)
    bench.iterate()
    assert bench.commanded("base") is None
    bench.give("laser", scan(0.5))
    bench.iterate()
    bench.retract("laser")
    bench.iterate()
    assert bench.commanded("base") is None


def test_a_value_outside_the_limits_is_refused() -> None:
    with pytest.raises(ValueError, match="is -1 m, and at least 0 m is allowed"):
        Bench(Shy).give("distance", -1.0)


def test_a_view_that_is_kept_raises_after_the_call() -> None:
    class Keeps(Shy, kind="motor", period="1s"):
        def iterate(self, cx: Context) -> None:
            super().iterate(cx)
            assert list(self.kept) == [0.5]
            KEPT.append(self.kept)
            KEPT.append(numpy.asarray(self.laser.ranges))

    KEPT: list[Any] = []
    bench = Bench(Keeps)
    bench.give("laser", scan(0.5))
    bench.iterate()
    view, array = KEPT
    with pytest.raises(ValueError, match="released"):
        view[0]
    assert array[0] == 0.5
    with pytest.raises(ValueError, match="read-only"):
        array[0] = 1.0


def test_a_port_works_only_during_a_call() -> None:
    class Leaks(Shy, kind="motor", period="1s"):
        def iterate(self, cx: Context) -> None:
            LEAKED.append(self)

    LEAKED: list[Leaks] = []
    bench = Bench(Leaks)
    bench.iterate()
    with pytest.raises(RuntimeError, match="only during a call"):
        _ = LEAKED[0].distance


def test_memory_survives_a_reload() -> None:
    bench, other = Bench(Shy), Bench(Shy)
    bench.give("laser", scan(0.5))
    bench.iterate()
    other.restore(bench.save())
    assert other.save() == bench.save()
    assert other.save() != Bench(Shy).save()


def test_an_inspection_names_the_modulation() -> None:
    bench = Bench(Shy)
    assert bench.inspect() == []
    bench.give("distance", 6.0)
    assert bench.inspect() == [("distance", "6.0 m is farther than the laser sees")]


def test_the_panel_shows_what_is_drawn_and_takes_gestures() -> None:
    bench = Bench(Shy)
    bench.give("laser", scan(2.0))
    drawn = bench.draw()
    assert [next(iter(item)) if isinstance(item, dict) else item for item in drawn]
    bench.touch("go", "pressed")
    bench.touch("area", {"clicked": {"at": [1.5, 0.0, 0.0], "button": "primary"}})
    assert bench.log == [("info", "ana@laptop pressed"), ("info", "clicked at 1.5")]


def test_an_error_has_its_traceback() -> None:
    class Wrong(Shy, kind="motor", period="1s"):
        def iterate(self, cx: Context) -> None:
            raise KeyError("planted")

    with pytest.raises(RuntimeError, match=r"KeyError: 'planted'\n  File .*test_bench.py.*\n.*raise KeyError"):
        Bench(Wrong).iterate()


class Sees(Schema, kind="perceptive", period="50ms"):
    """Finds the door."""

    picture: Import[t.Image] = trigger()
    hint: Import[float] = optional(unit="m")
    door: Export[Door]
    nearest: Export[float] = unit("m")

    def iterate(self, cx: Context) -> None:
        picture = numpy.asarray(self.picture.data)
        brightest = int(picture.argmax())
        sample = cx.sample(Sees.hint)
        self.nearest.write(0.0 if sample is None else sample.value, time=1.25)
        self.door.write(Door(t.Pose2D(1.0, 2.0, 0.5), 0.9, True, "north", picture[:100].tolist()))
        cx.debug(brightest)


def test_large_values_and_own_types_pass() -> None:
    bench = Bench(Sees)
    data = numpy.zeros(640 * 480, dtype=numpy.uint8)
    data[777] = 9
    bench.give("picture", t.Image(width=640, height=480, step=640, encoding="mono8", data=memoryview(data.tobytes())))
    bench.unbind("hint")
    bench.iterate()
    door = bench.exported("door")
    assert (door.at, door.is_open, door.name) == (t.Pose2D(1.0, 2.0, 0.5), True, "north")
    assert door.width == pytest.approx(0.9) and len(door.marks) == 100
    assert bench.log == [("debug", "777")]
    assert (bench.exported("nearest"), bench.exported_at("nearest")) == (0.0, 1.25)


class Asks(Schema, kind="perceptive", period="50ms"):
    """Asks to switch something on."""

    request: Export[t.SetBool_Request]
    """The request."""

    def iterate(self, cx: Context) -> None:
        self.request.write(t.SetBool_Request(data=True))
        cx.debug("asked")


def test_a_request_with_one_field_is_an_object() -> None:
    bench = Bench(Asks)
    bench.iterate()
    assert bench.exported("request").data is True


class Father(Schema, kind="motor", period="75ms"):
    """Sends its children."""

    near: Child = child(group="base")
    far: Child = child(group="base")
    scout: Child = child(perceptive=True)
    rest: Children = children(group="all")
    speed: Modulates[float] = modulates("near", "speed", unit="m/s")

    def iterate(self, cx: Context) -> None:
        self.near.wake()
        self.scout.wake()
        self.rest.wake()
        self.speed.set(0.5)
        if self.far.is_faulted or self.near.state is State.WINNER:
            cx.info("seen")

    def arbitrate(self, cx: Context, level: Level) -> Verdict:
        if level.is_ready(self.far):
            return level.choose(self.far, "the far one decides")
        return level.nobody(f"nobody of {level.group}")


def test_a_father_wakes_modulates_and_decides() -> None:
    bench = Bench(Father)
    bench.name_children(one="all", two="all")
    bench.set_child("near", State.WINNER)
    bench.iterate()
    assert bench.awake_children == ["near", "scout", "one", "two"]
    assert bench.modulated("speed") == 0.5
    assert bench.log == [("info", "seen")]
    bench.set_child("far", State.READY)
    assert bench.arbitrate("base") == ("far", "the far one decides")
    bench.set_child("near", State.CHECKING)
    bench.set_child("far", State.CHECKING)
    assert bench.arbitrate("base") == (None, "nobody of base")


def test_a_father_sets_the_policy_of_a_group() -> None:
    class Sets(Father, kind="motor", period="75ms"):
        wanted: ClassVar[Any] = Policy.PRIORITY

        def iterate(self, cx: Context) -> None:
            cx.info(self.near.set_policy(self.wanted).name)

    bench = Bench(Sets)
    assert bench.policy("near") is None
    policies = [Policy.PRIORITY, Policy.URGENCY, Policy.FATHER, Policy.sticky(0.5, 0.1), Policy.round_robin(2.0)]
    assert [policy.name for policy in policies] == ["priority", "urgency", "father", "sticky", "round-robin"]
    for policy in policies:
        Sets.wanted = policy
        bench.iterate()
        assert bench.policy("near") == policy
    bench.set_authority(False)
    bench.iterate()
    assert [text for _, text in bench.log] == ["ACCEPTED"] * 5 + ["REFUSED"]
    Sets.wanted = 2
    with pytest.raises(RuntimeError, match="`near` takes a Policy, such as Policy.URGENCY, not 2"):
        bench.iterate()


def test_the_policy_of_a_child_without_a_group_is_a_mistake_in_words() -> None:
    class Sets(Father, kind="motor", period="75ms"):
        def iterate(self, cx: Context) -> None:
            self.scout.set_policy(Policy.URGENCY)

    with pytest.raises(RuntimeError, match="`scout` competes in no group"):
        Bench(Sets).iterate()


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Policy("loudest"), "no policy 'loudest', but priority, urgency, sticky, round-robin, father"),
        (lambda: Policy.sticky(-0.5, 0.1), "0 or more, not -0.5 and 0.1"),
        (lambda: Policy.sticky(0.5, math.nan), "0 or more, not 0.5 and nan"),
        (lambda: Policy.round_robin(0.0), "a turn is longer than 0 s"),
    ],
)
def test_what_is_no_policy_is_refused(make: Callable[[], Policy], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        make()


class Motor(Schema, kind="driver", period="20ms"):
    """A driver."""

    velocity: Command[t.Twist] = command(t.Twist(), validity="500ms")
    odometry: Export[t.Odometry]

    def iterate(self, cx: Context) -> None:
        sample = cx.sample(Motor.velocity)
        assert sample is not None
        self.odometry.write(t.Odometry())
        cx.info(f"{self.velocity.linear.x} {sample.in_force}")


def test_a_driver_reads_neutral_values() -> None:
    bench = Bench(Motor)
    bench.iterate()
    bench.give("velocity", t.Twist.planar(0.5, 0.0))
    bench.iterate()
    bench.set_now(1.0)
    bench.iterate()
    assert [text for _, text in bench.log] == ["0.0 False", "0.5 True", "0.0 False"]


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (t.Pose2D(), "takes a Twist, not a Pose2D"),
        (t.Twist(linear=t.Vector3(x="fast")), "`linear`: `x`: this takes a float64, not a str"),  # type: ignore[arg-type]
    ],
)
def test_a_wrong_value_is_named(wrong: Any, message: str) -> None:
    class Wrong(Schema, kind="motor", period="1s"):
        base: Actuator[t.Twist]

        def iterate(self, cx: Context) -> None:
            self.base.command(wrong)

    with pytest.raises(RuntimeError, match=f"actuator `base`: .*{message}"):
        Bench(Wrong).iterate()


def test_a_value_is_decoded_once_in_a_call() -> None:
    class Reads(Schema, kind="perceptive", period="1s"):
        laser: Import[t.LaserScan]
        target: Import[t.Target]
        kept: ClassVar[list[Any]] = []

        def iterate(self, cx: Context) -> None:
            self.kept.append(self.laser)
            sample = cx.sample(Reads.laser)
            assert sample is not None
            assert self.laser is self.kept[-1] is sample.value
            assert isinstance(self.target, t.Target)

    bench = Bench(Reads)
    bench.give("target", t.Target())
    for distance in (0.5, 0.7):
        bench.give("laser", t.LaserScan(range_max=distance, ranges=[distance]))
        bench.iterate()
    bench.iterate()
    first, second, third = Reads.kept
    assert (first.range_max, second.range_max) == (pytest.approx(0.5), pytest.approx(0.7))
    assert third is not second, "a call has its own"


def test_too_many_elements_are_refused() -> None:
    with pytest.raises(ValueError, match="`ranges` holds at most 1088 elements, not 1089"):
        Bench(Shy).give("laser", t.LaserScan(ranges=[1.0] * 1089))


class Lying(list):  # type: ignore[type-arg]
    """Numbers whose iterator disagrees with their length."""

    def __init__(self, length: int, given: Iterator[float]) -> None:
        super().__init__([0.0] * length)
        self.given = given

    def __iter__(self) -> Iterator[float]:
        return self.given


@pytest.mark.parametrize(("given", "words"), [(2, "gives 2"), (4, "gives 4 or more")])
def test_elements_that_disagree_with_their_number_are_refused(given: int, words: str) -> None:
    numbers = Lying(3, iter([1.0] * given))
    with pytest.raises(ValueError, match=f"`ranges` has 3 elements by its length, and its iterator {words}$"):
        Bench(Shy).give("laser", t.LaserScan(ranges=numbers))


def test_a_write_during_a_write_is_refused() -> None:
    class Writes(Schema, kind="perceptive", period="1s"):
        scan: Export[t.LaserScan]
        nested: ClassVar[str] = "write"

        def within(self) -> Iterator[float]:
            yield 1.0
            if self.nested == "write":
                self.scan.write(t.LaserScan(ranges=[7.0, 7.0]))
            elif self.nested == "retract":
                self.scan.retract()
            yield 2.0

        def iterate(self, cx: Context) -> None:
            self.scan.write(t.LaserScan(ranges=Lying(2, self.within())))

    bench = Bench(Writes)
    for Writes.nested in ("write", "retract"):
        with pytest.raises(RuntimeError, match="a value is being written: compute its elements first"):
            bench.iterate()
        assert bench.exported("scan") is None
    Writes.nested = "nothing"
    bench.iterate()
    assert list(bench.exported("scan").ranges) == [1.0, 2.0], "a write that failed has ended"


@pytest.mark.parametrize("time", [math.nan, -1.0, 1e300])
def test_a_time_of_a_value_that_is_none_is_refused(time: float) -> None:
    class Writes(Schema, kind="perceptive", period="1s"):
        nearest: Export[float]

        def iterate(self, cx: Context) -> None:
            self.nearest.write(1.0, time=time)

    with pytest.raises(
        RuntimeError, match=f"export `nearest`: {re.escape(repr(time))} is not a time: it is in seconds"
    ):
        Bench(Writes).iterate()


def test_a_number_that_is_not_finite_is_refused() -> None:
    class Wrong(Schema, kind="motor", period="1s"):
        base: Actuator[t.Twist]

        def iterate(self, cx: Context) -> None:
            assert self.base.command(t.Twist.planar(math.nan, 0.0)) is Outcome.NOT_FINITE

    Bench(Wrong).iterate()


def test_an_import_may_have_numbers_that_are_not_finite_as_in_an_application() -> None:
    class Reads(Schema, kind="perceptive", period="1s"):
        laser: Import[t.LaserScan]
        battery: Import[t.BatteryState]
        seen: Export[float]

        def iterate(self, cx: Context) -> None:
            ranges = list(self.laser.ranges)
            assert math.isinf(ranges[0]) and math.isnan(ranges[1])
            self.seen.write(ranges[2] + self.battery.percentage)

    bench = Bench(Reads)
    ranges = [math.inf, math.nan, 1.0]
    bench.give("laser", t.LaserScan(angle_min=-0.5, angle_max=0.5, angle_increment=0.5, range_max=8.0, ranges=ranges))
    bench.give("battery", t.BatteryState(percentage=0.5))
    bench.iterate()
    assert bench.exported("seen") == 1.5


def test_what_is_no_measurement_is_no_value_and_a_warning() -> None:
    bench = Bench(Shy)
    with pytest.warns(UserWarning, match="import `laser` has no value: its limits are 0 m and 0 m"):
        bench.give("laser", t.LaserScan(ranges=[1.0]))
    assert not bench.check().ready


def test_a_command_or_modulation_that_is_not_finite_is_refused_by_name() -> None:
    with pytest.raises(ValueError, match="`velocity` is not finite, and a command is"):
        Bench(Motor).give("velocity", t.Twist.planar(math.inf, 0.0))
    with pytest.raises(ValueError, match="`distance` is not finite, and a modulation is"):
        Bench(Shy).give("distance", math.nan)


def test_the_layouts_are_those_of_c() -> None:
    layout = Door.__jde_layout__  # type: ignore[attr-defined]
    assert (layout.name, layout.size) == ("my_msgs/msg/Door", 264)
    for kind in vars(t).values():
        if isinstance(kind, type) and "__jde_layout__" in vars(kind):
            made = kind()
            layout = kind.__jde_layout__  # type: ignore[attr-defined]
            assert layout.encode(layout.decode(layout.encode(made))) == layout.encode(made), kind


def test_a_list_of_texts_is_one_of_str() -> None:
    layout = t.JointState.__jde_layout__  # type: ignore[attr-defined]
    joints = layout.decode(layout.encode(t.JointState(name=["left", "right"], position=[1.0, 2.0])))
    assert (joints.name, list(joints.position)) == (["left", "right"], [1.0, 2.0])
    with pytest.raises(ValueError, match="`name`: `data` holds at most 60 bytes, not 61"):
        layout.encode(t.JointState(name=["x" * 61]))
