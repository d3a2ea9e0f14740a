"""An arm with two joints in a plane, which MuJoCo moves: a driver whose command is the speeds of the joints.

A tag is on the table, and another one wherever the hand stays at it; somebody's hand goes back and forth, and a post
stands in the way. What stands and moves is stated in the application. It opens no window.
"""

import math
from typing import Annotated

import mujoco
import numpy as np

from jde import Command, Export, Modulation, Schema, array, command, export, modulation, u64
from jde import types as t

#: The names of the joints, from the table to the hand.
JOINTS = ["shoulder", "elbow"]
#: Radius of a link and of the intruder, height of the plane above the table, m.
LINK_RADIUS, INTRUDER_RADIUS, HEIGHT = 0.025, 0.05, 0.1
#: At this distance for this time the hand is at the tag, m and s.
AT_TAG, STAY = 0.02, 0.3
#: A contact begins when bodies touch, and ends at this gap, m.
APART = 0.003
#: The standard deviation of a place that the camera above the table measures, m: an estimate.
NOISE = 0.002
#: A step, s; masses of the links, kg; the gain of a motor, N m s/rad; the inertia of its gears, kg m²: estimates of a
#: small arm.
STEP, MASSES, GAIN, ARMATURE = 0.002, (1.0, 0.7), 8.0, 0.1

MODEL = """
<mujoco>
  <compiler angle="radian"/>
  <option timestep="{step}" integrator="implicitfast"/>
  <worldbody>
    <geom name="post" type="box" pos="{post_x} {post_y} {height}" quat="{post_w} 0 0 {post_k}"
          size="{half_length} {half_width} {height}"/>
    <body name="intruder" mocap="true" pos="9 9 {height}"><geom name="intruder" type="sphere" size="{intruder}"/></body>
    <body name="upper arm" pos="0 0 {height}">
      <joint name="shoulder" axis="0 0 1" armature="{armature}"/>
      <geom type="capsule" fromto="0 0 0 {upper} 0 0" size="{radius}" mass="{upper_mass}"/>
      <body name="forearm" pos="{upper} 0 0">
        <joint name="elbow" axis="0 0 1" armature="{armature}"/>
        <geom type="capsule" fromto="0 0 0 {lower} 0 0" size="{radius}" mass="{lower_mass}"/>
        <site name="hand" pos="{lower} 0 0"/>
      </body>
    </body>
  </worldbody>
  <contact><exclude body1="upper arm" body2="forearm"/></contact>
  <actuator>
    <velocity joint="shoulder" kv="{gain}"/>
    <velocity joint="elbow" kv="{gain}"/>
  </actuator>
</mujoco>
"""


