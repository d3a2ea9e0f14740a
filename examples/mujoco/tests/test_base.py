"""A robot in a room, without an application."""

import math

import mujoco
import numpy as np
import pytest

from jde.worlds import World, robot_model
from jde_mujoco.base import Base
from jde_mujoco.scanner import Scanner


def base(room, model, *, start=(0.0, 0.0, 0.0), friction=None, wheels_touch=False):
    """Return a robot at rest, with wheels that err in nothing."""
    robot = robot_model(model)
    robot["wheel_error"] = robot["slip"] = 0.0
    if friction is not None:
        robot["physics"]["friction"] = friction
    return Base(World(room, "robot", model, start), robot, np.random.default_rng(0), wheels_touch)


def drive(robot, seconds, ahead, turn):
    """Drive for a while, and return the poses after each 20 ms, with headings that do not jump."""
    robot.motors.take(ahead, turn)
    poses, end = [robot.pose()], robot.now + round(seconds * 1e9)
    while robot.now < end:
        robot.advance(robot.now + 20_000_000)
        poses.append(robot.pose())
    poses = np.array(poses)
    poses[:, 2] = np.unwrap(poses[:, 2])
    return poses


@pytest.mark.parametrize("model", ["turtlebot4", "jackal"])
def test_a_robot_without_a_command_rests(room, model):
    robot = base(room, model)
    x, y, heading = drive(robot, 2.0, 0.0, 0.0)[-1]
    assert math.hypot(x, y) < 1e-3
    assert abs(heading) < 1e-3
    assert robot.lean() < math.radians(0.1)
    assert robot.collisions == 0


def test_a_turtlebot_follows_its_commands(room):
    robot = base(room, "turtlebot4", start=(-1.5, 0.0, 0.0))
    x, y, _ = drive(robot, 4.0, 0.4, 0.0)[-1]
    # It reaches 0.4 m/s after 0.44 s, at 0.9 m/s².
    assert x == pytest.approx(-1.5 + 0.4 * (4.0 - 0.22), abs=0.05)
    assert y == pytest.approx(0.0, abs=0.01)
    drive(robot, 1.0, 0.0, 0.0)
    turned = np.diff(drive(robot, 4.0, 0.0, 1.0)[:, 2]).sum()
    assert turned == pytest.approx(4.0 - 0.06, abs=0.05)
    assert robot.odometer.pose[0] == pytest.approx(robot.pose()[0], abs=0.03)


def test_a_jackal_skids_in_turns(room):
    robot = base(room, "jackal")
    drive(robot, 1.0, 0.0, 0.3)
    slow = np.diff(drive(robot, 3.0, 0.0, 0.3)[:, 2]).sum() / 0.9
    drive(robot, 1.0, 0.0, 2.0)
    fast = np.diff(drive(robot, 3.0, 0.0, 2.0)[:, 2]).sum() / 6.0
    # Its controller turns its wheels 1.5 times as fast as their distance says. By the friction of four tyres that slide,
    # a base of these proportions needs 1 + (0.262 / 0.376)² = 1.49.
    assert slow == pytest.approx(1.0, abs=0.08)
    assert fast == pytest.approx(0.9, abs=0.1)
    skidding = robot_model("jackal")["physics"] | {"track_multiplier": 1.0}
    robot.odometer.track = robot.robot["track"] * skidding["track_multiplier"]
    robot.levers *= 1 / 1.5
    bare = np.diff(drive(robot, 3.0, 0.0, 0.3)[:, 2]).sum() / 0.9
    assert bare == pytest.approx(1 / 1.49, abs=0.08), "the wheels alone do not say how it turns"


def test_tyres_without_friction_spin(room):
    grips, slips = (drive(base(room, "turtlebot4", friction=mu), 2.0, 0.4, 0.0)[-1][0] for mu in (0.8, 0.02))
    assert slips < 0.7 * grips


