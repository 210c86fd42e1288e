"""Groups of options, each a dataclass: its fields say all that is known of them.

From a group come the arguments of a command line, the parsed values, the command line of a process
that is to have the same values, what run.yaml records, and the checks of a Python function.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Container, Iterable
from dataclasses import MISSING, Field, dataclass, field, fields
from enum import Enum
from pathlib import Path
from typing import Any, ClassVar, TypeVar

from setcmas_simu.errors import SetcmasError
from setcmas_simu.options.kinds import Kind

Group = TypeVar('Group', bound='Options')
Completer = Callable[..., Iterable[str]]


class ClashError(SetcmasError):
    """Options that do not go together.

    Attributes:
        typed: The message in the words of the command line.
    """

    def __init__(self, message: str, *names: str) -> None:
        """Fill the names of options into a message, in the words of Python."""
        super().__init__(message.format(*names))
        self.typed = message.format(*map(spelled, names))


class Form(Enum):
    """How an option is typed."""

    ONE = 'with a value'
    FLAG = 'alone; it is off without'
    SWITCH = 'alone; --no- before its name turns it off'
    REPEATED = 'with a value, any number of times'
    SEVERAL = 'with one or more values'


@dataclass(frozen=True)
class Option:
    """What is known of an option besides its name and default.

    Attributes:
        kind: The values that it takes.
        help: Its help text, without unit and default.
        form: How it is typed.
        default_text: What the help text says of the default if that tells nothing by itself.
        alone: The value that the name without a value means; None if that is a mistake.
        short: Another name, such as '-o'.
        flag: What is typed, where that is not the name.
        complete: Offers values to argcomplete, if they are no files and no list of words.
    """

    kind: Kind
    help: str
    form: Form = Form.ONE
    default_text: str = ''
    alone: str | None = None
    short: str = ''
    flag: str = ''
    complete: Completer | None = None

    def add_to(self, group: argparse._ArgumentGroup, name: str, default: Any) -> None:
        """Add the option to a command line; it is required if its default is MISSING."""
        flag = self.flag or spelled(name)
        known: dict[str, Any] = {'dest': name, 'help': self._help(default)}
        if self.form in (Form.FLAG, Form.SWITCH):
            switch = argparse.BooleanOptionalAction
            known['action'] = 'store_true' if self.form is Form.FLAG else switch
            known['default'] = default
        else:
            known['type'] = self._type(flag)
            known['metavar'] = self.kind.metavar or _of_unit(self.kind)
            known['choices'] = None if known['metavar'] else self.kind.choices or None
            known |= self._counted(default)
        action = group.add_argument(*filter(None, (self.short, flag)), **known)
        if self.complete:
            action.completer = self.complete  # type: ignore[attr-defined]  # argcomplete's

    def _counted(self, default: Any) -> dict[str, Any]:
        if default is MISSING:
            return {'required': True}
        if self.form is Form.REPEATED:
            return {'default': list(default), 'action': 'append'}
        if self.form is Form.SEVERAL:
            return {'default': default, 'nargs': '+'}
        if self.alone is not None:
            return {'default': default, 'nargs': '?', 'const': self.alone}
        return {'default': default}

    def _help(self, default: Any) -> str:
        text = self.default_text
        if not text and self.form in (Form.ONE, Form.SEVERAL) and default not in (MISSING, None):
            several = default if self.form is Form.SEVERAL else [default]
            unit = getattr(self.kind, 'unit', '')
            text = f'{" ".join(map(self.kind.text, several))} {unit}'.rstrip()
        return f'{self.help} (default: {text})' if text else self.help

    def _type(self, flag: str) -> Callable[[str], Any]:
        def parse(text: str) -> Any:
            value = self.kind.parse(text)
            try:
                self.kind.check(flag, value)
            except SetcmasError as error:
                raise argparse.ArgumentError(None, str(error)) from error
            return value

        return parse


def _of_unit(kind: Kind) -> str | None:
    return getattr(kind, 'unit', '').upper() or None


def spelled(name: str) -> str:
    """Return an option's name as it is typed."""
    return f'--{name.replace("_", "-")}'


def option(kind: Kind, help: str, *, default: Any = MISSING, **known: Any) -> Any:  # noqa: A002
    """Return a field of a group, for an option with a value.

    Args:
        kind: The values that it takes.
        help: Its help text.
        default: Its value where it is not given; it must be given if there is none.
        known: Further attributes of `Option`.
    """
    return field(default=default, metadata={'option': Option(kind, help, **known)})


