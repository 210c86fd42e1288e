"""An experiment with a control law for each robot of a fleet, as in the ROS 1 stack.

ros2 launch setcmas_expe expe_ctrl_multi_robots.launch.py lab:=lab.yaml algo:=consensus

It starts paused; launch passes on no keys, so a wired joystick starts the robots.
"""

import shlex

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess, OpaqueFunction, Shutdown
from launch.substitutions import LaunchConfiguration

ARGUMENTS = {
    'algo': ('consensus', 'law or script; external: velocities come on cmd_cart_vel'),
    'exercise': ('False', 'its exercise'),
    'nb_robots': ('', 'by default those of the lab file'),
    'lab': ('', 'lab file; by default that of the package'),
    'options': ('', "more options of setcmas expe, such as '--emulate --mocap vicon'"),
}


def generate_launch_description() -> LaunchDescription:
    """Return the launch description."""
    declared = [
        DeclareLaunchArgument(name, default_value=value, description=text)
        for name, (value, text) in ARGUMENTS.items()
    ]
    return LaunchDescription([*declared, OpaqueFunction(function=_experiment)])


def _experiment(context):
    values = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    words = shlex.split(values.pop('options'))
    if values.pop('exercise').lower() in ('true', '1', 'yes'):
        words.append('--exercise')
    words += [f'--{name.replace("_", "-")}={value}' for name, value in values.items() if value]
    # The command, not the nodes: it stops its processes in a safe order when one of them dies.
    return [
        ExecuteProcess(
            cmd=['setcmas', 'expe', *words],
            name='setcmas',
            output='screen',
            emulate_tty=True,
            prefix='setpriv --pdeathsig INT',  # robots stop, too, when launch is killed
            sigterm_timeout='15',
            on_exit=Shutdown(),
        )
    ]
