"""Contents of the ROS launch files: each starts nodes or a command, with all options."""

from __future__ import annotations

import argparse
import shutil
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from launch_scripts.cli import build_parser

if TYPE_CHECKING:
    from launch.actions import ExecuteProcess
    from launch.launch_context import LaunchContext
    from launch.launch_description import LaunchDescription

_YES = ('true', '1', 'yes')


def launch_arguments(verb: str) -> list[argparse.Action]:
    """Return the options of a verb, which are arguments such as `nb_robots:=8`."""
    return [action for action in _parser(verb)._actions if action.dest != 'help']


def command_line(verb: str, values: Mapping[str, str]) -> list[str]:
    """Return the command that a launch file starts, from its arguments."""
    words = ['setcmas', verb]
    for action in launch_arguments(verb):
        words += _typed(action, values.get(action.dest, ''))
    return words


def _typed(action: argparse.Action, text: str) -> list[str]:
    """Return an option with a value; an empty value is none, spaces separate several."""
    if not text:
        return []
    if not action.option_strings:
        return [text]
    if action.nargs == 0:
        return [action.option_strings[0]] if text.lower() in _YES else []
    flag = action.option_strings[-1]
    if isinstance(action, argparse._AppendAction):
        return [f'{flag}={word}' for word in text.split()]
    several = action.nargs in ('+', argparse.REMAINDER)
    return [flag, *text.split()] if several else [f'{flag}={text}']


def _parser(verb: str) -> argparse.ArgumentParser:
    """Return the parser of a verb's options."""
    for action in build_parser(verb)._actions:
        if isinstance(action, argparse._SubParsersAction):
            return action.choices[verb]  # type: ignore[no-any-return]
    raise LookupError(verb)


_ENDS_WITHIN_S = '15'  # robots get zero velocity first, then processes end one by one
_NODES = {
    'simu': ('setcmas_simu', 'virtual_robot'),
    'ctrl': ('setcmas_ctrl', 'controller'),
}
"""Package and executable of a verb's node."""
_OF_NODES = {
    'namespace': 'namespace of the fleet with all its topics',
    'params_file': 'YAML file with parameters of the node',
}


def description(verb: str, **defaults: str) -> LaunchDescription:
    """Return the description of a launch file, with its own defaults.

    It starts the node of simu or ctrl, and the page or RViz 2 with it; of other verbs, whose
    processes belong together, the setcmas command.
    """
    # Imported here: arguments and commands are tested without the package, which has no wheel.
    from launch.actions import DeclareLaunchArgument, OpaqueFunction
    from launch.launch_description import LaunchDescription
    from launch.substitutions import LaunchConfiguration

    help_texts = {
        one.dest: (one.help or one.dest).replace('%%', '%') for one in launch_arguments(verb)
    }
    if verb in _NODES:
        help_texts |= _OF_NODES

    def start(context: LaunchContext) -> list[ExecuteProcess]:
        values = {name: LaunchConfiguration(name).perform(context) for name in help_texts}
        return _nodes(verb, values) if verb in _NODES else [_command(verb, values)]

    declared = [
        DeclareLaunchArgument(name, default_value=defaults.get(name, ''), description=text)
        for name, text in help_texts.items()
    ]
    return LaunchDescription([*declared, OpaqueFunction(function=start)])


def _command(verb: str, values: Mapping[str, str]) -> ExecuteProcess:
    from launch.actions import ExecuteProcess, Shutdown

    command = command_line(verb, values)
    return ExecuteProcess(cmd=command, name='setcmas', on_exit=Shutdown(), **_process())


def _process() -> dict[str, Any]:
    """Return what all processes have in common: they end with zero velocity when launch dies."""
    # Launch leaves its processes behind at SIGTERM and SIGKILL. setpriv is part of util-linux.
    prefix = 'setpriv --pdeathsig INT' if shutil.which('setpriv') else None
    return {
        'output': 'screen',
        'emulate_tty': True,
        'sigterm_timeout': _ENDS_WITHIN_S,
        'prefix': prefix,
    }


def _nodes(verb: str, values: Mapping[str, str]) -> list[ExecuteProcess]:
    """Return the node of a verb, and the views that are wanted."""
    from launch.actions import Shutdown
    from launch_ros.actions import Node
    from launch_ros.substitutions import FindPackageShare

    args = _parser(verb).parse_args(command_line(verb, values)[2:])
    package, executable = _NODES[verb]
    common = {'namespace': values['namespace'], 'respawn': False, **_process()}

    nodes = [
        Node(
            package=package,
            executable=executable,
            exec_name=executable,
            arguments=args.node_arguments(args),
            parameters=[values['params_file']] if values['params_file'] else None,
            ros_arguments=args.ros_args,
            on_exit=Shutdown(),
            **common,
        )
    ]
    if args.view == 'browser':
        nodes.append(Node(package='setcmas_tools', executable='browser_view', **common))
    if args.rviz:
        config = [FindPackageShare('setcmas_simu'), '/rviz/simulation_8.rviz']
        nodes.append(Node(package='rviz2', executable='rviz2', arguments=['-d', config], **common))
    return nodes
