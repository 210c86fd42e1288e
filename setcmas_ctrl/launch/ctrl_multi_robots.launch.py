"""A control law for each robot of a fleet, as in the ROS 1 stack.

ros2 launch setcmas_ctrl ctrl_multi_robots.launch.py algo:=consensus exercise:=True nb_robots:=8
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, Shutdown
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node


def generate_launch_description() -> LaunchDescription:
    """Return the launch description."""
    return LaunchDescription(
        [
            DeclareLaunchArgument('algo', default_value='consensus', description='law or script'),
            DeclareLaunchArgument('exercise', default_value='False', description='its exercise'),
            DeclareLaunchArgument('nb_robots', default_value='0', description='0: as simulated'),
            DeclareLaunchArgument(
                'namespace', default_value='', description='namespace of the fleet'
            ),
            # One process has the nodes of all robots: with one each, 8 robots would take a core.
            Node(
                package='setcmas_ctrl',
                executable='controller',
                exec_name='controller',
                namespace=LaunchConfiguration('namespace'),
                arguments=['--algo', LaunchConfiguration('algo')],
                parameters=[
                    {
                        'exercise': LaunchConfiguration('exercise'),
                        'nb_robots': LaunchConfiguration('nb_robots'),
                    }
                ],
                output='screen',
                prefix='setpriv --pdeathsig INT',  # robots stop, too, when launch is killed
                sigterm_timeout='15',
                on_exit=Shutdown(),
            ),
        ]
    )
