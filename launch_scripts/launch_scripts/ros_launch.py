"""Contents of the launch file of experiments: the command, with all its options."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from typing import TYPE_CHECKING

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


def description(verb: str, **defaults: str) -> LaunchDescription:
    """Return the description of a launch file that runs a setcmas command, with own defaults."""
    # Imported here: arguments and commands are tested without the package, which has no wheel.
    from launch.actions import DeclareLaunchArgument, ExecuteProcess, OpaqueFunction, Shutdown
    from launch.launch_description import LaunchDescription
    from launch.substitutions import LaunchConfiguration

    help_texts = {
        one.dest: (one.help or one.dest).replace('%%', '%') for one in launch_arguments(verb)
    }

    def start(context: LaunchContext) -> list[ExecuteProcess]:
        values = {name: LaunchConfiguration(name).perform(context) for name in help_texts}
        process = ExecuteProcess(
            cmd=command_line(verb, values),
            name='setcmas',
            output='screen',
            emulate_tty=True,
            sigterm_timeout=_ENDS_WITHIN_S,
            prefix='setpriv --pdeathsig INT',  # robots stop, too, when launch is killed
            on_exit=Shutdown(),
        )
        return [process]

    declared = [
        DeclareLaunchArgument(name, default_value=defaults.get(name, ''), description=text)
        for name, text in help_texts.items()
    ]
    return LaunchDescription([*declared, OpaqueFunction(function=start)])
