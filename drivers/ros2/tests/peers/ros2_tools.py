"""The tools of ROS 2, as a user types them, beside a jde robot.

    ros2_tools.py robot PORT     beside `jde run ros2`: they list it, show its topics and transforms, and drive it
    ros2_tools.py frames PORT    beside `jde run ros2` without static transforms: robot_state_publisher says where its laser is
    ros2_tools.py arbiter PORT   beside `jde run ros2-arbiter`: they drive by a topic of another name
    ros2_tools.py goals PORT     beside `jde run ros2-goals`: they show its map and send it to a place
    ros2_tools.py nav2 PORT      beside `jde run ros2-nav2` with a target: Nav2 drives there
    ros2_tools.py actions PORT   beside `jde run examples/ros2/fibonacci/app.toml`: they send it a goal, and it sends one
    ros2_tools.py services PORT JDE
                                they launch services.toml with parameters and other names, and call its service

It fails with a message if a tool has not shown what it must after LIMIT seconds.
"""

import os
import pty
import shlex
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

from ros2_peer import TYPES, check
from with_rclpy import close, connect, end_with_parent, environment

LIMIT = 60.0
# No daemon, which would outlive the test; the tool itself looks for this many seconds.
ALONE = "--no-daemon --spin-time 5"
# Its types have no hashes.
IS_HUMBLE = os.environ.get("ROS_DISTRO") == "humble"


class Tool:
    """A tool that runs until this is closed."""

    def __init__(self, *arguments, **options):
        self.name = " ".join(["ros2", *arguments])
        self.process = subprocess.Popen(
            ["ros2", *arguments],
            env=variables,
            text=True,
            start_new_session=True,
            preexec_fn=end_with_parent,
            **options,
        )
        self.watchdog = threading.Timer(LIMIT, self.kill)
        self.watchdog.start()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.watchdog.cancel()
        self.kill()
        self.process.wait()

    def kill(self):
        """Kills the tool and, of `ros2 run`, the program."""
        os.killpg(self.process.pid, signal.SIGKILL)


