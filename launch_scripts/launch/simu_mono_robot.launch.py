"""One virtual robot: `ros2 launch launch_scripts simu_mono_robot.launch.py pose:=1:0,0,0`."""

from launch import LaunchDescription

from launch_scripts.ros_launch import description


def generate_launch_description() -> LaunchDescription:
    """Return the launch description."""
    return description('simu', nb_robots='1')
