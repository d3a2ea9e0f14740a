"""A world and a robot of jde's files as a model of MuJoCo. It steps nothing.

The frame is that of the world file, with z up from the floor. What stands is part of the fixed world, what moves by
itself is a body without dynamics ("mocap"), and the robot is one free body with its wheels on hinges.
"""

import math
from xml.etree import ElementTree

# Groups of geoms, by which rays choose what they meet.
FLOOR, THINGS, ROBOT = 1, 2, 3
# Bits of what collides with what: the floor and the things; the robot's parts state which of both they meet.
ON_FLOOR, ON_THINGS = 1, 2
#: A wall of jde has no thickness; here it has this half one, m.
WALL_HALF_THICKNESS = 0.005
#: The gap between the floor and the body of a robot, m: an estimate, less than any threshold that robots cross.
GROUND_CLEARANCE = 0.03
#: The share of a robot's mass in each of its wheels: 0.477 kg of 17 kg of a Jackal.
WHEEL_SHARE = 0.028
#: Friction of a caster and of the body on what they touch: estimates of a roller and of smooth plastics.
CASTER_FRICTION, BODY_FRICTION = 0.02, 0.3
#: The radius of a caster, m.
CASTER_RADIUS = 0.015
#: The inertia of motors and gears as the wheels feel it, as a share of that of the robot: an estimate.
ARMATURE_SHARE = 0.2
#: The contact of tyres, with the time constant in s and the softness of MuJoCo: rubber yields, and does not bounce.
TYRE = {"solref": "0.01 1", "solimp": "0.2 0.2 0.001"}


def numbers(*values):
    """Return numbers as MuJoCo reads them."""
    return " ".join(f"{value:.9g}" for value in values)


def yaw(angle):
    """Return the quaternion of a turn about z, rad."""
    return numbers(math.cos(angle / 2), 0, 0, math.sin(angle / 2))


def build(things, moving, robot, wheels_touch):
    """Return the model as XML: what stands, what moves by itself, and the robot at the origin."""
    root = ElementTree.Element("mujoco")
    ElementTree.SubElement(root, "compiler", angle="radian", inertiafromgeom="false")
    # Elliptic cones and this ratio keep tyres from creeping where they do not slide.
    ElementTree.SubElement(root, "option", timestep="0.002", integrator="implicitfast", cone="elliptic", impratio="100")
    ElementTree.SubElement(root, "size", memory="64M")
    ElementTree.SubElement(root, "asset")
    world = ElementTree.SubElement(root, "worldbody")
    ElementTree.SubElement(
        world,
        "geom",
        name="floor",
        type="plane",
        size="0 0 1",
        group=str(FLOOR),
        contype=str(ON_FLOOR),
        conaffinity="0",
    )
    for number, thing in enumerate(things):
        _thing(world, f"thing {number}", thing, thing["pose"])
    for number, thing in enumerate(moving):
        x, y, heading = thing["pose"]
        body = ElementTree.SubElement(
            world, "body", name=f"moving {number}", mocap="true", pos=numbers(x, y, 0), quat=yaw(heading)
        )
        _thing(body, f"mover {number}", thing, (0, 0, 0))
    _robot(root, world, robot, wheels_touch)
    return ElementTree.tostring(root, encoding="unicode")


def _thing(parent, name, thing, pose):
    (x, y, heading), (length, width), height = pose, thing["size"], thing["height"]
    shape = {"type": "box", "size": numbers(length / 2, max(width / 2, WALL_HALF_THICKNESS), height / 2)}
    if thing["form"] == "circle":
        shape = {"type": "cylinder", "size": numbers(length / 2, height / 2)}
    ElementTree.SubElement(
        parent,
        "geom",
        name=name,
        pos=numbers(x, y, height / 2),
        quat=yaw(heading),
        group=str(THINGS),
        contype=str(ON_THINGS),
        conaffinity="0",
        rgba=numbers(*(part / 255 for part in thing["color"]), 1),
        **shape,
    )


