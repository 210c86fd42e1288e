"""Control of a fleet: `ros2 launch launch_scripts ctrl_multi_robots.launch.py algo:=consensus`."""

from launch import LaunchDescription

from launch_scripts.ros_launch import description


def generate_launch_description() -> LaunchDescription:
    """Return the launch description."""
    return description('ctrl', algo='consensus')
