"""Contents of the ROS launch files: each starts a setcmas command with all its options."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from launch_scripts.cli import build_parser

if TYPE_CHECKING:
    from launch.actions import ExecuteProcess
    from launch.launch_context import LaunchContext
    from launch.launch_description import LaunchDescription

_YES = ('true', '1', 'yes')


@dataclass(frozen=True)
class LaunchArgument:
    """An argument such as `nb_robots:=8`.

    Attributes:
        help: What it means.
        flag: The option that it is, as typed; empty for a scenario file.
        is_switch: Whether the option has no value.
        several: Whether the option takes several values, separated here by spaces.
        repeated: Whether the option is repeated for each value.
    """

    name: str
    help: str
    flag: str
    is_switch: bool
    several: bool
    repeated: bool

    def typed(self, text: str) -> list[str]:
        """Return the option for a value of the argument; an empty value is none."""
        if not text:
            return []
        if self.is_switch:
            return [self.flag] if text.lower() in _YES else []
        if not self.flag:
            return [text]
        if self.repeated:
            return [f'{self.flag}={word}' for word in text.split()]
        return [self.flag, *text.split()] if self.several else [f'{self.flag}={text}']


def launch_arguments(verb: str) -> list[LaunchArgument]:
    """Return the arguments for all options of a verb."""
    return [
        LaunchArgument(
            action.dest,
            (action.help or '').replace('%%', '%'),
            _flag(action),
            action.nargs == 0,
            action.nargs in ('+', argparse.REMAINDER),
            isinstance(action, argparse._AppendAction),
        )
        for action in _parser(verb)._actions
        if action.dest != 'help'
    ]


def _flag(action: argparse.Action) -> str:
    if not action.option_strings:
        return ''
    return action.option_strings[-1 if action.nargs != 0 else 0]


def command_line(verb: str, values: Mapping[str, str]) -> list[str]:
    """Return the command that a launch file starts, from its arguments."""
    words = ['setcmas', verb]
    for argument in launch_arguments(verb):
        words += argument.typed(values.get(argument.name, ''))
    return words


def _parser(verb: str) -> argparse.ArgumentParser:
    """Return the parser of a verb's options."""
    for action in build_parser(verb)._actions:
        if isinstance(action, argparse._SubParsersAction):
            return action.choices[verb]  # type: ignore[no-any-return]
    raise LookupError(verb)


_ENDS_WITHIN_S = '15'  # robots get zero velocity first, then processes end one by one


def description(verb: str, **defaults: str) -> LaunchDescription:
    """Return the description of a launch file that starts a verb, with its own defaults."""
    # Imported here: arguments and commands are tested without the package, which has no wheel.
    from launch.actions import DeclareLaunchArgument, ExecuteProcess, OpaqueFunction, Shutdown
    from launch.launch_description import LaunchDescription
    from launch.substitutions import LaunchConfiguration

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