def _robot(root, world, robot, wheels_touch):
    physics = robot["physics"]
    mass, (x, y, z) = physics["mass"], physics["center"]
    wheel_mass = WHEEL_SHARE * mass
    chassis = mass - wheel_mass * len(physics["wheels"])
    low, high = extent(robot)
    sides = high[0] - low[0], high[1] - low[1], physics["height"] - GROUND_CLEARANCE
    body = ElementTree.SubElement(world, "body", name="robot")
    ElementTree.SubElement(body, "freejoint", name="base")
    inertia = [chassis / 12 * (sum(side * side for side in sides) - own * own) for own in sides]
    ElementTree.SubElement(body, "inertial", pos=numbers(x, y, z), mass=numbers(chassis), diaginertia=numbers(*inertia))
    part = {"group": str(ROBOT), "contype": "0"}
    half = (physics["height"] - GROUND_CLEARANCE) / 2
    shape = {
        "type": "cylinder",
        "size": numbers(robot["radius"] or 1, half),
        "pos": numbers(0, 0, GROUND_CLEARANCE + half),
    }
    if robot["radius"] is None:
        corners = [
            number for x, y in robot["corners"] for z in (GROUND_CLEARANCE, physics["height"]) for number in (x, y, z)
        ]
        ElementTree.SubElement(root.find("asset"), "mesh", name="body", vertex=numbers(*corners), inertia="convex")
        shape = {"type": "mesh", "mesh": "body"}
    ElementTree.SubElement(
        body,
        "geom",
        name="body",
        conaffinity=str(ON_FLOOR | ON_THINGS),
        friction=numbers(BODY_FRICTION, 0.005, 0.0001),
        **shape,
        **part,
    )
    for number, (x, y) in enumerate(physics["casters"]):
        ElementTree.SubElement(
            body,
            "geom",
            name=f"caster {number}",
            type="sphere",
            size=numbers(CASTER_RADIUS),
            pos=numbers(x, y, CASTER_RADIUS),
            conaffinity=str(ON_FLOOR),
            priority="1",
            friction=numbers(CASTER_FRICTION, 0.005, 0.0001),
            **part,
        )
    motors = ElementTree.SubElement(root, "actuator")
    radius, width = physics["wheel_radius"], physics["wheel_width"]
    armature = ARMATURE_SHARE * inertia_of_wheel(physics)
    across = wheel_mass * (3 * radius * radius + width * width) / 12
    for number, (x, y) in enumerate(physics["wheels"]):
        wheel = ElementTree.SubElement(body, "body", name=f"wheel {number}", pos=numbers(x, y, radius))
        ElementTree.SubElement(
            wheel, "joint", name=f"wheel {number}", type="hinge", axis="0 1 0", armature=numbers(armature)
        )
        ElementTree.SubElement(
            wheel,
            "inertial",
            pos="0 0 0",
            mass=numbers(wheel_mass),
            diaginertia=numbers(across, wheel_mass * radius * radius / 2, across),
        )
        ElementTree.SubElement(
            wheel,
            "geom",
            name=f"wheel {number}",
            # Rounded, as tyres are: an edge would be a second line of contact.
            type="ellipsoid",
            size=numbers(radius, radius, width / 2),
            quat=numbers(math.sqrt(0.5), math.sqrt(0.5), 0, 0),
            conaffinity=str(ON_FLOOR | (ON_THINGS if wheels_touch else 0)),
            priority="1",
            friction=numbers(physics["friction"], 0.005, 0.0001),
            **TYRE,
            **part,
        )
        ElementTree.SubElement(motors, "motor", joint=f"wheel {number}")


def inertia_of_wheel(physics):
    """Return the inertia of the robot's mass as each of its wheels feels it, kg m²."""
    return physics["mass"] * physics["wheel_radius"] ** 2 / len(physics["wheels"])


def sides_of(robot):
    """Return the numbers of the left wheels, and those of the right ones."""
    wheels = list(enumerate(robot["physics"]["wheels"]))
    return [number for number, (_, y) in wheels if y > 0], [number for number, (_, y) in wheels if y < 0]


def extent(robot):
    """Return the corners of the smallest box that contains a robot, least first."""
    radius, corners = robot["radius"], robot["corners"]
    if radius is not None:
        return (-radius, -radius), (radius, radius)
    return tuple(map(min, zip(*corners))), tuple(map(max, zip(*corners)))
