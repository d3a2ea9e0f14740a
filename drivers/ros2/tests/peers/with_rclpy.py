"""The ROS 2 of the peers by rclpy over rmw_zenoh_cpp: ROS 2 itself, which must be sourced."""

import array
import ctypes
import os
import signal
import subprocess
import sys
import threading

import numpy
import rclpy
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from rosidl_runtime_py.utilities import get_message

# Those that jde publishes for each value; the others have ROS 2's default, reliable and the newest ten.
SENSORS = {"/scan", "/odom", "/image", "/camera_info", "/sonar", "/battery_state"}
node = spinner = None


def connect(port):
    """Starts the node of this program at its first use."""
    global node, spinner
    if node is None:
        os.environ.update(environment(port))
        rclpy.init()
        node = rclpy.create_node("peer")
        executor = SingleThreadedExecutor()
        executor.add_node(node)

        def spin():
            try:
                executor.spin()
            except ExternalShutdownException:
                pass

        spinner = threading.Thread(target=spin)
        spinner.start()
    return node


def environment(port):
    """Returns the variables by which programs of ROS 2 meet at this router only."""
    endpoint = f'["tcp/127.0.0.1:{port}"]'
    return {
        "RMW_IMPLEMENTATION": "rmw_zenoh_cpp",
        "ROS_DOMAIN_ID": "0",
        "ZENOH_CONFIG_OVERRIDE": f"connect/endpoints={endpoint}",
    }


def profile(topic):
    if topic == "/tf_static":
        return QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    return qos_profile_sensor_data if topic in SENSORS else 10


def use(_types):
    """ROS 2 has the definitions of its types."""


def make(kind, **fields):
    """Returns a message."""
    for name, value in fields.items():
        if isinstance(value, numpy.ndarray) and value.dtype == numpy.float32:
            fields[name] = array.array("f", value.tobytes())
    return get_message(kind)(**fields)


def subscribe(topic, kind, port, receive):
    """Calls `receive` with each message of a topic."""
    connect(port).create_subscription(get_message(kind), topic, receive, profile(topic))


class Publication:
    """A publication."""

    def __init__(self, topic, kind, port):
        self.kind = kind
        self.publisher = connect(port).create_publisher(get_message(kind), topic, profile(topic))

    def send(self, **fields):
        self.publisher.publish(make(self.kind, **fields))

    def send_bytes(self, message):
        self.publisher.publish(message)


def topics(port):
    """Returns the types of each topic."""
    return dict(connect(port).get_topic_names_and_types())


def publishers(topic, port):
    """Returns how many publications of a topic are known."""
    return connect(port).count_publishers(topic)


def start_router(port):
    """Starts ROS 2's router. Returns its process when it accepts connections."""
    settings = {"ZENOH_CONFIG_OVERRIDE": f'listen/endpoints=["tcp/127.0.0.1:{port}"]', "RUST_LOG": "error"}
    prefix = subprocess.run(["ros2", "pkg", "prefix", "rmw_zenoh_cpp"], capture_output=True, text=True, check=True)
    program = os.path.join(prefix.stdout.strip(), "lib/rmw_zenoh_cpp/rmw_zenohd")
    process = subprocess.Popen(
        [program],
        env=os.environ | settings,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        text=True,
        preexec_fn=end_with_parent,
    )
    for line in process.stdout:
        if "Started Zenoh router" in line:
            return process
    sys.exit(f"rmw_zenohd ended with {process.wait()}")


def end_with_parent():
    """Ends this process when its parent has ended, however that was."""
    set_parent_death_signal = 1
    ctypes.CDLL(None).prctl(set_parent_death_signal, signal.SIGTERM)


def router(port):
    """Runs ROS 2's router until standard input ends."""
    process = start_router(port)
    print("ready", flush=True)
    sys.stdin.read()
    process.terminate()
    process.wait()


def close():
    """Ends the node."""
    rclpy.try_shutdown()
    if spinner:
        spinner.join()
