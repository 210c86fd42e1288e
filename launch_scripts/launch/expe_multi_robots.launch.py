"""An experiment: `ros2 launch launch_scripts expe_multi_robots.launch.py lab:=lab.yaml`.

It starts paused: a joystick starts the robots.
"""

from launch import LaunchDescription

from launch_scripts.ros_launch import description


def generate_launch_description() -> LaunchDescription:
    """Return the launch description."""
    return description('expe', algo='nav_wp')
