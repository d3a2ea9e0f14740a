"""A ROS 2 program written elsewhere: it speaks through zenoh_ros2_sdk, which knows nothing of jde, with the definitions of ROS 2
Jazzy that rosbags brings along; types are told apart by hashes that it computes itself.

    ros2_peer.py router             a router of Zenoh, as ROS 2's rmw_zenohd is one; prints its port, ends with its standard input
    ros2_peer.py drive PORT         watches a robot of ours, drives it by /cmd_vel and looks whether the numbers fit
    ros2_peer.py serve PORT         is a robot itself: /scan, /odom and /battery_state, and it obeys /cmd_vel; ends with its input

It waits for what is to happen and fails, in words, if that has not happened after LIMIT seconds.
"""

import math
import socket
import sys
import tempfile
import threading
import time
from pathlib import Path

import numpy
import zenoh
from rosbags.typesys import Stores, get_typestore
from zenoh_ros2_sdk import ROS2Publisher, ROS2Subscriber
from zenoh_ros2_sdk.discovery import get_topic_names_and_types
from zenoh_ros2_sdk.message_registry import get_registry
from zenoh_ros2_sdk.session import ZenohSession

LIMIT = 30.0
JAZZY = get_typestore(Stores.ROS2_JAZZY)
TYPES = {
    "/scan": "sensor_msgs/msg/LaserScan",
    "/odom": "nav_msgs/msg/Odometry",
    "/image": "sensor_msgs/msg/Image",
    "/sonar": "sensor_msgs/msg/Range",
    "/battery_state": "sensor_msgs/msg/BatteryState",
    "/tf": "tf2_msgs/msg/TFMessage",
    "/cmd_vel": "geometry_msgs/msg/Twist",
}


def definitions(types):
    """Puts the definitions of these types, and of all that they are made of, where the SDK looks for them."""
    folder = Path(tempfile.mkdtemp(prefix="ros2-definitions-"))
    rule = "=" * 80 + "\n"
    for name in types:
        text, _ = JAZZY.generate_msgdef(name, ros_version=2)
        own, *parts = text.split(rule)
        pieces = {name: own}
        for part in parts:
            title, _, body = part.partition("\n")
            pieces[title.removeprefix("MSG: ").strip()] = body
        for piece, body in pieces.items():
            package, *_, kind = piece.split("/")
            file = folder / package / "msg" / f"{kind}.msg"
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(body)
    get_registry(str(folder))


def until(what, good):
    """Waits until something is so; gives it."""
    end = time.monotonic() + LIMIT
    while time.monotonic() < end:
        answer = good()
        if answer:
            return answer
        time.sleep(0.01)
    sys.exit(f"after {LIMIT:.0f} s still not: {what}")


def check(fact, words):
    if not fact:
        sys.exit(f"wrong: {words}")


def yaw(rotation):
    return math.atan2(
        2 * (rotation.w * rotation.z + rotation.x * rotation.y),
        1 - 2 * (rotation.y**2 + rotation.z**2),
    )


def seconds(stamp):
    return stamp.sec + stamp.nanosec * 1e-9


class Ear:
    """The newest message of a topic, and how many came."""

    def __init__(self, topic, port):
        self.newest, self.count, self.frames = None, 0, set()
        self.of = ROS2Subscriber(
            topic, TYPES[topic], self.hear, domain_id=0, router_port=port, node_name="peer"
        )

    def hear(self, message):
        self.newest = message
        self.count += 1
        if hasattr(message, "header"):
            self.frames.add(message.header.frame_id)


class Mouth:
    """A publication."""

    def __init__(self, topic, port):
        self.of = ROS2Publisher(topic, TYPES[topic], domain_id=0, router_port=port, node_name="peer")

    def twist(self, linear, angular):
        vector, twist = JAZZY.types["geometry_msgs/msg/Vector3"], self.of
        twist.publish(linear=vector(float(linear), 0.0, 0.0), angular=vector(0.0, 0.0, float(angular)))


