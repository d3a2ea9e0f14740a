"""Programs of ROS 2 for tests, which contain no code of jde. The library by which they use ROS 2 is `sdk` (with_sdk.py) or `rclpy`
(with_rclpy.py: ROS 2 itself).

    ros2_peer.py LIBRARY router PORT      a Zenoh router like ROS 2's rmw_zenohd; ends with its standard input
    ros2_peer.py LIBRARY drive PORT       receives the topics of a jde robot, drives it by /cmd_vel and checks the values
    ros2_peer.py LIBRARY arbitrate PORT   two programs, one of them with stamped velocities, and the base for which they compete
    ros2_peer.py LIBRARY serve PORT       a robot with /scan and /odom that executes /cmd_vel; ends with its input
    ros2_peer.py rclpy restart PORT       a router, a program that drives a jde robot, and what they do when the router restarts

It waits for each expected event, and fails with a message if the event has not occurred after LIMIT seconds.
"""

import importlib
import math
import sys
import threading
import time

import numpy

LIMIT = 30.0
TYPES = {
    "/scan": "sensor_msgs/msg/LaserScan",
    "/odom": "nav_msgs/msg/Odometry",
    "/image": "sensor_msgs/msg/Image",
    "/sonar": "sensor_msgs/msg/Range",
    "/battery_state": "sensor_msgs/msg/BatteryState",
    "/camera_info": "sensor_msgs/msg/CameraInfo",
    "/tf": "tf2_msgs/msg/TFMessage",
    "/tf_static": "tf2_msgs/msg/TFMessage",
    "/cmd_vel": "geometry_msgs/msg/Twist",
}
SOURCES = {"/teleop/cmd_vel": "geometry_msgs/msg/TwistStamped", "/nav/cmd_vel": "geometry_msgs/msg/Twist"}


def until(what, condition):
    """Waits until a condition holds and returns its value."""
    end = time.monotonic() + LIMIT
    while time.monotonic() < end:
        value = condition()
        if value:
            return value
        time.sleep(0.01)
    sys.exit(f"after {LIMIT:.0f} s not satisfied: {what}")


def check(condition, message):
    if not condition:
        sys.exit(f"wrong: {message}")


def yaw(rotation):
    return math.atan2(
        2 * (rotation.w * rotation.z + rotation.x * rotation.y),
        1 - 2 * (rotation.y**2 + rotation.z**2),
    )


def seconds(stamp):
    return stamp.sec + stamp.nanosec * 1e-9


class Subscription:
    """The newest message of a topic, and the number of messages."""

    def __init__(self, topic, port, kind=None):
        self.newest, self.count, self.frames = None, 0, set()
        library.subscribe(topic, kind or TYPES[topic], port, self.receive)

    def receive(self, message):
        self.newest = message
        self.count += 1
        if hasattr(message, "header"):
            self.frames.add(message.header.frame_id)


class Velocities:
    """A publication of velocities."""

    def __init__(self, topic, port, kind=None):
        self.is_stamped = kind == "geometry_msgs/msg/TwistStamped"
        self.publication = library.Publication(topic, kind or TYPES["/cmd_vel"], port)

    def twist(self, linear, angular):
        parts = planar(linear, angular)
        if self.is_stamped:
            twist = library.make("geometry_msgs/msg/Twist", **parts)
            parts = {"header": header(0, "base_link"), "twist": twist}
        self.publication.send(**parts)


def vector(x=0.0, y=0.0, z=0.0):
    return library.make("geometry_msgs/msg/Vector3", x=float(x), y=float(y), z=float(z))


def planar(linear, angular):
    """Returns the fields of a velocity in the plane."""
    return {"linear": vector(x=linear), "angular": vector(z=angular)}