class Arm(Schema, kind="driver", period="20ms", budget="20ms"):
    """A simulated arm with a camera above its table, in the frame of its shoulder."""

    upper_arm: Modulation[float] = modulation(0.4, unit="m", min=0.05, max=5.0, fixed=True)
    """Length from the shoulder to the elbow."""
    forearm: Modulation[float] = modulation(0.3, unit="m", min=0.05, max=5.0, fixed=True)
    """Length from the elbow to the hand."""
    start: Modulation[Annotated[list[float], array(float, 2)]] = modulation([-1.2, 1.5], unit="rad", fixed=True)
    """Angles of the joints at the start; the elbow's is 0 where the arm is stretched."""
    tags: Modulation[t.Route] = modulation(t.Route(), fixed=True)
    """Where the tag is, one place after the other."""
    intruder: Modulation[t.Route] = modulation(t.Route(), fixed=True)
    """The two places between which somebody's hand goes back and forth; none for nobody."""
    intruder_speed: Modulation[float] = modulation(0.15, unit="m/s", min=0.01, max=2.0, fixed=True)
    """How fast that hand is."""
    post: Modulation[t.Pose2D] = modulation(t.Pose2D(9.0, 9.0, 0.0), fixed=True)
    """The place of a post."""
    post_size: Modulation[Annotated[list[float], array(float, 2)]] = modulation([0.1, 0.1], unit="m", fixed=True)
    """Its length and width."""
    acceleration: Modulation[float] = modulation(4.0, unit="rad/s2", min=0.1, max=100.0, fixed=True)
    """Greatest change of a joint's speed."""
    speeds: Command[t.JointState] = command(t.JointState(), validity="200ms")
    """Speeds of the joints, with their names; without names they stand."""
    joints: Export[t.JointState]
    """Angles and speeds of the joints, and the torques of their motors."""
    tag: Export[t.PositionFix] = export(validity="200ms")
    """The place of the tag, as the camera measures it; none after the last one."""
    hand_seen: Export[t.PositionFix] = export(validity="200ms")
    """The place of somebody's hand, as the camera measures it."""
    reached: Export[u64] = export(lasting=True)
    """How many tags the hand has reached."""
    truth: Export[t.Truth] = export(lasting=True)
    """The true place of the arm's hand, its distance from the post and from somebody's hand, and contacts with them."""

    def awake(self, cx):
        """Build the arm, or go on with it."""
        if hasattr(self, "data"):
            return
        post, size = self.post, list(self.post_size)
        self.links = self.upper_arm, self.forearm
        text = MODEL.format(
            step=STEP, height=HEIGHT, post_x=post.x, post_y=post.y, post_w=math.cos(post.theta / 2),
            post_k=math.sin(post.theta / 2), half_length=size[0] / 2, half_width=size[1] / 2, intruder=INTRUDER_RADIUS,
            upper=self.upper_arm, lower=self.forearm, radius=LINK_RADIUS, upper_mass=MASSES[0], lower_mass=MASSES[1],
            armature=ARMATURE, gain=GAIN,
        )  # fmt: skip
        self.physics = mujoco.MjModel.from_xml_string(text)
        self.data = mujoco.MjData(self.physics)
        self.data.qpos[:] = list(self.start)
        self.time = round(cx.now / STEP)
        self.random = np.random.default_rng([cx.seed, 0])
        self.places = [(pose.x, pose.y) for pose in self.tags.poses]
        self.way = [np.array((pose.x, pose.y)) for pose in self.intruder.poses[:2]]
        self.count, self.since = 0, None
        self.collisions, self.contact, self.least = 0, False, math.inf
        self.foreign = {self.physics.geom(name).id for name in ("post", "intruder")}
        self.own = [geom for geom in range(self.physics.ngeom) if geom not in self.foreign]
        mujoco.mj_forward(self.physics, self.data)

    def iterate(self, cx):
        """Simulate up to now under the last command, take the new one, and publish what is sensed."""
        while (self.time + 1) * STEP <= cx.now + 1e-9:
            self._step()
        command = self.speeds
        wanted = dict(zip(command.name, command.velocity))
        self.wanted = np.array([wanted.get(name, 0.0) for name in JOINTS])
        data = self.data
        header = _header(cx.now, "shoulder")
        torques = data.actuator_force.tolist()
        self.joints.write(t.JointState(header, JOINTS, data.qpos.tolist(), data.qvel.tolist(), torques))
        hand = data.site("hand").xpos
        if self.count < len(self.places):
            self.tag.write(self._seen(header, self.places[self.count]))
        else:
            self.tag.retract()
        if len(self.way) == 2:
            self.hand_seen.write(self._seen(header, data.mocap_pos[0, :2]))
        self.reached.write(self.count)
        gap = self._gap()
        pose = t.Pose2D(hand[0], hand[1], data.qpos.sum())
        self.truth.write(t.Truth(pose, t.Twist(), gap, self.least, self.collisions))

    def sleep(self, cx):
        """Stop the motors."""
        self.wanted = np.zeros(2)

    wanted = np.zeros(2)

    def _step(self):
        data, change = self.data, self.acceleration * STEP
        data.ctrl[:] += np.clip(self.wanted - data.ctrl, -change, change)
        self.time += 1
        now = self.time * STEP
        if len(self.way) == 2:
            length = max(np.linalg.norm(self.way[1] - self.way[0]), 1e-9)
            share = self.intruder_speed * now / length % 2.0
            data.mocap_pos[0, :2] = self.way[0] + (self.way[1] - self.way[0]) * min(share, 2.0 - share)
        mujoco.mj_step(self.physics, data)
        touches = any(contact.dist < 0 and self.foreign & set(contact.geom.tolist()) for contact in data.contact)
        self.collisions += touches and not self.contact
        self.contact = touches or self.contact and self._gap() < APART
        self._count_tags(now)

    def _count_tags(self, now):
        if self.count == len(self.places):
            return
        hand = self.data.site("hand").xpos
        if math.dist(hand[:2], self.places[self.count]) > AT_TAG:
            self.since = None
        elif self.since is None:
            self.since = now
        elif now - self.since >= STAY:
            self.count, self.since = self.count + 1, None

    def _gap(self):
        """Return the least distance between the arm and what it must not touch, m."""
        pairs = [(own, other) for own in self.own for other in self.foreign]
        gap = min(mujoco.mj_geomDistance(self.physics, self.data, *pair, 9.0, None) for pair in pairs)
        self.least = min(self.least, gap)
        return gap

    def _seen(self, header, place):
        x, y = np.array(place) + NOISE * self.random.standard_normal(2)
        return t.PositionFix(header, float(x), float(y), [NOISE**2, 0.0, 0.0, NOISE**2])


def _header(time, frame):
    return t.Header(t.Time(*divmod(round(time * 1e9), 1_000_000_000)), frame)