def router():
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    config = zenoh.Config()
    for key, value in {
        "mode": '"router"',
        "listen/endpoints": f'["tcp/127.0.0.1:{port}"]',
        "scouting/multicast/enabled": "false",
    }.items():
        config.insert_json5(key, value)
    with zenoh.open(config):
        print(port, flush=True)
        sys.stdin.read()


def drive(port):
    definitions(TYPES.values())
    ears = {topic: Ear(topic, port) for topic in TYPES if topic != "/cmd_vel"}
    for topic, ear in ears.items():
        until(f"{topic} is heard", lambda ear=ear: ear.count > 2)
    scan, odom, image = (ears[topic] for topic in ("/scan", "/odom", "/image"))
    listed = dict(get_topic_names_and_types(domain_id=0, router_port=port, timeout=2.0))
    for topic, kind in TYPES.items():
        check(listed.get(topic) == [kind], f"{topic} is listed as {listed.get(topic)}, not {kind}")

    first = scan.newest
    check(len(first.ranges) == 180, f"a scan of {len(first.ranges)} beams")
    check(abs(first.angle_min + math.pi / 2) < 1e-6, f"a scan from {first.angle_min}")
    check(abs(first.angle_increment - math.pi / 180) < 1e-6, f"beams {first.angle_increment} apart")
    last = first.angle_min + 179 * first.angle_increment
    check(abs(first.angle_max - last) < 1e-5, f"a scan to {first.angle_max}, not {last}")
    check(first.header.frame_id == "laser", f"a scan in {first.header.frame_id}")
    near = [r for r in first.ranges if math.isfinite(r)]
    check(near and all(first.range_min <= r <= first.range_max for r in near), "ranges beyond limits")
    late = time.time() - seconds(scan.newest.header.stamp)
    check(-0.1 < late < 2.0, f"a scan that is {late} s old by the wall's clock")
    check(image.newest.encoding == "rgb8", f"pixels of {image.newest.encoding}")
    shape = (image.newest.height, image.newest.width, 3)
    pixels = numpy.asarray(image.newest.data).reshape(shape)
    check(shape == (240, 320, 3) and pixels.std() > 5, f"a picture of {shape} that shows nothing")
    check(11 < ears["/battery_state"].newest.voltage < 15, "a battery of another kind")
    until("all sonars are heard", lambda: len(ears["/sonar"].frames) == 16)
    steps = {step.child_frame_id: step for step in ears["/tf"].newest.transforms}
    check(steps["base_link"].header.frame_id == "odom", "the base is not in odom")
    check(abs(steps["laser"].transform.translation.x - 0.018) < 1e-9, "the laser is elsewhere")
    check("sonar_15" in steps, "sonars have no frame")

    begin, ahead = odom.newest.pose.pose, first.ranges[90]
    mouth = Mouth("/cmd_vel", port)

    def far():
        place = odom.newest.pose.pose.position
        return math.hypot(place.x - begin.position.x, place.y - begin.position.y)

    def obey(linear, angular, what, good):
        def turn():
            mouth.twist(linear, angular)
            time.sleep(0.05)
            return good()

        until(what, turn)

    obey(0.3, 0.0, "it has gone half a metre", lambda: far() > 0.5)
    until("it stands again, as nobody tells it to go", lambda: abs(odom.newest.twist.twist.linear.x) < 1e-6)
    way, seen = far(), ahead - scan.newest.ranges[90]
    check(0.5 < way < 1.0, f"it went {way} m")
    check(abs(way - seen) < 0.05, f"it went {way} m by its wheels and {seen} m by its laser")
    heading = yaw(odom.newest.pose.pose.orientation)
    turned = lambda: math.remainder(yaw(odom.newest.pose.pose.orientation) - heading, math.tau)
    obey(0.0, 0.5, "it has turned left by half a radian", lambda: turned() > 0.5)
    until("it stands again", lambda: abs(odom.newest.twist.twist.angular.z) < 1e-6)

    # What no program of ROS 2 would send does no harm, and who sends it does not drive.
    place, key = far(), str(mouth.of.keyexpr)
    for garbage in (b"", b"\0", b"\0\1\0\0" + b"\xff" * 47, b"\0\1\0\0" + b"\xff" * 48, b"x" * 100_000):
        ZenohSession.get_instance().session.put(key, garbage)
    before = odom.count
    until("it goes on", lambda: odom.count > before + 20)
    check(abs(far() - place) < 0.01, "garbage drives it")
    obey(0.2, 0.0, "it obeys again", lambda: odom.newest.twist.twist.linear.x > 0.15)
    print(f"drove it {way:.2f} m by {scan.count} scans, {odom.count} odometries and {image.count} pictures")


