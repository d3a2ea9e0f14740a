"""Reads the panels of a recording with the libraries of MCAP and ROS 2 and one for CBOR, which know nothing of jde.

    read_panels.py RECORDING SCHEMA...

Fails unless every schema's panel is there, every message is a list of widgets or a reason, and every widget says what it is.
"""

import sys
from collections import Counter

import cbor2
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

WIDGETS = {
    "text", "value", "button", "toggle", "slider", "choice", "image", "plot", "table", "row", "group", "canvas", "scene",
}


def widgets(items):
    """The kinds of all widgets, those within others included."""
    for item in items:
        assert len(item) == 1, item
        kind, fields = next(iter(item.items()))
        assert kind in WIDGETS, kind
        yield kind
        yield from widgets(fields.get("items", []))


def main(recording, *schemas):
    lists, kinds = Counter(), Counter()
    with open(recording, "rb") as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
        for schema, channel, message, panel in reader.iter_decoded_messages():
            if schema.name != "jde_msgs/msg/Panel":
                continue
            shown = cbor2.loads(panel.cbor)
            if isinstance(shown, str):
                continue
            assert shown["time"] <= message.log_time, channel.topic
            kinds.update(widgets(shown["items"]))
            lists[channel.metadata["panel"]] += 1
    for schema in schemas:
        assert lists[schema] > 0, f"{schema} has no panel in {recording}"
    print(f"{sum(lists.values())} panels of {', '.join(sorted(lists))} with {sum(kinds.values())} widgets read")


main(*sys.argv[1:])