def shows(arguments, *expected):
    """Checks that a tool prints these, and ends it then. A tool that ends before is run again: the robot may not be there yet."""
    end = time.monotonic() + LIMIT
    options = {"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
    while time.monotonic() < end:
        missing, output = list(expected), []
        with Tool(*shlex.split(arguments), **options) as tool:
            for line in tool.process.stdout:
                output.append(line)
                missing = [text for text in missing if text not in line]
                if not missing:
                    print(f"{tool.name}: {line.strip()}")
                    return
    check(False, f"`{tool.name}` does not show {missing}:\n{''.join(output)}")


def drives(arguments, *teleop_arguments):
    """Drives with the keyboard until a tool with these arguments shows a velocity."""
    ours, its = pty.openpty()
    teleop = ["run", "teleop_twist_keyboard", "teleop_twist_keyboard", *teleop_arguments]
    with Tool(*teleop, stdin=its, stdout=subprocess.DEVNULL):
        ended = threading.Event()

        def press():
            while not ended.wait(0.1):
                os.write(ours, b"i")

        keys = threading.Thread(target=press, daemon=True)
        keys.start()
        try:
            shows(arguments, "linear:")
        finally:
            ended.set()
            keys.join()


def robot():
    topics = [f"{topic} [{kind}]" for topic, kind in TYPES.items()]
    shows(f"topic list -t {ALONE}", *topics)
    shows(f"node list {ALONE}", "/pioneer")
    info = [f"{topic}: {kind}" for topic, kind in TYPES.items()]
    shows(f"node info {ALONE} /pioneer", *info)
    quality = ["Node name: pioneer", "Reliability: BEST_EFFORT", "History (Depth): KEEP_LAST (5)"]
    shows(f"topic info -v {ALONE} /scan", *quality, *([] if IS_HUMBLE else ["RIHS01_"]))
    shows("topic hz --window 10 /odom", "average rate: ")
    shows(f"topic echo {ALONE} --once --field voltage /battery_state", "1")
    drives(f"topic echo {ALONE} --filter m.twist.twist.linear.x>0.4 /odom")
    shows("run tf2_ros tf2_echo odom laser", "Translation: [")


def frames():
    links = "<link name='base_link'/><link name='laser'/>"
    joint = "<parent link='base_link'/><child link='laser'/><origin xyz='0.1 0 0.18'/>"
    description = f"<robot name='pioneer'>{links}<joint name='mount' type='fixed'>{joint}</joint></robot>"
    publisher = ["run", "robot_state_publisher", "robot_state_publisher"]
    with Tool(*publisher, "--ros-args", "-p", f"robot_description:={description}"):
        shows("run tf2_ros tf2_echo odom laser", "0.180]")


def arbiter():
    renamed = ["--ros-args", "-r", "cmd_vel:=teleop/cmd_vel"]
    drives(f"topic echo {ALONE} --filter m.linear.x>0.4 /cmd_vel", *renamed)


def goals():
    latched = "--qos-durability transient_local --qos-reliability reliable"
    shows(f"topic echo {ALONE} --once --field info {latched} /map", "resolution: 0.05")
    send = "action send_goal --feedback /navigate_to_pose nav2_msgs/action/NavigateToPose"
    place = "pose: {position: {x: 3.55, y: 2.8}, orientation: {z: 0.7071, w: 0.7071}}"
    shows(f"{send} '{{pose: {{header: {{frame_id: odom}}, {place}}}}}'", "rejected")
    shows(f"{send} '{{pose: {{header: {{frame_id: map}}, {place}}}}}'", "distance_remaining: ", "SUCCEEDED")


def nav2():
    launch = ["launch", str(Path(__file__).with_name("nav2.launch.py"))]
    with Tool(*launch, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL):
        latched = "--qos-durability transient_local --qos-reliability reliable"
        status = "/navigate_to_pose/_action/status action_msgs/msg/GoalStatusArray"
        # 4 is SUCCEEDED.
        shows(f"topic echo {latched} {status}", "status: 4")
        shows(f"topic echo {ALONE} --once --filter m.pose.pose.position.y>2.3 /odom", "y: ")


def actions():
    from example_interfaces.action import Fibonacci
    from rclpy.action import ActionServer, CancelResponse
    from rclpy.task import Future

    node, seen = connect(int(sys.argv[2])), []

    async def pause():
        future = Future()
        timer = node.create_timer(0.05, lambda: future.set_result(None))
        await future
        node.destroy_timer(timer)

    async def compute(goal):
        sequence = [0, 1]
        # The first goal lasts until it is canceled.
        while (len(sequence) <= goal.request.order or not seen) and not goal.is_cancel_requested:
            if len(sequence) < 40:
                sequence.append(sequence[-1] + sequence[-2])
            goal.publish_feedback(Fibonacci.Feedback(sequence=sequence))
            await pause()
        goal.canceled() if goal.is_cancel_requested else goal.succeed()
        seen.append((goal.request.order, goal.status))
        return Fibonacci.Result(sequence=sequence)

    server = ActionServer(node, Fibonacci, "/other/fibonacci", compute, cancel_callback=lambda _: CancelResponse.ACCEPT)
    kind = "example_interfaces/action/Fibonacci"
    shows("action list -t", f"/fibonacci [{kind}]")
    shows("action info /fibonacci", "/actions")
    # It takes the place of the schema whose goal the server above carries out.
    shows(f"action send_goal -f /fibonacci {kind} '{{order: 4}}'", "- 2", "SUCCEEDED")
    shows(f"action send_goal /fibonacci {kind} '{{order: 60}}'", "ABORTED")
    end = time.monotonic() + LIMIT
    # 5 is CANCELED, and 4 SUCCEEDED.
    while (30, 4) not in seen and time.monotonic() < end:
        time.sleep(0.05)
    check(seen[0] == (30, 5) and (30, 4) in seen, f"the goals of the application ended so: {seen}")
    server.destroy()
    close()


def services():
    from std_srvs.srv import SetBool

    asked = []

    def switch(request, response):
        asked.append(request.data)
        response.success, response.message = request.data, f"light {request.data}"
        return response

    # The application calls it as /light.
    connect(int(sys.argv[2])).create_service(SetBool, "/lamp/light", switch)
    folder = Path(__file__).parent
    endpoint = f"{'humble/' if IS_HUMBLE else ''}tcp/127.0.0.1:{sys.argv[2]}"
    launch = ["launch", str(folder / "services.launch.py"), f"jde:={sys.argv[3]}", f"connect:={endpoint}"]
    with Tool(*launch, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL):
        shows(f"service list -t {ALONE}", "/fleet/relay [std_srvs/srv/SetBool]", "/fleet/scout/enable [std_srvs/srv/SetBool]")
        for data in ["true", "false"]:
            said = f"success={data.title()}, message='light {data.title()}'"
            shows(f"service call /fleet/relay std_srvs/srv/SetBool '{{data: {data}}}'", said)
        check(asked[:1] == [True] and False in asked, f"the service was asked {asked}")
        shows(f"param get {ALONE} /fleet/scout follow.patience", "Double value is: 0.75")
        shows(f"param get {ALONE} /fleet/scout pioneer.laser_range", "Double value is: 7.5")
        shows("service call /fleet/scout/enable std_srvs/srv/SetBool '{data: false}'", "success=True")
        shows(f"lifecycle get {ALONE} /fleet/scout", "inactive")
    close()


if __name__ == "__main__":
    variables = os.environ | environment(int(sys.argv[2])) | {"PYTHONUNBUFFERED": "1"}
    roles = {"robot": robot, "frames": frames, "arbiter": arbiter, "goals": goals, "nav2": nav2, "actions": actions, "services": services}
    roles[sys.argv[1]]()