def header(nanoseconds, frame):
    stamp = library.make("builtin_interfaces/msg/Time", sec=nanoseconds // 10**9, nanosec=nanoseconds % 10**9)
    return library.make("std_msgs/msg/Header", stamp=stamp, frame_id=frame)


def drive(port):
    library.use(TYPES.values())
    subscriptions = {topic: Subscription(topic, port) for topic in TYPES if topic != "/cmd_vel"}
    for topic, subscription in subscriptions.items():
        # What is latched comes once.
        least = 1 if topic == "/tf_static" else 3
        until(f"{topic} is received", lambda subscription=subscription, least=least: subscription.count >= least)
    scan, odom, image = (subscriptions[topic] for topic in ("/scan", "/odom", "/image"))
    listed = library.topics(port)
    for topic, kind in TYPES.items():
        check(listed.get(topic) == [kind], f"{topic} is listed as {listed.get(topic)}, not {kind}")

    first = scan.newest
    check(len(first.ranges) == 180, f"a scan of {len(first.ranges)} beams")
    check(abs(first.angle_min + math.pi / 2) < 1e-6, f"a scan from {first.angle_min}")
    check(abs(first.angle_increment - math.pi / 180) < 1e-6, f"an increment of {first.angle_increment}")
    last = first.angle_min + 179 * first.angle_increment
    check(abs(first.angle_max - last) < 1e-5, f"a scan to {first.angle_max}, not {last}")
    check(first.header.frame_id == "laser", f"a scan in {first.header.frame_id}")
    near = [r for r in first.ranges if math.isfinite(r)]
    check(near and all(first.range_min <= r <= first.range_max for r in near), "ranges beyond limits")
    age = time.time() - seconds(scan.newest.header.stamp)
    check(-0.1 < age < 2.0, f"a scan that is {age} s old by the wall clock")
    check(image.newest.encoding == "rgb8", f"pixels of {image.newest.encoding}")
    shape = (image.newest.height, image.newest.width, 3)
    pixels = numpy.asarray(image.newest.data).reshape(shape)
    check(shape == (240, 320, 3) and pixels.std() > 5, f"a picture of {shape} that shows nothing")
    info = subscriptions["/camera_info"].newest
    check((info.width, info.height) == (320, 240), f"a geometry of {info.width} x {info.height} pixels")
    focal = 160 / math.tan(0.829 / 2)
    check(abs(info.k[0] - focal) < 1e-6, f"a focal length of {info.k[0]}, not {focal}")
    check(11 < subscriptions["/battery_state"].newest.voltage < 15, "an unexpected battery voltage")
    until("all sonars are received", lambda: len(subscriptions["/sonar"].frames) == 16)
    steps = {step.child_frame_id: step for step in subscriptions["/tf"].newest.transforms}
    check(steps["base_link"].header.frame_id == "odom", "the base is not in odom")
    until("sonars have frames", lambda: len(subscriptions["/tf_static"].newest.transforms) >= 18)
    steps = {step.child_frame_id: step for step in subscriptions["/tf_static"].newest.transforms}
    check(steps["laser"].header.frame_id == "base_link", "the laser is not on the base")
    check(abs(steps["laser"].transform.translation.x - 0.018) < 1e-9, "the laser has another pose")
    check("sonar_15" in steps, "sonars have no frame")

    begin, ahead = odom.newest.pose.pose, first.ranges[90]
    cmd_vel = Velocities("/cmd_vel", port)

    def distance():
        position = odom.newest.pose.pose.position
        return math.hypot(position.x - begin.position.x, position.y - begin.position.y)

    def drive_until(linear, angular, what, condition):
        def step():
            cmd_vel.twist(linear, angular)
            time.sleep(0.05)
            return condition()

        until(what, step)

    drive_until(0.3, 0.0, "it has driven half a metre", lambda: distance() > 0.5)
    until("it stops when no velocity is sent", lambda: abs(odom.newest.twist.twist.linear.x) < 1e-6)
    travelled, seen = distance(), ahead - scan.newest.ranges[90]
    check(0.5 < travelled < 1.0, f"it drove {travelled} m")
    check(abs(travelled - seen) < 0.05, f"it drove {travelled} m by its wheels and {seen} m by its laser")
    heading = yaw(odom.newest.pose.pose.orientation)
    turned = lambda: math.remainder(yaw(odom.newest.pose.pose.orientation) - heading, math.tau)
    drive_until(0.0, 0.5, "it has turned left by half a radian", lambda: turned() > 0.5)
    until("it has stopped turning", lambda: abs(odom.newest.twist.twist.angular.z) < 1e-6)

    # Invalid messages do no harm and cause no motion.
    position = distance()
    for garbage in (b"", b"\0", b"\0\1\0\0" + b"\xff" * 47, b"\0\1\0\0" + b"\xff" * 48, b"x" * 100_000):
        cmd_vel.publication.send_bytes(garbage)
    before = odom.count
    until("it continues", lambda: odom.count > before + 20)
    check(abs(distance() - position) < 0.01, "an invalid message moved it")
    drive_until(0.2, 0.0, "it drives again", lambda: odom.newest.twist.twist.linear.x > 0.15)
    print(f"drove it {travelled:.2f} m by {scan.count} scans, {odom.count} odometries and {image.count} pictures")


def arbitrate(port):
    library.use([*TYPES.values(), *SOURCES.values()])
    base = Subscription("/cmd_vel", port)
    teleop, nav = (Velocities(topic, port, kind) for topic, kind in SOURCES.items())
    taken = []

    def until_driven(speed, sources):
        def step():
            for source, velocity in sources:
                source.twist(velocity, 0.0)
            time.sleep(0.05)
            return base.count > 0 and base.newest.linear.x == speed

        until(f"the base is driven at {speed} m/s", step)
        taken.append(speed)

    until_driven(0.2, [(nav, 0.2)])
    listed = library.topics(port)
    check(listed.get("/cmd_vel") == [TYPES["/cmd_vel"]], f"/cmd_vel is listed as {listed.get('/cmd_vel')}")
    until_driven(0.5, [(nav, 0.2), (teleop, 0.5)])
    until_driven(0.2, [(nav, 0.2)])
    until_driven(0.0, [])
    stamped = Subscription("/cmd_vel", port, SOURCES["/teleop/cmd_vel"])
    until_driven(0.4, [(teleop, 0.4)])
    until("a stamped velocity is received", lambda: stamped.count and stamped.newest.twist.linear.x == 0.4)
    age = time.time() - seconds(stamped.newest.header.stamp)
    check(-0.1 < age < LIMIT, f"a velocity that is {age} s old by the wall clock")
    print(f"the base was driven at {taken} m/s, by one of two programs at a time")


class Robot:
    """A disc in a room of 8 by 6 m, which starts in the middle, with a 360 degree laser and a pillar ahead."""

    HALF = (4.0, 3.0)
    PILLAR = (1.1, 0.4, 0.12)
    BEAMS = 1440

    def __init__(self):
        self.x = self.y = self.heading = self.linear = self.angular = self.travelled = 0.0
        self.commanded_at = -math.inf
        self.commands = 0

    def command(self, twist):
        self.linear, self.angular = twist.linear.x, twist.angular.z
        self.commanded_at = time.monotonic()
        self.commands += 1

    def step(self, dt):
        if time.monotonic() - self.commanded_at > 0.5:
            self.linear = self.angular = 0.0
        self.x += self.linear * math.cos(self.heading) * dt
        self.y += self.linear * math.sin(self.heading) * dt
        self.heading += self.angular * dt
        self.travelled += abs(self.linear) * dt
        check(abs(self.x) < 3.8 and abs(self.y) < 2.8, "it was driven into a wall")
        x, y, radius = self.PILLAR
        check(math.hypot(x - self.x, y - self.y) > radius + 0.2, "it was driven into the pillar")

    def ranges(self):
        angles = numpy.linspace(0, math.tau, self.BEAMS, endpoint=False) + self.heading
        cos, sin = numpy.cos(angles), numpy.sin(angles)
        x, y, radius = self.PILLAR
        along = (x - self.x) * cos + (y - self.y) * sin
        inside = along**2 - (x - self.x) ** 2 - (y - self.y) ** 2 + radius**2
        with numpy.errstate(divide="ignore", invalid="ignore"):
            to_x = (numpy.sign(cos) * self.HALF[0] - self.x) / cos
            to_y = (numpy.sign(sin) * self.HALF[1] - self.y) / sin
            to_pillar = numpy.where((inside > 0) & (along > 0), along - numpy.sqrt(inside), numpy.inf)
        # A beam parallel to a wall does not meet it, and gives NaN.
        return numpy.fmin(numpy.fmin(to_x, to_y), to_pillar).astype(numpy.float32)


def serve(port):
    library.use(TYPES.values())
    robot, make = Robot(), library.make
    scan, odom = (library.Publication(topic, TYPES[topic], port) for topic in ("/scan", "/odom"))
    library.subscribe("/cmd_vel", TYPES["/cmd_vel"], port, robot.command)
    ended = threading.Event()
    threading.Thread(target=lambda: (sys.stdin.read(), ended.set()), daemon=True).start()
    print("ready", flush=True)
    covariance = numpy.zeros(36)
    while not ended.wait(0.05):
        robot.step(0.05)
        now = time.time_ns()
        z, w = math.sin(robot.heading / 2), math.cos(robot.heading / 2)
        pose = make(
            "geometry_msgs/msg/Pose",
            position=make("geometry_msgs/msg/Point", x=robot.x, y=robot.y, z=0.0),
            orientation=make("geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=z, w=w),
        )
        twist = make("geometry_msgs/msg/Twist", **planar(robot.linear, robot.angular))
        odom.send(
            header=header(now, "odom"),
            child_frame_id="base_footprint",
            pose=make("geometry_msgs/msg/PoseWithCovariance", pose=pose, covariance=covariance),
            twist=make("geometry_msgs/msg/TwistWithCovariance", twist=twist, covariance=covariance),
        )
        scan.send(
            header=header(now, "base_scan"),
            angle_min=0.0,
            angle_max=math.tau * (1 - 1 / robot.BEAMS),
            angle_increment=math.tau / robot.BEAMS,
            time_increment=0.0,
            scan_time=0.05,
            range_min=0.12,
            range_max=12.0,
            ranges=robot.ranges(),
            intensities=numpy.zeros(0, numpy.float32),
        )
    check(robot.linear == 0.0 and robot.angular == 0.0, "it was still driving at the end")
    check(robot.commands > 100, f"it received {robot.commands} velocities")
    print(f"was driven {robot.travelled:.2f} m by {robot.commands} velocities, to {robot.x:.2f}, {robot.y:.2f}", flush=True)


def restart(port):
    server = library.start_router(port)
    scan, odom = (Subscription(topic, port) for topic in ("/scan", "/odom"))
    until("scans are received", lambda: scan.count > 2)
    server.terminate()
    server.wait()
    until("no publication of /scan is known", lambda: library.publishers("/scan", port) == 0)
    before = scan.count
    server = library.start_router(port)
    until("scans are received from the new router", lambda: scan.count > before + 2)
    cmd_vel = Velocities("/cmd_vel", port)

    def drives():
        cmd_vel.twist(0.2, 0.0)
        time.sleep(0.05)
        return odom.newest.twist.twist.linear.x > 0.15

    until("it drives by the new router", drives)
    server.terminate()
    server.wait()
    print("the router restarted, and the robot was driven again")


if __name__ == "__main__":
    library = importlib.import_module(f"with_{sys.argv[1]}")
    role, port = sys.argv[2], int(sys.argv[3])
    try:
        {
            "router": library.router,
            "drive": drive,
            "arbitrate": arbitrate,
            "serve": serve,
            "restart": restart,
        }[role](port)
    finally:
        library.close()
