"""Publishes what a robot measures at 20 Hz with rclpy: a scan, a picture of 640 by 480, an odometry and
a transform. It ends when its
standard input closes, and prints "ready" first."""

import array
import os
import signal
import sys
import threading

import rclpy
from geometry_msgs.msg import TransformStamped
from nav_msgs.msg import Odometry
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import Image, LaserScan
from tf2_msgs.msg import TFMessage

BEAMS = 720


class Sensors(Node):
    """A node with the publications of a driver."""

    def __init__(self) -> None:
        super().__init__("sensors")
        self.scans = self.create_publisher(LaserScan, "scan", qos_profile_sensor_data)
        self.images = self.create_publisher(Image, "image", qos_profile_sensor_data)
        self.poses = self.create_publisher(Odometry, "odom", qos_profile_sensor_data)
        self.transforms = self.create_publisher(TFMessage, "/tf", 100)
        self.picture = array.array("B", bytes(3 * 640 * 480))
        self.ranges = [1.0 + beam / BEAMS for beam in range(BEAMS)]
        self.timer = self.create_timer(0.05, self.publish)

    def publish(self) -> None:
        """Publishes each once."""
        stamp = self.get_clock().now().to_msg()
        scan = LaserScan(angle_min=-1.57, angle_max=1.57, angle_increment=3.14 / BEAMS, range_max=12.0)
        scan.header.stamp, scan.header.frame_id = stamp, "laser"
        scan.ranges = self.ranges
        self.scans.publish(scan)
        image = Image(height=480, width=640, step=3 * 640, encoding="rgb8")
        image.header.stamp, image.header.frame_id = stamp, "camera"
        image.data = self.picture
        self.images.publish(image)
        odometry = Odometry(child_frame_id="base_link")
        odometry.header.stamp, odometry.header.frame_id = stamp, "odom"
        self.poses.publish(odometry)
        transform = TransformStamped(child_frame_id="base_link")
        transform.header.stamp, transform.header.frame_id = stamp, "odom"
        self.transforms.publish(TFMessage(transforms=[transform]))


def main() -> None:
    """Runs the node."""
    rclpy.init()
    node = Sensors()

    def wait() -> None:
        sys.stdin.read()
        os.kill(os.getpid(), signal.SIGINT)

    threading.Thread(target=wait, daemon=True).start()
    print("ready", flush=True)
    try:
        rclpy.spin(node)
    except KeyboardInterrupt:
        pass


main()
