"""Starts a jde application as a node of ROS 2.

ros2 launch jde_ros jde.launch.py application:=safe-navigation node:=scout options:="--set goon.fast=0.3"
"""

import shlex

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node


def start(context):
    def stated(name):
        return LaunchConfiguration(name).perform(context)

    node = Node(
        package="jde_ros",
        executable="jde",
        arguments=["run", stated("application"), "--plain", *shlex.split(stated("options"))],
        name=stated("node") or None,
        namespace=stated("namespace") or None,
        parameters=[stated("params")] if stated("params") else None,
        output="screen",
        # A driver stops its robot before it ends.
        sigterm_timeout="10",
    )
    return [node]


def generate_launch_description():
    return LaunchDescription(
        [
            DeclareLaunchArgument("application", description="The application: its name, or the path of its file."),
            DeclareLaunchArgument("node", default_value="", description="The node's name; empty for the application's."),
            DeclareLaunchArgument("namespace", default_value="", description="The node's namespace."),
            DeclareLaunchArgument("params", default_value="", description="A file of parameters."),
            DeclareLaunchArgument("options", default_value="", description="Further options of `jde run`."),
            OpaqueFunction(function=start),
        ]
    )
