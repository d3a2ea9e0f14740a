"""Writes a bag as ROS 2 does, with a library that knows nothing of jde.

    write_bag.py FOLDER

A robot drives towards a wall for ten seconds: a scan at 10 Hz, odometry at 20 Hz, transforms, and notes of a type that
nobody else has. The bag is MCAP with chunks in Zstandard.
"""

import sys
from pathlib import Path

import numpy
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

STORE = get_typestore(Stores.ROS2_JAZZY)
STORE.register(get_types_from_msg("string[] names\nfloat64[] values\n", "acme_msgs/msg/Notes"))
TYPES = STORE.types
# The wall clock at the beginning, and how long after its measurement a message is recorded, ns.
START, AGE = 1_750_000_000_000_000_000, 40_000_000
# Of the robot, m/s.
SPEED = 0.25


def header(time, frame):
    stamp = TYPES["builtin_interfaces/msg/Time"](sec=time // 10**9, nanosec=time % 10**9)
    return TYPES["std_msgs/msg/Header"](stamp=stamp, frame_id=frame)


def scan(time, seconds):
    beams = 181
    ranges = numpy.full(beams, 2.8 - SPEED * seconds, numpy.float32)
    return TYPES["sensor_msgs/msg/LaserScan"](
        header=header(time, "base_scan"),
        angle_min=-1.5707964,
        angle_max=1.5707964,
        angle_increment=3.1415927 / (beams - 1),
        time_increment=0.0,
        scan_time=0.1,
        range_min=0.1,
        range_max=8.0,
        ranges=ranges,
        intensities=numpy.zeros(0, numpy.float32),
    )


def transform(seconds):
    vector = TYPES["geometry_msgs/msg/Vector3"](x=SPEED * seconds, y=0.0, z=0.0)
    turn = TYPES["geometry_msgs/msg/Quaternion"](x=0.0, y=0.0, z=0.0, w=1.0)
    return vector, turn


def odometry(time, seconds):
    vector, turn = transform(seconds)
    point = TYPES["geometry_msgs/msg/Point"](x=vector.x, y=0.0, z=0.0)
    pose = TYPES["geometry_msgs/msg/Pose"](position=point, orientation=turn)
    still = TYPES["geometry_msgs/msg/Vector3"](x=0.0, y=0.0, z=0.0)
    ahead = TYPES["geometry_msgs/msg/Vector3"](x=SPEED, y=0.0, z=0.0)
    twist = TYPES["geometry_msgs/msg/Twist"](linear=ahead, angular=still)
    unknown = numpy.zeros(36)
    return TYPES["nav_msgs/msg/Odometry"](
        header=header(time, "odom"),
        child_frame_id="base_link",
        pose=TYPES["geometry_msgs/msg/PoseWithCovariance"](pose=pose, covariance=unknown),
        twist=TYPES["geometry_msgs/msg/TwistWithCovariance"](twist=twist, covariance=unknown),
    )


def transforms(time, seconds):
    vector, turn = transform(seconds)
    inner = TYPES["geometry_msgs/msg/Transform"](translation=vector, rotation=turn)
    stamped = TYPES["geometry_msgs/msg/TransformStamped"](
        header=header(time, "odom"), child_frame_id="base_link", transform=inner
    )
    return TYPES["tf2_msgs/msg/TFMessage"](transforms=[stamped])


def notes(_, seconds):
    return TYPES["acme_msgs/msg/Notes"](names=["seconds"], values=numpy.array([seconds]))


def main(folder):
    topics = {"/scan": (scan, 2), "/odom": (odometry, 1), "/tf": (transforms, 1), "/notes": (notes, 20)}
    names = {
        "/scan": "sensor_msgs/msg/LaserScan",
        "/odom": "nav_msgs/msg/Odometry",
        "/tf": "tf2_msgs/msg/TFMessage",
        "/notes": "acme_msgs/msg/Notes",
    }
    writer = Writer(Path(folder), version=9, storage_plugin=StoragePlugin.MCAP)
    writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
    with writer as bag:
        connections = {topic: bag.add_connection(topic, name, typestore=STORE) for topic, name in names.items()}
        for step in range(201):
            seconds = step / 20
            time = START + step * 50_000_000
            for topic, (make, each) in topics.items():
                if step % each == 0:
                    data = STORE.serialize_cdr(make(time - AGE, seconds), names[topic])
                    bag.write(connections[topic], time, data)


main(*sys.argv[1:])
