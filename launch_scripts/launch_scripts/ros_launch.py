"""Contents of the ROS launch files: a setcmas command each, with all its options as arguments.

The command starts, watches and ends the processes, as it does in a terminal.
"""

from __future__ import annotations

from launch.actions import DeclareLaunchArgument, ExecuteProcess, OpaqueFunction, Shutdown
from launch.launch_context import LaunchContext
from launch.launch_description import LaunchDescription
from launch.substitutions import LaunchConfiguration

from launch_scripts.options.launch_arguments import command_line, launch_arguments

_ENDS_WITHIN_S = '15'  # robots get their zero first, then processes end one after the other


def description(verb: str, **defaults: str) -> LaunchDescription:
    """Return what a launch file does that starts a verb, with defaults of its own."""
    arguments = launch_arguments(verb)

    def start(context: LaunchContext) -> list[ExecuteProcess]:
        values = {one.name: LaunchConfiguration(one.name).perform(context) for one in arguments}
        return [
            ExecuteProcess(
                cmd=command_line(verb, values),
                output='screen',
                emulate_tty=True,
                sigterm_timeout=_ENDS_WITHIN_S,
                on_exit=Shutdown(),
            )
        ]

    declared = [
        DeclareLaunchArgument(
            one.name, default_value=defaults.get(one.name, ''), description=one.help or one.name
        )
        for one in arguments
    ]
    return LaunchDescription([*declared, OpaqueFunction(function=start)])
