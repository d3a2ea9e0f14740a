"""Worlds and robots of the simulator's files, for drivers of other simulators."""

import math
from pathlib import Path

import pytest

import jde
from conftest import WORLD
from jde.worlds import World, robot_model


@pytest.fixture
def room(tmp_path: Path) -> Path:
    """Return a room with a cart."""
    file = tmp_path / "room.toml"
    file.write_text('movers = [{ name = "cart", radius = 0.2, way = [[1, 3], [5, 3]], speed = 0.5 }]\n' + WORLD)
    return file


def test_a_world_has_what_stands_and_what_moves(room: Path) -> None:
    world = World(room, "pioneer", "pioneer-3dx")
    assert world.name == "room"
    assert world.pose == [4.0, 1.5, 0.0]
    walls = world.things(False)
    assert [wall["form"] for wall in walls] == ["wall"] * 4
    assert sorted(wall["size"][0] for wall in walls) == [4.0, 4.0, 6.0, 6.0]
    (cart,) = world.things(True)
    assert (cart["name"], cart["form"], cart["size"][0]) == ("cart", "circle", 0.4)
    assert world.moved()[0][:2] == [1.0, 3.0]
    world.advance(2_000_000_000)
    assert world.moved()[0][0] == pytest.approx(2.0)


def test_what_moves_stops_before_a_robot_that_another_simulator_moves(room: Path) -> None:
    world = World(room, "pioneer", "pioneer-3dx")
    world.set_pose([3.0, 3.0, math.pi])
    world.advance(10_000_000_000)
    assert world.moved()[0][0] < 3.0 - 0.25 - 0.2
    # Into a wall it is not put.
    world.set_pose([0.1, 3.0, 0.0])
    assert world.pose[0] == 3.0


def test_edits_are_counted_and_a_numbered_one_is_made_once(room: Path) -> None:
    world = World(room, "pioneer", "pioneer-3dx", [1.0, 1.0, 0.5])
    assert world.pose == [1.0, 1.0, 0.5]
    door = "{ number = 1, edits = [{ add = { name = 'door', center = [3, 1], size = [0.1, 1] } }] }"
    assert world.edit(door) == (1, 0, "")
    assert world.edit(door) == (0, 0, "")
    assert world.changes == 1
    assert len(world.things(False)) == 5
    done, refused, note = world.edit("{ remove = 'dor' }")
    assert (done, refused) == (0, 1)
    assert "door" in note


def test_a_robot_file_is_a_dictionary() -> None:
    jackal = robot_model("jackal")
    assert jackal["radius"] is None
    assert len(jackal["corners"]) == 4
    assert jackal["physics"]["track_multiplier"] == 1.5
    assert jackal["lasers"][0]["beams"] == 720
    assert robot_model("pioneer-3dx")["physics"] is None
    with pytest.raises(jde.Error, match="jackl"):
        robot_model("jackl")
