"""Decodes every message of a recording with two libraries for ROS 2, which know nothing of jde.

    read_all.py RECORDING DECISIONS TOPIC...

Fails if a channel is not decoded completely, if one of the topics is missing, or if the selections differ from the lines of
DECISIONS, the file of `jde run --decisions`.
"""

import json
import math
import sys
from collections import Counter
from pathlib import Path

from mcap.reader import make_reader
from mcap_ros2.reader import read_ros2_messages
from rosbags.highlevel import AnyReader


def seconds(stamp):
    return (stamp.sec * 10**9 + stamp.nanosec) / 1e9


def finite(number):
    return number if math.isfinite(number) else None


def line(decision):
    """A selection as `--decisions` prints it."""
    candidates = [
        {"name": each.name, "state": each.state, "ready": each.ready, "urgency": finite(each.urgency)}
        for each in decision.candidates
    ]
    line = {
        "number": decision.number,
        "time_s": seconds(decision.stamp),
        "group": decision.group,
        "case": decision.case_name,
        "candidates": candidates,
        "before": decision.before or None,
        "choice": decision.choice or None,
        "decider": decision.decider,
        "reason": decision.reason,
        "cause": decision.cause,
        "changed": decision.changed,
    }
    if math.isfinite(decision.takeover):
        line["takeover_us"] = round(decision.takeover * 1e9) / 1e3
    return line


def main(recording, decisions, *topics):
    with open(recording, "rb") as file:
        summary = make_reader(file, validate_crcs=True).get_summary()
    counts = summary.statistics.channel_message_counts
    expected = Counter({c.topic: counts[c.id] for c in summary.channels.values() if counts.get(c.id)})

    decoded, lines = Counter(), []
    for message in read_ros2_messages(recording):
        decoded[message.channel.topic] += 1
        if message.channel.topic == "/jde/decisions":
            lines.append(line(message.ros_msg))
    assert decoded == expected, f"mcap_ros2 decodes {decoded}, not {expected}"
    for topic in topics:
        assert decoded[topic] > 0, f"{recording} has no {topic}"
    with open(decisions, encoding="utf-8") as file:
        wanted = [json.loads(each) for each in file]
    assert lines == wanted, "the recorded selections are not those of --decisions"

    decoded = Counter()
    with AnyReader([Path(recording)]) as bag:
        for connection in bag.connections:
            (offered,) = connection.ext.offered_qos_profiles
            assert offered.durability.name == "TRANSIENT_LOCAL", connection.topic
        for connection, _, data in bag.messages():
            message = bag.deserialize(data, connection.msgtype)
            decoded[connection.topic] += 1
            if connection.topic == "/jde/decisions":
                assert line(message) == wanted[decoded[connection.topic] - 1], message
    assert decoded == expected, f"rosbags decodes {decoded}, not {expected}"
    print(f"{sum(decoded.values())} messages on {len(decoded)} topics decoded by two libraries, {len(lines)} selections compared")


main(*sys.argv[1:])
