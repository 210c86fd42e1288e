"""A control law for one robot, as in the ROS 1 stack.

ros2 launch setcmas_ctrl ctrl_mono_robot.launch.py algo:=nav_wp
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, Shutdown
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node


def generate_launch_description() -> LaunchDescription:
    """Return the launch description."""
    return LaunchDescription(
        [
            DeclareLaunchArgument('algo', default_value='nav_wp', description='law or script'),
            DeclareLaunchArgument('exercise', default_value='False', description='its exercise'),
            DeclareLaunchArgument(
                'namespace', default_value='', description='namespace of the fleet'
            ),
            Node(
                package='setcmas_ctrl',
                executable='controller',
                exec_name='controller',
                namespace=LaunchConfiguration('namespace'),
                arguments=['--algo', LaunchConfiguration('algo'), '--nb-robots', '1'],
                parameters=[{'exercise': LaunchConfiguration('exercise')}],
                output='screen',
                prefix='setpriv --pdeathsig INT',  # the robot stops, too, when launch is killed
                sigterm_timeout='15',
                on_exit=Shutdown(),
            ),
        ]
    )
