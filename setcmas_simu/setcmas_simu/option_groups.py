"""Groups of options: the base class of files named ..._options.py, which declare the options.

A group is a dataclass whose fields are options. It adds them to a command line, checks their
values, and writes them for child processes and run.yaml.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Container, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import MISSING, Field, astuple, dataclass, field, fields, is_dataclass
from enum import Enum
from pathlib import Path
from typing import Any, ClassVar, TypeVar

import numpy as np

from setcmas_simu.errors import SetcmasError
from setcmas_simu.option_kinds import Kind
from setcmas_simu.yaml_entries import Entry, entries_of, yaml_line

Group = TypeVar('Group', bound='Options')


class ClashError(SetcmasError):
    """Options contradict each other; `typed` is the message with their names as typed."""

    def __init__(self, message: str, *names: str) -> None:
        super().__init__(message, *names)
        self.names = names
        self.typed = message.format(*map(spelled, names))

    def __str__(self) -> str:
        return str(self.args[0]).format(*self.names)


@contextmanager
def typed_words() -> Iterator[None]:
    """Show options in messages as the user types them: raise SetcmasError for a ClashError."""
    try:
        yield
    except ClashError as error:
        raise SetcmasError(error.typed) from None


def spelled(name: str) -> str:
    """Return an option's name as typed, such as --nb-robots."""
    return f'--{name.replace("_", "-")}'


class Form(Enum):
    """How an option is typed."""

    ONE = 'with a value'
    FLAG = 'alone; --no- before its name turns it off if it is on by default'
    REPEATED = 'with a value, any number of times'
    SEVERAL = 'with one or more values'


@dataclass(frozen=True)
class Option:
    """An option; the field of its group has its name and default.

    Attributes:
        kind: Kind of its values.
        help: Its help text, without unit and default.
        form: How it is typed.
        default_text: The default in words, if its value says nothing by itself.
        alone: The value if only the name is typed; None if that is a mistake.
        short: Another name, such as '-o'.
        flag: The name as typed, if it is not --NAME.
    """

    kind: Kind
    help: str
    form: Form = Form.ONE
    default_text: str = ''
    alone: str | None = None
    short: str = ''
    flag: str = ''

    @property
    def is_switch(self) -> bool:
        """Whether it is true or false."""
        return self.form is Form.FLAG

    @property
    def is_several(self) -> bool:
        """Whether it has several values."""
        return self.form in (Form.REPEATED, Form.SEVERAL)

    def value(self, given: Any) -> Any:
        """Convert a value from Python, YAML or text; a malformed text raises SetcmasError."""
        if given is None or self.is_switch:
            return given
        if self.is_several and isinstance(given, (list, tuple, str)):
            return self.gathered(
                map(self.kind.value, [given] if isinstance(given, str) else given)
            )
        return self.kind.value(given)

    def gathered(self, values: Iterable[Any]) -> Any:
        """Join several values; invalid ones stay a list, which `check` refuses."""
        several = list(values)
        return self.kind.gather(several) if all(map(self.kind.accepts, several)) else several

    def read(self, entry: Entry, place: Callable[[str], str]) -> Any:
        """Return the value of a YAML entry, or raise SetcmasError with file and line.

        `place` returns the path of a file that a text names, and other texts unchanged.
        """
        with entry.located():
            is_one = self.form is Form.ONE
            value = self.kind.read(entry, place) if is_one else self.value(entry.plain())
            self.check(entry.name, value)
            return value

    def check(self, name: str, value: Any) -> None:
        """Raise SetcmasError if a value is invalid."""
        if self.is_switch:
            if not isinstance(value, bool):
                raise SetcmasError(f'{name} is {value!r}; it must be true or false')
            return
        is_one = not self.is_several or isinstance(value, str) or not np.iterable(value)
        if isinstance(value, Mapping):
            is_one = is_one or self.kind.gather is not dict
            value = value if is_one else value.items()
        for one in [value] if is_one else value:
            self.kind.check(name, one)


def option(kind: Kind, help: str, *, default: Any = MISSING, **known: Any) -> Any:  # noqa: A002
    """Return a field of a group, for an option with a value; required without a default."""
    metadata = {'option': Option(kind, help, **known)}
    if isinstance(default, dict):
        return field(default_factory=default.copy, metadata=metadata)
    return field(default=default, metadata=metadata)


