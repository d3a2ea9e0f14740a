"""The tools of ROS 2, as a user types them, beside a jde robot: they list it, show its topics and transforms, and drive it.

    ros2_tools.py PORT

It fails with a message if a tool has not shown what it must after LIMIT seconds.
"""

import os
import pty
import subprocess
import sys
import threading

from ros2_peer import TYPES, check
from with_rclpy import end_with_parent, environment

LIMIT = 60.0


class Tool:
    """A tool that runs until this is closed."""

    def __init__(self, *arguments, **options):
        self.name = " ".join(["ros2", *arguments])
        self.process = subprocess.Popen(
            ["ros2", *arguments], env=variables, text=True, preexec_fn=end_with_parent, **options
        )
        self.watchdog = threading.Timer(LIMIT, self.process.kill)
        self.watchdog.start()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.watchdog.cancel()
        self.process.kill()
        self.process.wait()


def shows(arguments, *expected):
    """Checks that a tool prints these, and ends it then."""
    missing, output = list(expected), []
    options = {"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
    with Tool(*arguments.split(), **options) as tool:
        for line in tool.process.stdout:
            output.append(line)
            missing = [text for text in missing if text not in line]
            if not missing:
                print(f"{tool.name}: {line.strip()}")
                return
    check(False, f"`{tool.name}` does not show {missing}:\n{''.join(output)}")


def drives():
    """Drives the robot with the keyboard until its odometry shows a velocity."""
    ours, its = pty.openpty()
    teleop = ["run", "teleop_twist_keyboard", "teleop_twist_keyboard"]
    with Tool(*teleop, stdin=its, stdout=subprocess.DEVNULL) as tool:
        ended = threading.Event()

        def press():
            while not ended.wait(0.1):
                os.write(ours, b"i")

        keys = threading.Thread(target=press, daemon=True)
        keys.start()
        try:
            shows("topic echo --field twist.twist.linear.x --filter m.twist.twist.linear.x>0.4 /odom", "0.")
        finally:
            ended.set()
            keys.join()
    check(tool.process.returncode, "the keyboard's program ended by itself")


if __name__ == "__main__":
    variables = os.environ | environment(int(sys.argv[1])) | {"PYTHONUNBUFFERED": "1"}
    topics = [f"{topic} [{kind}]" for topic, kind in TYPES.items()]
    shows("topic list -t --no-daemon --spin-time 5", *topics)
    shows("node list --no-daemon --spin-time 5", "/pioneer")
    info = [f"{topic}: {kind}" for topic, kind in TYPES.items()]
    shows("node info --no-daemon --spin-time 5 /pioneer", *info)
    quality = ["Node name: pioneer", "RIHS01_", "Reliability: BEST_EFFORT", "History (Depth): KEEP_LAST (5)"]
    shows("topic info -v --no-daemon --spin-time 5 /scan", *quality)
    shows("topic hz --window 10 /odom", "average rate: ")
    shows("topic echo --once --field voltage /battery_state", "1")
    shows("run tf2_ros tf2_echo odom laser", "Translation: [")
    drives()
