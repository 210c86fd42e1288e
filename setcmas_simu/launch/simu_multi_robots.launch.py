"""Virtual robots, as in the ROS 1 stack.

ros2 launch setcmas_simu simu_multi_robots.launch.py nb_robots:=8 tb3_1_x0:=1.0 rviz_gui:=False
"""

from shutil import which

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction, Shutdown
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

from setcmas_simu.fleet.fleet import start_poses

POSE = ('x0', 'y0', 'theta0')  # m and rad


def generate_launch_description() -> LaunchDescription:
    """Return the launch description."""
    has_rviz = str(which('rviz2') is not None)
    config = [FindPackageShare('setcmas_simu'), 'rviz', 'simulation_8.rviz']
    return LaunchDescription(
        [
            DeclareLaunchArgument('nb_robots', default_value='8', description='size of the fleet'),
            DeclareLaunchArgument('rviz_gui', default_value=has_rviz, description='show RViz 2'),
            DeclareLaunchArgument(
                'namespace', default_value='', description='namespace of the fleet'
            ),
            *(
                DeclareLaunchArgument(
                    f'tb3_{robot}_{name}', default_value=str(value), description='m, rad'
                )
                for robot, pose in enumerate(start_poses(8).T.tolist(), start=1)
                for name, value in zip(POSE, pose, strict=True)
            ),
            OpaqueFunction(function=virtual_robots),
            Node(
                package='rviz2',
                executable='rviz2',
                arguments=['-d', PathJoinSubstitution(config)],
                condition=IfCondition(LaunchConfiguration('rviz_gui')),
            ),
        ]
    )


def virtual_robots(context: LaunchContext) -> list[Node]:
    """Return what runs the robots, with a start pose for each of as many as nb_robots says."""
    nb_robots = LaunchConfiguration('nb_robots').perform(context)
    poses = []
    for robot, pose in enumerate(start_poses(int(nb_robots)).T.tolist(), start=1):
        values = [
            LaunchConfiguration(f'tb3_{robot}_{name}', default=str(value)).perform(context)
            for name, value in zip(POSE, pose, strict=True)
        ]
        poses += ['--pose', f'{robot}:{",".join(values)}']
    # One process has the nodes of all robots: with one each, 8 robots would take a whole core.
    return [
        Node(
            package='setcmas_simu',
            executable='virtual_robot',
            exec_name='virtual_robot',
            namespace=LaunchConfiguration('namespace'),
            arguments=['--nb-robots', nb_robots, *poses],
            output='screen',
            prefix='setpriv --pdeathsig INT',  # the robots end, too, when launch is killed
            sigterm_timeout='15',
            on_exit=Shutdown(),
        )
    ]
