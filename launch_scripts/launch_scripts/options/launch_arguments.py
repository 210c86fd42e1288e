"""Options of a verb as arguments of a ROS launch file: texts with defaults."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from dataclasses import dataclass

from launch_scripts.cli import build_parser

_YES = ('true', '1', 'yes')


@dataclass(frozen=True)
class LaunchArgument:
    """An argument such as `nb_robots:=8`.

    Attributes:
        name: Its name.
        help: What it means.
        flag: The option that it is, as typed.
        is_switch: Whether the option has no value.
        several: Whether the option takes several values, which spaces separate here.
        repeated: Whether it is typed again for each of them.
    """

    name: str
    help: str
    flag: str
    is_switch: bool
    several: bool
    repeated: bool

    def typed(self, text: str) -> list[str]:
        """Return how the option is typed for a value of the argument; an empty one is none."""
        if not text:
            return []
        if self.is_switch:
            return [self.flag] if text.lower() in _YES else []
        if self.repeated:
            return [f'{self.flag}={word}' for word in text.split()]
        return [self.flag, *text.split()] if self.several else [f'{self.flag}={text}']


def launch_arguments(verb: str) -> list[LaunchArgument]:
    """Return the arguments for all options of a verb."""
    return [
        LaunchArgument(
            action.dest,
            (action.help or '').replace('%%', '%'),
            action.option_strings[-1] if action.nargs != 0 else action.option_strings[0],
            action.nargs == 0,
            action.nargs in ('+', argparse.REMAINDER),
            isinstance(action, argparse._AppendAction),
        )
        for action in _parser(verb)._actions
        if action.option_strings and action.dest != 'help'
    ]


def command_line(verb: str, values: Mapping[str, str]) -> list[str]:
    """Return the command that a launch file starts, from the values of its arguments by name."""
    words = ['setcmas', verb]
    for argument in launch_arguments(verb):
        words += argument.typed(values.get(argument.name, ''))
    return words


def _parser(verb: str) -> argparse.ArgumentParser:
    """Return the parser of a verb's own options."""
    for action in build_parser(verb)._actions:
        if isinstance(action, argparse._SubParsersAction):
            return action.choices[verb]  # type: ignore[no-any-return]
    raise LookupError(verb)
