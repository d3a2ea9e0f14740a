"""The ports of `sim/robot` that a robot of MuJoCo has, and the values of jde's plugins that they carry."""

from typing import Annotated

from jde import Command, Export, Modulation, Schema, command, export, field, modulation, text, u64, value
from jde import types as t


@value("jde_msgs/msg/BaseDynamics")
class BaseDynamics:
    """How a base follows its commands; the same value as in Rust."""

    acceleration: float = field(unit="m/s2")
    deceleration: float = field(unit="m/s2")
    turn_acceleration: float = field(unit="rad/s2")
    turn_deceleration: float = field(unit="rad/s2")
    lag: float = field(unit="s")


@value("jde_msgs/msg/EditCount")
class EditCount:
    """The changes of a world that a driver was requested to make; the same value as in Rust."""

    done: u64
    refused: u64
    note: Annotated[str, text(252)]


class Entry(Schema):
    """The world, and where and as what the robot enters it."""

    world: Modulation[Annotated[str, text(1024)]] = modulation("", unit="file", fixed=True)
    """The world file."""
    robot: Modulation[Annotated[str, text(60)]] = modulation("", fixed=True)
    """The robot's name in the world file; empty for the name of this schema."""
    start: Modulation[t.Start] = modulation(t.Start(), fixed=True)
    """Where it starts instead of at its start in the world file: `[{ x = 1.0, y = 2.0, theta = "90 deg" }]`."""
    edit: Modulation[Annotated[str, text(4096)]] = modulation("")
    """Changes of the world while it runs. Each write takes effect once, at the next iteration."""
    model: Modulation[Annotated[str, text(1024)]] = modulation("turtlebot4", unit="model", fixed=True)
    """The robot: a shipped one, or a robot file; it needs a table `physics`."""


class Overrides(Schema):
    """Numbers that replace those of the robot's file; a negative one keeps it."""

    laser_range: Modulation[float] = modulation(-1.0, unit="m", fixed=True)
    """Greatest range of the first laser."""
    laser_height: Modulation[float] = modulation(-1.0, unit="m", max=10.0, fixed=True)
    """How high the laser is; at 0 it sees all things."""
    laser_noise: Modulation[float] = modulation(-1.0, unit="m", fixed=True)
    """Standard deviation of the laser's ranges."""
    wheel_error: Modulation[float] = modulation(-1.0, max=0.5, fixed=True)
    """Standard deviation of each wheel's scale error, as a fraction."""
    acceleration: Modulation[float] = modulation(-1.0, unit="m/s2", fixed=True)
    """Greatest change of speed per second to which the controller leads the wheels."""
    lag: Modulation[float] = modulation(-1.0, unit="s", max=2.0, fixed=True)
    """Time constant of the controller."""
    friction: Modulation[float] = modulation(-1.0, max=5.0, fixed=True)
    """Coefficient of friction of the tyres on the floor."""
    wheels_touch: Modulation[bool] = modulation(False, fixed=True)
    """Whether the wheels, too, collide with things. The outline of the robot's file alone does otherwise."""


class Sensed(Schema):
    """What the robot measures, and what a simulator knows."""

    velocity_limits: Modulation[t.Twist] = modulation(t.Twist(), fixed=True)
    """Greatest speeds that any command asks of the base; 0 limits none."""
    velocity: Command[t.Twist] = command(t.Twist(), validity="500ms")
    """Speeds of the base: ahead and of the turn."""
    laser: Export[t.LaserScan] = export(validity="1s")
    """The scan of the first laser, in the laser's own frame. Its time is that of its first beam."""
    odometry: Export[t.Odometry]
    """Pose and velocity from the wheels."""
    encoders: Export[t.WheelEncoders]
    """The counts of the wheels, of each side the mean."""
    bumpers: Export[t.Bumpers]
    """Five bumpers ahead, five behind, pressed by what the body touches; and whether the wheels are blocked."""
    connection: Export[t.Connection] = export(lasting=True)
    """Always connected. Its note names the world."""
    truth: Export[t.Truth] = export(lasting=True)
    """The true state of the robot, for measurements. Collisions are contacts of MuJoCo."""
    body: Export[t.Body] = export(lasting=True)
    """The outline of the robot's file and the places of its lasers."""
    dynamics: Export[BaseDynamics] = export(lasting=True)
    """How the robot's file says that it follows its commands."""
    setpoint: Export[t.Twist]
    """What the motors are led to at present, without their lag."""
    scenery: Export[t.Scenery] = export(lasting=True)
    """The static objects of the world, published when they change; for windows."""
    movers: Export[t.Movers] = export(lasting=True)
    """The objects that move or can be moved, ten times per second; for windows."""
    edits: Export[EditCount] = export(lasting=True)
    """The changes of the world that this driver has made or refused; published when they change."""
