"""Starts ros2_canopen on B2P2's bus, and publishes the robot's URDF.

The argument `bus` is the folder with bus.yml, the EDS files and the output of dcfgen.
"""

from pathlib import Path

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare


def generate_launch_description():
    bus = LaunchConfiguration("bus")
    urdf = Path(__file__).with_name("urdf") / "b2p2.urdf"
    canopen = PathJoinSubstitution(
        [FindPackageShare("canopen_core"), "launch", "canopen.launch.py"]
    )
    return LaunchDescription(
        [
            DeclareLaunchArgument("bus"),
            DeclareLaunchArgument("can", default_value="can0"),
            IncludeLaunchDescription(
                canopen,
                launch_arguments={
                    "bus_config": PathJoinSubstitution([bus, "bus.yml"]),
                    "master_config": PathJoinSubstitution([bus, "master.dcf"]),
                    "master_bin": PathJoinSubstitution([bus, "master.bin"]),
                    "can_interface_name": LaunchConfiguration("can"),
                }.items(),
            ),
            Node(
                package="robot_state_publisher",
                executable="robot_state_publisher",
                parameters=[{"robot_description": urdf.read_text()}],
            ),
        ]
    )