def flag(help: str, default: bool = False, **known: Any) -> Any:  # noqa: A002
    """Return a field of a group, for an option that is typed without a value."""
    form = Form.SWITCH if default else Form.FLAG
    return field(default=default, metadata={'option': Option(Kind(), help, form, **known)})


@dataclass(frozen=True, kw_only=True)
class Options:
    """The values of a group of options, checked."""

    TITLE: ClassVar[str] = ''
    """What the group is called in help texts; empty: it belongs to the command itself."""

    def __post_init__(self) -> None:
        """Check the values.

        Raises:
            SetcmasError: One makes no sense, in the words of Python.
        """
        for one in fields(self):
            value = getattr(self, one.name)
            kept: Option = one.metadata['option']
            if kept.form is Form.ONE and (value is not None or one.default is not None):
                kept.kind.check(one.name, value)
        self.check()

    def check(self) -> None:
        """See that the values go together.

        Raises:
            ClashError: They do not.
        """

    @classmethod
    def add_to(
        cls, parser: argparse.ArgumentParser, without: Container[str] = (), **defaults: Any
    ) -> None:
        """Add the options to a command line, those of the class itself first.

        Args:
            parser: That of the command line.
            without: Names of options that it does not have.
            defaults: Defaults that are others there.
        """
        group = _argument_group(parser, cls.TITLE)
        for one in _in_order(cls):
            if one.name not in without:
                kept: Option = one.metadata['option']
                kept.add_to(group, one.name, defaults.get(one.name, one.default))

    @classmethod
    def of(cls: type[Group], args: argparse.Namespace) -> Group:
        """Return the values in parsed arguments, and defaults for options that these lack.

        Raises:
            SetcmasError: Options do not go together.
        """
        given = {one.name: getattr(args, one.name) for one in fields(cls) if one.name in args}
        try:
            return cls(**{n: tuple(v) if isinstance(v, list) else v for n, v in given.items()})
        except ClashError as error:
            raise SetcmasError(error.typed) from None

    def values(self) -> dict[str, Any]:
        """Return the values by name."""
        return {one.name: getattr(self, one.name) for one in fields(self)}

    def arguments(self) -> list[str]:
        """Return the command line of a process that is to have the same values."""
        line: list[str] = []
        for name, (kept, value) in self._changed().items():
            line += _typed(kept, kept.flag or spelled(name), value)
        return line

    def changed(self) -> list[str]:
        """Return the names of the options that differ from their defaults."""
        return list(self._changed())

    def _changed(self) -> dict[str, tuple[Option, Any]]:
        return {
            one.name: (one.metadata['option'], getattr(self, one.name))
            for one in fields(self)
            if getattr(self, one.name) != one.default
        }

    def record(self) -> dict[str, Any]:
        """Return what run.yaml records: the values by name, None for a default of inf."""
        values = {one.name: (getattr(self, one.name), one.default) for one in fields(self)}
        return {
            name: None if default == math.inf == value else _plain(value)
            for name, (value, default) in values.items()
        }


def _in_order(group: type[Options]) -> list[Field[Any]]:
    """Return the fields of a group, its own before those of the groups that it extends."""
    inherited = {name for base in group.__bases__ for name in getattr(base, '__annotations__', ())}
    return sorted(fields(group), key=lambda one: one.name in inherited)


def _argument_group(parser: argparse.ArgumentParser, title: str) -> argparse._ArgumentGroup:
    """Return the argument group of a title, whichever group of options added it."""
    if not title:
        return parser._optionals
    titled = (group for group in parser._action_groups if group.title == title)
    return next(titled, None) or parser.add_argument_group(title)


def _typed(kept: Option, flag: str, value: Any) -> list[str]:
    """Return how an option with a value is typed; with = as a value may begin with a dash."""
    if kept.form in (Form.FLAG, Form.SWITCH):
        return [flag if value else f'--no-{flag[2:]}']
    if kept.form is Form.SEVERAL:
        return [flag, *map(kept.kind.text, value)]
    several = value if kept.form is Form.REPEATED else [value]
    return [f'{flag}={kept.kind.text(one)}' for one in several]


def _plain(value: Any) -> Any:
    """Return a value as YAML has it."""
    if isinstance(value, tuple):
        return [_plain(one) for one in value]
    return str(value) if isinstance(value, Path) else value
