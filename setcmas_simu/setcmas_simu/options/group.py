"""Groups of options: dataclasses whose fields are options.

A group adds its options to a command line, checks their values, and writes them for child
processes and run.yaml.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Container, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import MISSING, Field, dataclass, field, fields
from pathlib import Path
from typing import Any, ClassVar, TypeVar

from setcmas_simu.errors import SetcmasError
from setcmas_simu.options.kinds import Kind
from setcmas_simu.options.option import Form, Option, plain
from setcmas_simu.yaml_entries import entries_of, yaml_line

Group = TypeVar('Group', bound='Options')


class ClashError(SetcmasError):
    """Options contradict each other; `typed` is the message with their names as typed."""

    def __init__(self, message: str, *names: str) -> None:
        super().__init__(message, *names)
        self.names = names
        self.typed = message.format(*map(spelled, names))

    def __str__(self) -> str:
        return str(self.args[0]).format(*self.names)


def spelled(name: str) -> str:
    """Return an option's name as typed, such as --nb-robots."""
    return f'--{name.replace("_", "-")}'


def option(kind: Kind, help: str, *, default: Any = MISSING, **known: Any) -> Any:  # noqa: A002
    """Return a field of a group, for an option with a value; required without a default."""
    metadata = {'option': Option(kind, help, **known)}
    if isinstance(default, dict):
        return field(default_factory=default.copy, metadata=metadata)
    return field(default=default, metadata=metadata)


def default_of(one: Field[Any]) -> Any:
    """Return the default of a field of a group; MISSING if there is none."""
    return one.default if one.default_factory is MISSING else one.default_factory()


def flag(help: str, default: bool = False, **known: Any) -> Any:  # noqa: A002
    """Return a field of a group, for an option that is typed without a value."""
    form = Form.SWITCH if default else Form.FLAG
    return field(default=default, metadata={'option': Option(Kind(), help, form, **known)})


@dataclass(frozen=True, kw_only=True)
class Options:
    """The values of a group of options, checked."""

    TITLE: ClassVar[str] = ''
    """Title of the group in help texts; empty for options of the command itself."""

    def __post_init__(self) -> None:
        """Check the values; raise SetcmasError if one is invalid or they contradict each other."""
        for one in fields(self):
            value = getattr(self, one.name)
            kept: Option = one.metadata['option']
            if value is not None or one.default is not None:
                kept.check(one.name, value)
        self.check()

    def check(self) -> None:
        """Raise ClashError if the values contradict each other."""

    @classmethod
    def add_to(
        cls,
        parser: argparse.ArgumentParser,
        without: Container[str] = (),
        quiet: bool = False,
        **defaults: Any,
    ) -> None:
        """Add the options to a command line, the class's own before inherited ones.

        `without` has names to leave out, `defaults` other defaults. If `quiet`, the parsed
        arguments lack options that are not typed.
        """
        group = _argument_group(parser, cls.TITLE)
        for one in _in_order(cls):
            if one.name not in without:
                kept: Option = one.metadata['option']
                default = defaults.get(one.name, default_of(one))
                kept.add_to(group, one.name, kept.flag or spelled(one.name), default, quiet)

    @classmethod
    def of(cls: type[Group], args: argparse.Namespace) -> Group:
        """Return the values in parsed arguments, or defaults; raise SetcmasError for a clash."""
        with typed_words():
            return cls.among(cls.typed(args))

    @classmethod
    def typed(cls, args: argparse.Namespace) -> dict[str, Any]:
        """Return the values in parsed arguments by name."""
        found = {}
        for name, one in cls.options().items():
            if name in args:
                value = getattr(args, name)
                found[name] = one.kind.gathered(value) if isinstance(value, list) else value
        return found

    @classmethod
    def options(cls) -> dict[str, Option]:
        """Return the options by name, the class's own before inherited ones."""
        return {one.name: one.metadata['option'] for one in _in_order(cls)}

    @classmethod
    def among(cls: type[Group], values: Mapping[str, Any]) -> Group:
        """Pick the group's values from others by name; missing ones have their defaults."""
        return cls(**{one.name: values[one.name] for one in fields(cls) if one.name in values})

    def values(self) -> dict[str, Any]:
        """Return the values by name."""
        return {one.name: getattr(self, one.name) for one in fields(self)}

    def arguments(self, *others: Options) -> list[str]:
        """Return the arguments that pass these values, and other groups', to a child process."""
        given = {k: plain(v) for group in (self, *others) for k, v in group.changed().items()}
        return [VALUES, yaml_line(given)] if given else []

    def changed(self) -> dict[str, Any]:
        """Return the values that differ from their defaults, by name."""
        return {
            one.name: getattr(self, one.name)
            for one in _in_order(type(self))
            if differs(getattr(self, one.name), default_of(one))
        }

    def record(self) -> dict[str, Any]:
        """Return the values by name for run.yaml; None for a default of inf."""
        values = {one.name: (getattr(self, one.name), one.default) for one in fields(self)}
        return {
            name: None if default == math.inf and not differs(value, default) else plain(value)
            for name, (value, default) in values.items()
        }


VALUES = '--values'
"""The argument with the values of a child process by name, as YAML: `Options.arguments`."""


def take_values(parser: argparse.ArgumentParser) -> None:
    """Let a command line accept `Options.arguments`."""
    parser.add_argument(VALUES, action=_TakeValues, help=argparse.SUPPRESS)


class _TakeValues(argparse.Action):
    """Reads each value as in a scenario file."""

    def __call__(
        self, parser: argparse.ArgumentParser, namespace: argparse.Namespace, values: Any, *_: Any
    ) -> None:
        actions = {one.dest: one for one in parser._actions if hasattr(one, 'option')}
        try:
            for name, entry in entries_of(values, Path(VALUES)).fields(actions).items():
                setattr(namespace, name, actions[name].option.read(entry, str))
                actions[name].required = False
        except SetcmasError as error:
            parser.error(str(error))


def _in_order(group: type[Options]) -> list[Field[Any]]:
    """Return the fields of a group, its own before inherited ones."""
    inherited = {name for base in group.__bases__ for name in getattr(base, '__annotations__', ())}
    return sorted(fields(group), key=lambda one: one.name in inherited)


def _argument_group(parser: argparse.ArgumentParser, title: str) -> argparse._ArgumentGroup:
    """Return the parser's group with a title; several groups of options may share it."""
    if not title:
        return parser._optionals
    titled = (group for group in parser._action_groups if group.title == title)
    return next(titled, None) or parser.add_argument_group(title)


def differs(value: Any, other: Any) -> bool:
    """Return whether two values of an option differ; matrices are compared as lists."""
    return bool(plain(value) != plain(other))


@contextmanager
def typed_words() -> Iterator[None]:
    """Show options in messages as the user types them: raise SetcmasError for a ClashError."""
    try:
        yield
    except ClashError as error:
        raise SetcmasError(error.typed) from None
