"""A robot with wheels on two sides in a world of jde's files, moved by MuJoCo. It has no ports and no clock."""

import math

import mujoco
import numpy as np

from jde.worlds import World
from jde_mujoco import model as build
from jde_mujoco.motors import Motors, SpeedControl
from jde_mujoco.odometer import Odometer

#: A step of what moves by itself, ns: that of the simulator of jde. The odometry is read as often.
WORLD_STEP = 10_000_000
#: How long nothing is simulated at most, s, when nobody has read the robot for longer: it stands then.
LONGEST_GAP = 5.0
#: A contact begins when bodies touch, and ends at this gap, m, as in the simulator of jde.
APART = 0.003
#: Below this speed, m/s and rad/s, a robot that presses on something does not move.
AT_REST = 0.02
#: The lean at which the robot counts as tipped over: beyond it no robot returns to its wheels.
TIPPED = math.radians(45)


class Base:
    """A robot, its world, and the time up to which both are simulated."""

    def __init__(self, world: World, robot, random, wheels_touch=False, now_ns=0):
        """Put the robot at its place in the world, at rest."""
        self.world, self.robot, self.wheels_touch = world, robot, wheels_touch
        self.motors = Motors(robot)
        self.odometer = Odometer(robot, world.pose, random)
        self.sides = [np.array(wheels) for wheels in build.sides_of(robot)]
        # By how much each wheel is faster in a turn to the left, m/s for each rad/s.
        self.levers = np.full(len(robot["physics"]["wheels"]), self.odometer.track / 2)
        self.levers[self.sides[0]] *= -1
        self.model = self.data = None
        self.now = now_ns
        self.collisions, self.contact, self.min_clearance = 0, False, math.inf
        self._load()
        self.place(world.pose)

    def _load(self):
        """Make the model of the world as it is now. The robot goes on as before."""
        before = self.data
        things, moving = self.world.things(False), self.world.things(True)
        text = build.build(things, moving, self.robot, self.wheels_touch)
        self.model = mujoco.MjModel.from_xml_string(text)
        self.data = mujoco.MjData(self.model)
        if before is not None:
            # The robot alone has joints.
            self.data.qpos, self.data.qvel, self.data.ctrl = before.qpos, before.qvel, before.ctrl
        self.changes = self.world.changes
        self.dt = round(self.model.opt.timestep * 1e9)
        self.body = self.model.geom("body").id
        self.is_thing = self.model.geom_group == build.THINGS
        self.things = np.flatnonzero(self.is_thing)
        self._move_others()
        mujoco.mj_forward(self.model, self.data)

    def place(self, pose):
        """Put the robot at a pose, at rest. Its odometry does not jump."""
        x, y, heading = pose
        self.data.qpos[:7] = x, y, 0, math.cos(heading / 2), 0, 0, math.sin(heading / 2)
        self.data.qvel[:] = 0
        self.motors = Motors(self.robot)
        self.speed_control = SpeedControl(self.robot, self.dt / 1e9)
        self.rolled = self._wheel_angles()
        mujoco.mj_forward(self.model, self.data)
        self.min_clearance = min(self.min_clearance, self.clearance())

    def edit(self, text):
        """Make changes of the world; see `World.edit`."""
        before = self.world.pose
        result = self.world.edit(text)
        if self.world.pose != before:
            self.place(self.world.pose)
        if self.world.changes != self.changes:
            self._load()
        return result

    def advance(self, now, after_step=lambda time: None):
        """Simulate until a time in nanoseconds, and call `after_step` with the time in seconds after each step."""
        if now - self.now > LONGEST_GAP * 1e9:
            # Nobody drove it: only what moves by itself did, which needs no steps.
            self.now = now - int(LONGEST_GAP * 1e9) // self.dt * self.dt
        while self.now + self.dt <= now:
            self._step()
            after_step(self.now / 1e9)

    def _step(self):
        seconds = self.dt / 1e9
        ahead, turn = self.motors.step(seconds)
        radius = self.robot["physics"]["wheel_radius"]
        wanted = (ahead + turn * self.levers) / radius
        self.data.ctrl[:] = self.speed_control.torques(wanted, self.data.qvel[6:])
        mujoco.mj_step(self.model, self.data)
        self.now += self.dt
        if self.now % WORLD_STEP < self.dt:
            self.world.set_pose(self.pose())
            self.world.advance(self.now)
            self._move_others()
            angles = self._wheel_angles()
            self.odometer.roll((angles - self.rolled) * radius, WORLD_STEP / 1e9)
            self.rolled = angles
        self._count_contacts()

    def _move_others(self):
        for number, (x, y, heading) in enumerate(self.world.moved()):
            self.data.mocap_pos[number, :2] = x, y
            self.data.mocap_quat[number] = math.cos(heading / 2), 0, 0, math.sin(heading / 2)

    def _wheel_angles(self):
        """Return the mean angle of the wheels of the left and of the right, rad."""
        angles = self.data.qpos[7:]
        return np.array([angles[wheels].mean() for wheels in self.sides])

    def contact_places(self):
        """Return the places where the body touches things, m."""
        contact = self.data.contact
        return contact.pos[self._meets()]

    def _meets(self):
        """Return of each contact whether the robot touches a thing in it."""
        contact = self.data.contact
        return self.is_thing[contact.geom].any(axis=1) & (contact.dist < 0)

    def is_stalled(self):
        """Return whether it touches something and moves at less than half of the speeds that the wheels have."""
        ahead, _, turn = self.twist()
        wanted = self.motors.speeds
        is_slow = abs(ahead) <= abs(wanted[0]) / 2 + AT_REST and abs(turn) <= abs(wanted[1]) / 2 + AT_REST
        return self.contact and is_slow and wanted != (0.0, 0.0)

    def _count_contacts(self):
        if self._meets().any():
            self.collisions += not self.contact
            self.contact, self.min_clearance = True, min(self.min_clearance, 0.0)
        elif self.contact and self.clearance() > APART:
            self.contact = False

    def pose(self):
        """Return the place, m, and the heading, rad."""
        x, y = self.data.qpos[:2]
        w, i, j, k = self.data.qpos[3:7]
        return float(x), float(y), math.atan2(2 * (w * k + i * j), 1 - 2 * (j * j + k * k))

    def twist(self):
        """Return the speeds ahead and to the left, m/s, and of the turn, rad/s."""
        _, _, heading = self.pose()
        (east, north), cos, sin = self.data.qvel[:2], math.cos(heading), math.sin(heading)
        return cos * east + sin * north, cos * north - sin * east, float(self.data.qvel[5])

    def lean(self):
        """Return the angle between the robot's axis up and the vertical, rad."""
        return math.acos(min(1.0, self.data.body("robot").xmat[8]))

    def clearance(self):
        """Return the gap between the body and the nearest thing, m."""
        data, model = self.data, self.model
        gaps = np.linalg.norm(data.geom_xpos[self.things, :2] - data.geom_xpos[self.body, :2], axis=1)
        gaps -= model.geom_rbound[self.things] + model.geom_rbound[self.body]
        nearest = math.inf
        for number in np.argsort(gaps):
            if gaps[number] >= nearest:
                break
            limit = min(nearest, 100.0)
            gap = mujoco.mj_geomDistance(model, data, self.body, int(self.things[number]), limit, None)
            nearest = min(nearest, gap) if gap < limit else nearest
        self.min_clearance = min(self.min_clearance, nearest)
        return nearest
