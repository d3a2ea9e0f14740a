"""A robot with wheels on two sides, which MuJoCo moves: a driver with the ports of `sim/robot`.

Worlds and robots are those of jde's files. What moves by itself does as in jde's simulator. It opens no window.
"""

import math

import numpy as np

from jde import Error
from jde import types as t
from jde.worlds import World, robot_model
from jde_mujoco.base import TIPPED, Base
from jde_mujoco.delivery import Delivery
from jde_mujoco.ports import BaseDynamics, EditCount, Entry, Overrides, Sensed
from jde_mujoco.scanner import Scanner

#: The time between two values of `movers`, s: smooth for viewers, and small in a recording.
MOVERS_PERIOD = 0.1
#: Forms of a `Thing`.
FORMS = {"wall": 0, "box": 0, "circle": 1}
#: The most objects that `Scenery` and `Movers` have room for.
MOST_THINGS, MOST_MOVERS = 1024, 64
#: The headings of the bumpers ahead, rad, from left to right; those behind are turned by half a turn.
BUMPERS = [math.radians(angle) for angle in (52, 19, 0, -19, -52)]


class Robot(Entry, Overrides, Sensed, kind="driver", period="50ms", budget="50ms"):
    """A robot of a robot file in a world, moved by MuJoCo: its wheels roll, slip and skid on the floor.

    It takes the place of `sim/robot`: `jde run navigate --set robot.type=mujoco/Robot`. The world is its own: another
    driver of the same application does not meet this robot.
    """

    def inspect(self, cx, problems):
        """Load the robot and the world, as `awake` does."""
        try:
            robot = self._robot()
        except (Error, ValueError) as error:
            problems.wrong(Robot.model, str(error))
            return
        try:
            self._world(cx)
        except (Error, ValueError) as error:
            problems.wrong(Robot.world, str(error))
            return
        if robot["kinematics"] != "differential":
            problems.wrong(Robot.model, f"{robot['name']} is {robot['kinematics']}: expected a differential robot")

    def awake(self, cx):
        """Enter the world, or go on in it."""
        if hasattr(self, "base"):
            return
        robot = self._robot()
        world = self._world(cx)
        random = np.random.default_rng([cx.seed, 0])
        self.base = Base(world, robot, random, self.wheels_touch, round(cx.now * 1e9))
        self.wheels = Delivery(robot["odometry"], np.random.default_rng([cx.seed, 1]))
        self.scanner = self.scans = None
        if robot["lasers"]:
            laser = robot["lasers"][0]
            self.scanner = Scanner(laser, np.random.default_rng([cx.seed, 2]))
            self.scanner.restart(cx.now)
            self.scans = Delivery(laser["delivery"], np.random.default_rng([cx.seed, 3]))
        self.since, self.movers_due, self.last_edit, self.has_tipped = cx.now, 0.0, 0, False
        self.count = (0, 0, "")
        self.changes = None

    def _robot(self):
        robot = robot_model(self.model)
        if robot["physics"] is None:
            raise ValueError(f"the robot {robot['name']} states no masses and wheels: its file needs [physics]")
        if robot["lasers"]:
            laser = robot["lasers"][0]
            _replace(laser, "range_max", self.laser_range)
            _replace(laser, "height", self.laser_height)
            _replace(laser, "noise", self.laser_noise)
        _replace(robot, "wheel_error", self.wheel_error)
        _replace(robot, "acceleration", self.acceleration)
        _replace(robot, "deceleration", self.acceleration)
        _replace(robot, "lag", self.lag)
        _replace(robot["physics"], "friction", self.friction)
        return robot

    def _world(self, cx):
        if not self.world:
            raise ValueError('it has no world; give it one in the application: world = "worlds/office.toml"')
        start = [[pose.x, pose.y, pose.theta] for pose in self.start.pose]
        return World(self.world, self.robot or cx.name, self.model, *start, seed=cx.seed)

    def sleep(self, cx):
        """Stop the wheels. What is on its way does not arrive."""
        self.base.motors.take(0.0, 0.0)
        for way in filter(None, (self.wheels, self.scans)):
            way.clear()

    def iterate(self, cx):
        """Simulate up to now under the last command, take the new one, and publish what is sensed."""
        base, command = self.base, self.velocity
        base.advance(round(cx.now * 1e9), self._turn_laser)
        base.motors.take(command.linear.x, command.angular.z)
        self._edit(cx)
        self._sense(cx)
        self._export_truth(cx)
        self._export_world(cx)
        if not self.has_tipped and base.lean() > TIPPED:
            self.has_tipped = True
            cx.warn("the robot has tipped over")

    def _turn_laser(self, now):
        if self.scanner is not None:
            base = self.base
            for ranges, time in self.scanner.turn_to(now, base.model, base.data, base.pose()):
                self.scans.send(ranges, time, now)

    def _edit(self, cx):
        written = cx.sample(Robot.edit)
        if written.sequence == self.last_edit:
            return
        self.last_edit = written.sequence
        done, refused, note = self.base.edit(written.value)
        if refused:
            cx.warn(f"the world stays as it is: {note}")
        before = self.count
        self.count = (before[0] + done, before[1] + refused, note or before[2])
        self.edits.write(EditCount(*self.count))

    def _sense(self, cx):
        base, now = self.base, cx.now
        if self.scanner is not None:
            scan = self.scanner.take(now, base.model, base.data, base.pose())
            if scan is not None:
                self.scans.send(scan, now, now)
            for ranges, time in self.scans.arrived(now):
                self.laser.write(self._scan(ranges, time), time=time)
        odometer = base.odometer
        state = odometer.pose, odometer.speeds, odometer.pose_covariance(), odometer.twist_covariance(), odometer.ticks
        self.wheels.send(state, now, now)
        for (pose, speeds, pose_covariance, twist_covariance, ticks), time in self.wheels.arrived(now):
            x, y, heading = pose
            self.odometry.write(
                t.Odometry(
                    _header(time, "odom"),
                    "base_link",
                    t.PoseWithCovariance(
                        t.Pose(t.Point(x, y, 0.0), t.Quaternion.from_yaw(heading)), _in_space(pose_covariance)
                    ),
                    t.TwistWithCovariance(t.Twist.planar(*speeds), _in_space(twist_covariance)),
                ),
                time=time,
            )
            left, right = (int(count) for count in ticks)
            encoders = t.WheelEncoders(_header(time, "base_link"), left, right, base.robot["ticks_per_meter"])
            self.encoders.write(encoders, time=time)
        if base.robot["bumpers"]:
            self._export_bumpers(now)
        self.setpoint.write(t.Twist.planar(*base.motors.target))

    def _scan(self, ranges, time):
        laser = self.base.robot["lasers"][0]
        return t.LaserScan(
            header=_header(time, "laser"),
            angle_min=laser["angle_min"],
            angle_max=laser["angle_max"],
            angle_increment=laser["angle_increment"],
            time_increment=laser["time_increment"],
            scan_time=laser["turn"] or 0.0,
            range_min=laser["range_min"],
            range_max=laser["range_max"],
            ranges=ranges,
        )

    def _export_bumpers(self, now):
        base = self.base
        x, y, heading = base.pose()
        pressed = [0, 0]
        for place in base.contact_places():
            angle = math.remainder(math.atan2(place[1] - y, place[0] - x) - heading, math.tau)
            is_ahead = abs(angle) <= math.pi / 2
            angle = angle if is_ahead else math.remainder(angle - math.pi, math.tau)
            number = min(range(len(BUMPERS)), key=lambda bumper: abs(BUMPERS[bumper] - angle))
            pressed[0 if is_ahead else 1] |= 1 << number
        # Behind, left is where the angle is negative.
        front = [bool(pressed[0] >> bumper & 1) for bumper in range(len(BUMPERS))]
        rear = [bool(pressed[1] >> bumper & 1) for bumper in reversed(range(len(BUMPERS)))]
        self.bumpers.write(t.Bumpers(_header(now, "base_link"), front, rear, base.is_stalled()))

    def _export_truth(self, cx):
        base = self.base
        (x, y, heading), (ahead, left, turn) = base.pose(), base.twist()
        twist = t.Twist.planar(ahead, turn)
        twist.linear.y = left
        clearance = base.clearance()
        self.truth.write(t.Truth(t.Pose2D(x, y, heading), twist, clearance, base.min_clearance, base.collisions))

    def _export_world(self, cx):
        base, now = self.base, cx.now
        if self.changes is None:
            self._export_robot(cx)
        if self.changes != base.world.changes:
            self.changes = base.world.changes
            things = base.world.things(False)
            shown = [_thing(thing) for thing in things[:MOST_THINGS]]
            self.scenery.write(t.Scenery(_header(now, "map"), len(things) - len(shown), shown))
        if now >= self.movers_due - 1e-9:
            self.movers_due = now + MOVERS_PERIOD
            things = base.world.things(True)
            shown = [_thing(thing) for thing in things[:MOST_MOVERS]]
            self.movers.write(t.Movers(_header(now, "map"), len(things) - len(shown), shown))

    def _export_robot(self, cx):
        robot, header = self.base.robot, _header(self.since, "")
        self.connection.write(t.Connection(header, 2, 0, self.base.world.name))
        corners = [t.Point2D(x, y) for x, y in robot["corners"]]
        corners = corners[:: max(1, math.ceil(len(corners) / 32))]
        radius = robot["radius"] or max(math.hypot(corner.x, corner.y) for corner in corners)
        lasers = [t.Mount("laser", t.Pose2D(*laser["mount"])) for laser in robot["lasers"][:1]]
        self.body.write(t.Body(_header(cx.now, "base_link"), t.Footprint(radius, corners), lasers))
        limits = [robot[name] for name in ("acceleration", "deceleration", "turn_acceleration", "turn_deceleration")]
        self.dynamics.write(BaseDynamics(*limits, robot["lag"]))


def _replace(table, key, number):
    if number >= 0:
        table[key] = number


def _header(time, frame):
    return t.Header(t.Time(*divmod(round(time * 1e9), 1_000_000_000)), frame)


def _in_space(covariance):
    """Return the covariance of x, y, z and the rotations about them."""
    space = np.zeros((6, 6))
    space[np.ix_([0, 1, 5], [0, 1, 5])] = covariance
    return space.ravel()


def _thing(thing):
    (x, y, heading), (length, width) = thing["pose"], thing["size"]
    pose = t.Pose2D(x, y, heading)
    return t.Thing(thing["name"][:60], pose, length, width, thing["height"], FORMS[thing["form"]], *thing["color"])
