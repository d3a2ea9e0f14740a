"""The arm: nothing has wheels, and the same rules hold."""

import jde
from conftest import ROOT

ARM = ROOT / "examples/mujoco/arm/arm.toml"
# A tag in the zone around the post, and somebody's hand far away.
BESIDE_THE_POST = {"arm.tags": "{ poses = [[0.1, 0.4, 0]] }", "arm.intruder": "{ poses = [[2, 2, 0], [2, 2.1, 0]] }"}


def test_it_reaches_the_tags_and_leaves_room_for_a_hand():
    with jde.run(ARM, seed=1) as run:
        run.until("arm.reached == 4", within=90.0)
        assert run["arm.reached"] == 4, run.snapshot()
        assert run["arm.truth"].collisions == 0
        winners = {decision["choice"] for decision in run.decisions}
    assert {"retreat", "reach", "rest"} <= winners, winners


def test_the_guard_keeps_it_out_of_the_zone_around_the_post():
    with jde.run(ARM, seed=1, set=BESIDE_THE_POST) as run:
        run.until(15.0)
        truth = run["arm.truth"]
        assert run["arm.reached"] == 0, "the tag is in the zone"
        assert truth.collisions == 0
        assert 0.0 < truth.min_clearance < 0.1, "it came near"
        assert any("forbidden zone" in event["text"] for event in run.events)


def test_without_the_zone_it_touches_the_post():
    with jde.run(ARM, seed=1, set={**BESIDE_THE_POST, "guard.zones": "{ zones = [] }"}) as run:
        run.until(15.0)
        assert run["arm.truth"].collisions > 0


def test_where_nobody_knows_where_a_hand_is_it_stands():
    with jde.run(ARM, seed=1, set={"arm.intruder": "{ poses = [] }"}) as run:
        run.until(1.0)
        before = list(run["arm.joints"].position)
        run.until(3.0)
        assert run.winner("roots") == "retreat"
        assert list(run["arm.joints"].position) == before