class Robot:
    """A disc in a room of 8 by 6 m, whose middle is where it starts, with a laser all around and a pillar ahead."""

    HALF = (4.0, 3.0)
    PILLAR = (1.1, 0.4, 0.12)
    BEAMS = 1440

    def __init__(self):
        self.x = self.y = self.heading = self.linear = self.angular = self.way = 0.0
        self.told = -math.inf
        self.orders = 0

    def obey(self, twist):
        self.linear, self.angular = twist.linear.x, twist.angular.z
        self.told = time.monotonic()
        self.orders += 1

    def step(self, dt):
        if time.monotonic() - self.told > 0.5:
            self.linear = self.angular = 0.0
        self.x += self.linear * math.cos(self.heading) * dt
        self.y += self.linear * math.sin(self.heading) * dt
        self.heading += self.angular * dt
        self.way += abs(self.linear) * dt
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
        # A beam along a wall meets it nowhere, which is no number.
        return numpy.fmin(numpy.fmin(to_x, to_y), to_pillar).astype(numpy.float32)


def serve(port):
    definitions(TYPES.values())
    types, robot = JAZZY.types, Robot()
    scan, odom, battery = (Mouth(topic, port).of for topic in ("/scan", "/odom", "/battery_state"))
    ROS2Subscriber(
        "/cmd_vel", TYPES["/cmd_vel"], robot.obey, domain_id=0, router_port=port, node_name="peer"
    )
    over = threading.Event()
    threading.Thread(target=lambda: (sys.stdin.read(), over.set()), daemon=True).start()
    print("ready", flush=True)
    vector, point = types["geometry_msgs/msg/Vector3"], types["geometry_msgs/msg/Point"]
    none, turn = numpy.zeros(36), 0
    while not over.wait(0.05):
        robot.step(0.05)
        turn += 1
        now = time.time_ns()
        stamp = types["builtin_interfaces/msg/Time"](now // 10**9, now % 10**9)
        header = lambda frame: types["std_msgs/msg/Header"](stamp, frame)
        rotation = types["geometry_msgs/msg/Quaternion"](
            0.0, 0.0, math.sin(robot.heading / 2), math.cos(robot.heading / 2)
        )
        pose = types["geometry_msgs/msg/Pose"](point(robot.x, robot.y, 0.0), rotation)
        twist = types["geometry_msgs/msg/Twist"](
            vector(robot.linear, 0.0, 0.0), vector(0.0, 0.0, robot.angular)
        )
        odom.publish(
            header=header("odom"),
            child_frame_id="base_footprint",
            pose=types["geometry_msgs/msg/PoseWithCovariance"](pose, none),
            twist=types["geometry_msgs/msg/TwistWithCovariance"](twist, none),
        )
        scan.publish(
            header=header("base_scan"),
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
    check(robot.linear == 0.0 and robot.angular == 0.0, "it was left driving")
    check(robot.orders > 100, f"it was told {robot.orders} velocities")
    print(f"was driven {robot.way:.2f} m by {robot.orders} velocities, to {robot.x:.2f}, {robot.y:.2f}", flush=True)


if __name__ == "__main__":
    role = sys.argv[1]
    if role == "router":
        router()
    else:
        try:
            {"drive": drive, "serve": serve}[role](int(sys.argv[2]))
        finally:
            # Threads of an open session would keep the program from ending.
            ZenohSession.get_instance().close()
