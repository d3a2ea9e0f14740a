"""Reads a recording with the libraries of MCAP and ROS 2, which know nothing of jde.

    read_mcap.py RECORDING NUMBERS

Decodes every message by the definition that the recording holds, and compares all laser beams and
odometry with NUMBERS, what the Rust example `numbers` printed of the same recording. Fails if anything differs.
"""

import json
import math
import sys
from collections import Counter

from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory


def numbers(topic_type, message):
    """The numbers of a message as the Rust example prints them; none of other types."""
    if topic_type == "sensor_msgs/msg/LaserScan":
        return list(message.ranges)
    if topic_type == "nav_msgs/msg/Odometry":
        place, twist = message.pose.pose.position, message.twist.twist
        return [place.x, place.y, twist.linear.x, twist.angular.z]
    return None


def main(recording, expected):
    with open(expected, encoding="utf-8") as lines:
        expected = [json.loads(line) for line in lines]
    read, decoded = [], Counter()
    with open(recording, "rb") as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
        summary = reader.get_summary()
        for schema, channel, message, value in reader.iter_decoded_messages():
            decoded[channel.id] += 1
            found = numbers(schema.name, value)
            if found is not None:
                read.append((channel.topic, message.log_time, found))

    counts = summary.statistics.channel_message_counts
    for channel in summary.channels.values():
        assert decoded[channel.id] == counts.get(channel.id, 0), channel.topic
    assert sum(decoded.values()) > 0, "the recording is empty"

    order = lambda one: (one[1], one[0])
    wanted = [(one["topic"], one["log_time"], one["numbers"]) for one in expected]
    assert len(read) == len(wanted) > 0, f"{len(read)} read, {len(wanted)} expected"
    for (topic, time, found), (topic_wanted, time_wanted, numbers_wanted) in zip(
        sorted(read, key=order), sorted(wanted, key=order)
    ):
        found = [number if math.isfinite(number) else None for number in found]
        assert (topic, time) == (topic_wanted, time_wanted), f"{topic} at {time}"
        assert found == numbers_wanted, f"{topic} at {time}: {found} is not {numbers_wanted}"
    print(f"{sum(decoded.values())} messages of {len(summary.channels)} topics decoded, {len(read)} compared")


main(*sys.argv[1:])
