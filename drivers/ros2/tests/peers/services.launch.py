"""Starts services.toml with a file of parameters, a parameter, and other names."""

from pathlib import Path

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

FOLDER = Path(__file__).parent


def generate_launch_description():
    connect = LaunchConfiguration("connect")
    options = [option for schema in ["services", "follow"] for option in ("--set", [f"{schema}.connect=", connect])]
    node = Node(
        executable=LaunchConfiguration("jde"),
        arguments=["run", str(FOLDER / "services.toml"), "--plain", *options],
        name="scout",
        namespace="/fleet",
        parameters=[str(FOLDER / "services.yaml"), {"pioneer.laser_range": 7.5}],
        remappings=[("/light", "/lamp/light"), ("/relay", "relay")],
        output="screen",
    )
    return LaunchDescription([DeclareLaunchArgument("jde"), DeclareLaunchArgument("connect"), node])
