"""A network between this machine and a network namespace that loses packets: two TUN devices, and a loop that passes on or
drops what they send. It needs root. A line on the standard input states the loss in percent; it ends, and removes the
namespace, when the standard input closes. It prints "ready" first.

lossy.py NAMESPACE LOSS: this machine is 10.77.63.1 there, and the namespace 10.77.63.2.
"""

import fcntl
import os
import random
import select
import struct
import subprocess
import sys

TUNSETIFF = 0x400454CA
IFF_TUN = 0x0001
IFF_NO_PI = 0x1000


def tun(name: str) -> int:
    """Returns the file of a new TUN device."""
    device = os.open("/dev/net/tun", os.O_RDWR)
    fcntl.ioctl(device, TUNSETIFF, struct.pack("16sH", name.encode(), IFF_TUN | IFF_NO_PI))
    return device


def ip(*words: str) -> None:
    """Configures the network."""
    subprocess.run(["ip", *words], check=True)


def main() -> None:
    """Passes packets on until the standard input closes."""
    namespace, loss = sys.argv[1], float(sys.argv[2])
    randomness = random.Random(1)
    base, robot = tun("jdebase"), tun("jderobot")
    # One that was killed leaves its namespace.
    subprocess.run(["ip", "netns", "delete", namespace], check=False, stderr=subprocess.DEVNULL)
    ip("netns", "add", namespace)
    try:
        ip("link", "set", "jderobot", "netns", namespace)
        ip("address", "add", "10.77.63.1/24", "dev", "jdebase")
        ip("link", "set", "jdebase", "up")
        ip("-n", namespace, "address", "add", "10.77.63.2/24", "dev", "jderobot")
        ip("-n", namespace, "link", "set", "jderobot", "up")
        ip("-n", namespace, "link", "set", "lo", "up")
        print("ready", flush=True)
        while True:
            readable, _, _ = select.select([base, robot, 0], [], [])
            if 0 in readable:
                line = os.read(0, 100)
                if not line:
                    break
                loss = float(line)
            for device, other in ((base, robot), (robot, base)):
                if device in readable:
                    packet = os.read(device, 65536)
                    if randomness.uniform(0, 100) >= loss:
                        os.write(other, packet)
    finally:
        ip("netns", "delete", namespace)


main()
