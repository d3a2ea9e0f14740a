"""The ROS 2 of the peers by zenoh_ros2_sdk, which does not depend on jde: it makes keys and CDR itself, with the definitions of ROS 2
Jazzy from rosbags, and identifies types by hashes that it computes."""

import socket
import sys
import tempfile
from pathlib import Path

import zenoh
import zenoh.ext
from rosbags.typesys import Stores, get_typestore
from zenoh_ros2_sdk import ROS2Publisher, ROS2Subscriber
from zenoh_ros2_sdk.discovery import get_topic_names_and_types
from zenoh_ros2_sdk.message_registry import get_registry
from zenoh_ros2_sdk.session import ZenohSession

JAZZY = get_typestore(Stores.ROS2_JAZZY)
# Subscriptions that end when they are dropped.
LATCHED = []


def use(types):
    """Writes the definitions of these types and of their parts to a folder that the SDK reads."""
    folder = Path(tempfile.mkdtemp(prefix="ros2-definitions-"))
    separator = "=" * 80 + "\n"
    for name in types:
        text, _ = JAZZY.generate_msgdef(name, ros_version=2)
        own, *parts = text.split(separator)
        texts = {name: own}
        for part in parts:
            title, _, body = part.partition("\n")
            texts[title.removeprefix("MSG: ").strip()] = body
        for part_name, body in texts.items():
            package, *_, kind = part_name.split("/")
            file = folder / package / "msg" / f"{kind}.msg"
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(body)
    get_registry(str(folder))


def make(kind, **fields):
    """Returns a message; all its fields are stated."""
    return JAZZY.types[kind](**fields)


def subscribe(topic, kind, port, receive):
    """Calls `receive` with each message of a topic."""
    if topic == "/tf_static":
        subscribe_latched(topic, kind, receive)
    else:
        ROS2Subscriber(topic, kind, receive, domain_id=0, router_port=port, node_name="peer")


def subscribe_latched(topic, kind, receive):
    """The same with the messages that publications keep for late subscribers, which the SDK does not ask for."""
    subscriber = zenoh.ext.declare_advanced_subscriber(
        ZenohSession.get_instance().session,
        f"0{topic}/{kind.replace('/msg/', '::msg::dds_::')}_/{JAZZY.hash_rihs01(kind)}",
        lambda sample: receive(JAZZY.deserialize_cdr(bytes(sample.payload), kind)),
        history=zenoh.ext.HistoryConfig(detect_late_publishers=True, max_samples=100),
    )
    LATCHED.append(subscriber)


class Publication:
    """A publication."""

    def __init__(self, topic, kind, port):
        self.publisher = ROS2Publisher(topic, kind, domain_id=0, router_port=port, node_name="peer")

    def send(self, **fields):
        self.publisher.publish(**fields)

    def send_bytes(self, message):
        ZenohSession.get_instance().session.put(str(self.publisher.keyexpr), message)


def topics(port):
    """Returns the types of each topic."""
    return dict(get_topic_names_and_types(domain_id=0, router_port=port, timeout=2.0))


def router(port):
    """Runs a router like rmw_zenohd until standard input ends."""
    config = zenoh.Config()
    for key, value in {
        "mode": '"router"',
        "listen/endpoints": f'["tcp/127.0.0.1:{port}"]',
        "scouting/multicast/enabled": "false",
    }.items():
        config.insert_json5(key, value)
    with zenoh.open(config):
        print("ready", flush=True)
        sys.stdin.read()


def close():
    """Ends the threads of an open session, which would prevent the program from ending."""
    ZenohSession.get_instance().close()
