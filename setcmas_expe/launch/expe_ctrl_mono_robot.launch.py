"""An experiment with a control law for one robot, as in the ROS 1 stack.

ros2 launch setcmas_expe expe_ctrl_mono_robot.launch.py lab:=lab.yaml algo:=nav_wp

Its other arguments are those of expe_ctrl_multi_robots.
"""

from pathlib import Path

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration

MULTI = Path(__file__).with_name('expe_ctrl_multi_robots.launch.py')


def generate_launch_description() -> LaunchDescription:
    """Return the launch description."""
    arguments = {'nb_robots': '1', 'algo': LaunchConfiguration('algo')}
    return LaunchDescription(
        [
            DeclareLaunchArgument('algo', default_value='nav_wp', description='law or script'),
            IncludeLaunchDescription(
                PythonLaunchDescriptionSource(str(MULTI)), launch_arguments=arguments.items()
            ),
        ]
    )
