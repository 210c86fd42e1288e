"""One virtual robot, as in the ROS 1 stack.

ros2 launch setcmas_simu simu_mono_robot.launch.py tb3_1_x0:=1.0 tb3_1_theta0:=1.57 rviz_gui:=False
"""

from shutil import which

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, Shutdown
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare


def generate_launch_description() -> LaunchDescription:
    """Return the launch description."""
    has_rviz = str(which('rviz2') is not None)
    config = [FindPackageShare('setcmas_simu'), 'rviz', 'simulation_8.rviz']
    x0, y0, theta0 = map(LaunchConfiguration, ('tb3_1_x0', 'tb3_1_y0', 'tb3_1_theta0'))
    return LaunchDescription(
        [
            DeclareLaunchArgument('tb3_1_x0', default_value='0.0', description='x at first in m'),
            DeclareLaunchArgument('tb3_1_y0', default_value='0.0', description='y in m'),
            DeclareLaunchArgument(
                'tb3_1_theta0', default_value='0.0', description='heading in rad'
            ),
            DeclareLaunchArgument('rviz_gui', default_value=has_rviz, description='show RViz 2'),
            DeclareLaunchArgument(
                'namespace', default_value='', description='namespace of the fleet'
            ),
            Node(
                package='setcmas_simu',
                executable='virtual_robot',
                exec_name='virtual_robot',
                namespace=LaunchConfiguration('namespace'),
                arguments=['--nb-robots', '1', '--pose', ['1:', x0, ',', y0, ',', theta0]],
                output='screen',
                prefix='setpriv --pdeathsig INT',  # the robot ends, too, when launch is killed
                sigterm_timeout='15',
                on_exit=Shutdown(),
            ),
            Node(
                package='rviz2',
                executable='rviz2',
                arguments=['-d', PathJoinSubstitution(config)],
                condition=IfCondition(LaunchConfiguration('rviz_gui')),
            ),
        ]
    )
