"""Nav2's planner, controller, behaviours and navigator, which its lifecycle manager brings up."""

from pathlib import Path

from launch import LaunchDescription
from launch_ros.actions import Node

NODES = {
    "planner_server": "nav2_planner",
    "controller_server": "nav2_controller",
    "behavior_server": "nav2_behaviors",
    "bt_navigator": "nav2_bt_navigator",
}


def generate_launch_description():
    parameters = str(Path(__file__).with_name("nav2.yaml"))
    nodes = [Node(package=package, executable=name, parameters=[parameters]) for name, package in NODES.items()]
    # A machine that also compiles is slow: without bonds no node counts as lost.
    manages = {"autostart": True, "node_names": list(NODES), "bond_timeout": 0.0}
    manager = Node(package="nav2_lifecycle_manager", executable="lifecycle_manager", parameters=[manages])
    return LaunchDescription([*nodes, manager])
