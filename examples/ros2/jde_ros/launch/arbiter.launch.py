"""Starts the arbiter of a ROS 2 robot, and the watchdog that stops the robot if the arbiter dies, each in its process.

ros2 launch jde_ros arbiter.launch.py teleop:=joy/cmd_vel velocity:=cmd_vel
ros2 launch jde_ros arbiter.launch.py application:=ros2-guarded docking:=''
"""

import shlex

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

ARGUMENTS = [
    ("teleop", "teleop/cmd_vel", "The topic of the program by which a person drives; it has priority."),
    ("docking", "dock/cmd_vel", "The topic of the program that docks; empty if the application has none."),
    ("navigation", "nav/cmd_vel", "The topic of the program that navigates."),
    ("velocity", "cmd_vel", "The topic of the robot."),
    ("timeout", "500ms", "Time without a velocity after which the watchdog publishes zeros."),
    ("application", "ros2-arbiter", "The arbiter: its name, or the path of its file."),
    ("namespace", "", "The namespace of all nodes."),
    ("connect", "", "Where both connect, such as tcp/robot.local:7447; empty for the router of this machine."),
    ("options", "", "Further options of `jde run` for the arbiter."),
]


def start(context):
    def stated(name):
        return LaunchConfiguration(name).perform(context)

    def run(application, settings, options=()):
        values = [part for key, value in settings.items() if value for part in ("--set", f"{key}={value}")]
        return Node(
            package="jde_ros",
            executable="jde",
            arguments=["run", application, "--plain", *values, *options],
            namespace=stated("namespace") or None,
            output="screen",
            respawn=True,
            respawn_delay=1.0,
            # A driver stops its robot before it ends.
            sigterm_timeout="10",
        )

    sources = [source for source in ("teleop", "docking", "navigation") if stated(source)]
    arbiter = {f"{source}.topic": stated(source) for source in sources}
    arbiter |= {f"{schema}.connect": stated("connect") for schema in [*sources, "robot"]}
    arbiter["robot.velocity_topic"] = stated("velocity")
    watchdog = {"topic": stated("velocity"), "timeout": stated("timeout"), "connect": stated("connect")}
    return [
        run(stated("application"), arbiter, shlex.split(stated("options"))),
        run("ros2-watchdog", {f"watchdog.{key}": value for key, value in watchdog.items()}),
    ]


def generate_launch_description():
    arguments = [
        DeclareLaunchArgument(name, default_value=value, description=about) for name, value, about in ARGUMENTS
    ]
    return LaunchDescription([*arguments, OpaqueFunction(function=start)])
