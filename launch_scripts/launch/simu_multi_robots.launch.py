"""Virtual robots: `ros2 launch launch_scripts simu_multi_robots.launch.py nb_robots:=5`."""

from launch import LaunchDescription

from launch_scripts.ros_launch import description


def generate_launch_description() -> LaunchDescription:
    """Return the launch description."""
    return description('simu', nb_robots='8')