def flag(help: str, default: bool = False) -> Any:  # noqa: A002
    """Return a field of a group, for an option that is typed without a value."""
    return field(default=default, metadata={'option': Option(Kind(), help, Form.FLAG)})


def default_of(one: Field[Any]) -> Any:
    """Return the default of a field of a group; MISSING if there is none."""
    return one.default if one.default_factory is MISSING else one.default_factory()


@dataclass(frozen=True, kw_only=True)
class Options:
    """The values of a group of options, checked."""

    TITLE: ClassVar[str] = ''
    """Title of the group in help texts; empty for options of the command itself."""

    def __post_init__(self) -> None:
        """Check the values; raise SetcmasError if one is invalid or they contradict each other."""
        for one in fields(self):
            value = getattr(self, one.name)
            if value is not None or one.default is not None:
                one.metadata['option'].check(one.name, value)
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
                default = defaults.get(one.name, default_of(one))
                _add(group, one.name, one.metadata['option'], default, quiet)

    @classmethod
    def of(cls: type[Group], args: argparse.Namespace) -> Group:
        """Return the values in parsed arguments, or defaults; raise SetcmasError for a clash."""
        with typed_words():
            return cls.among(cls.typed(args))

    @classmethod
    def typed(cls, args: argparse.Namespace) -> dict[str, Any]:
        """Return the values in parsed arguments by name."""
        found = {name: getattr(args, name) for name in cls.options() if name in args}
        several = {k: cls.options()[k].gathered(v) for k, v in found.items() if type(v) is list}
        return found | several

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
        found = {one.name: (getattr(self, one.name), one) for one in _in_order(type(self))}
        return {k: v for k, (v, one) in found.items() if plain(v) != plain(default_of(one))}

    def record(self) -> dict[str, Any]:
        """Return the values by name for run.yaml; None for a default of inf."""
        infinite = {one.name for one in fields(self) if one.default == math.inf}
        return {
            name: None if name in infinite and value == math.inf else plain(value)
            for name, value in self.values().items()
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


def _add(
    group: argparse._ArgumentGroup, name: str, one: Option, default: Any, quiet: bool
) -> None:
    """Add an option to a command line; it is required if the default is MISSING."""
    typed = one.flag or spelled(name)
    known: dict[str, Any] = {'dest': name, 'default': default, 'help': _help(one, default)}
    if one.is_switch:
        known['action'] = argparse.BooleanOptionalAction if default else 'store_true'
    else:
        known['type'] = _parser_of(one.kind, typed)
        known['metavar'] = one.kind.metavar or getattr(one.kind, 'unit', '').upper() or None
        known['choices'] = None if known['metavar'] else one.kind.choices or None
        known |= {'nargs': '?', 'const': one.alone} if one.alone is not None else {}
        known |= {'nargs': '+'} if one.form is Form.SEVERAL else {}
        known |= {'action': 'append', 'default': []} if one.form is Form.REPEATED else {}
        known |= {'required': True, 'default': None} if default is MISSING else {}
    if quiet:
        known |= {'default': argparse.SUPPRESS, 'required': False}
    action = group.add_argument(*filter(None, (one.short, typed)), **known)
    action.option = one  # type: ignore[attr-defined]  # for VALUES


def _help(one: Option, default: Any) -> str:
    text = one.default_text
    if not text and one.form in (Form.ONE, Form.SEVERAL) and default not in (MISSING, None):
        several = default if one.form is Form.SEVERAL else [default]
        words = ' '.join(str(value).removesuffix('.0') for value in several)
        text = f'{words} {getattr(one.kind, "unit", "")}'.rstrip()
    return f'{one.help} (default: {text})' if text else one.help


def _parser_of(kind: Kind, typed: str) -> Callable[[str], Any]:
    def parse(text: str) -> Any:
        try:
            value = kind.value(text)
            kind.check(typed, value)
        except SetcmasError as error:
            raise argparse.ArgumentError(None, str(error)) from error
        return value

    return parse


def plain(value: Any) -> Any:
    """Return a value of an option as YAML has it; functions stay unchanged."""
    if isinstance(value, Mapping):
        return {key: plain(one) for key, one in value.items()}
    if isinstance(value, (tuple, list)):
        return [plain(one) for one in value]
    if is_dataclass(value) and not isinstance(value, type):
        return list(astuple(value))
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    return str(value) if isinstance(value, Path) else value