def test_a_contact_with_a_wall_is_one_collision(room):
    robot = base(room, "turtlebot4", start=(2.0, 0.0, 0.0))
    assert robot.clearance() == pytest.approx(1.0 - 0.171 - 0.005, abs=1e-3), "a wall is a centimetre thick here"
    drive(robot, 5.0, 0.4, 0.0)
    assert robot.collisions == 1
    assert robot.is_stalled()
    assert robot.pose()[0] == pytest.approx(3.0 - 0.171, abs=0.02)
    assert robot.min_clearance < 0.003
    drive(robot, 2.0, -0.2, 0.0)
    assert not robot.contact
    drive(robot, 4.0, 0.4, 0.0)
    assert robot.collisions == 2


def test_a_laser_measures_the_room(room):
    robot = base(room, "turtlebot4")
    laser = robot.robot["lasers"][0] | {"noise": 0.0}
    ranges = Scanner(laser, np.random.default_rng(0)).take(0.0, robot.model, robot.data, robot.pose())
    angles = laser["angle_min"] + laser["angle_increment"] * np.arange(laser["beams"])
    x, y, _ = laser["mount"]

    def measured(angle):
        return ranges[np.argmin(abs(angles - angle))]

    assert measured(0.0) == pytest.approx(3.0 - x - 0.005, abs=0.005)
    assert measured(math.pi / 4) == pytest.approx((3.0 - y - 0.005) * math.sqrt(2), abs=0.06)
    # The box, 0.4 m wide, has its middle at (-1, 2).
    assert measured(math.atan2(2.0, -1.0 - x)) == pytest.approx(math.hypot(2.0, 1.0 + x) * 0.9, abs=0.02)


def test_a_turning_laser_casts_each_beam_from_where_the_robot_is_then(room):
    robot = base(room, "realistic-turtlebot4", start=(0.0, 0.0, 0.0))
    laser = robot.robot["lasers"][0] | {"noise": 0.0, "dropped_beams": 0.0}
    scanner = Scanner(laser, np.random.default_rng(0))
    scans = []
    robot.motors.take(0.4, 0.0)
    robot.advance(2_000_000_000, lambda now: scans.extend(scanner.turn_to(now, robot.model, robot.data, robot.pose())))
    (first, began), (_, next_began) = scans[-2:]
    assert next_began - began == pytest.approx(1 / 5.5, abs=1e-6)
    angles = laser["angle_min"] + laser["angle_increment"] * np.arange(laser["beams"])
    ahead = int(np.argmin(abs(angles)))
    # It turns clockwise from behind, so it is nearer to the wall ahead than at the time of its first beam.
    time = began + ahead * laser["time_increment"]
    place = 0.4 * (time - 0.27)
    assert first[ahead] == pytest.approx(3.0 - 0.005 - place - laser["mount"][0], abs=0.03)


def test_what_moves_by_itself_moves_and_stops_before_the_robot(room):
    robot = base(room, "turtlebot4", start=(0.0, -2.0, 0.0))
    robot.advance(10_000_000_000)
    (place,) = (robot.data.mocap_pos[number] for number in range(robot.model.nmocap))
    assert place[0] == pytest.approx(-0.5 - 0.171 - 0.2, abs=0.05), "the clearance of a mover is 0.5 m"
    assert robot.collisions == 0


def test_an_edit_changes_the_model_and_the_robot_goes_on(room):
    robot = base(room, "turtlebot4")
    drive(robot, 1.0, 0.4, 0.0)
    speed, gap = robot.twist()[0], robot.clearance()
    assert robot.edit("[{ add = { name = 'door', center = [1, 0], size = [0.1, 1] } }]") == (1, 0, "")
    assert robot.clearance() < gap - 0.5
    assert robot.twist()[0] == pytest.approx(speed)
    assert robot.edit("{ remove = 'nothing' }")[1] == 1
    assert robot.edit("{ place = { x = -2, y = 1, heading_deg = 90 } }")[0] == 1
    assert robot.pose() == pytest.approx((-2.0, 1.0, math.pi / 2))
    assert robot.twist()[0] == pytest.approx(0.0)


def test_the_model_is_one_of_mujoco(room):
    robot = base(room, "jackal", wheels_touch=True)
    assert isinstance(robot.model, mujoco.MjModel)
    body = robot.model.body("robot")
    assert robot.model.body_subtreemass[body.id] == pytest.approx(17.0)
