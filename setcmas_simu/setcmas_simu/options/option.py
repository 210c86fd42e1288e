"""An option: the kind of its values, its help text, and how it is typed."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable, Mapping
from dataclasses import MISSING, astuple, dataclass, is_dataclass
from enum import Enum
from pathlib import Path
from typing import Any

import numpy as np

from setcmas_simu.errors import SetcmasError
from setcmas_simu.options.kinds import Kind
from setcmas_simu.yaml_entries import Entry

Completer = Callable[..., Iterable[str]]


class Form(Enum):
    """How an option is typed."""

    ONE = 'with a value'
    FLAG = 'alone; it is off without'
    SWITCH = 'alone; --no- before its name turns it off'
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
        complete: Offers values to argcomplete; None for files and listed words.
    """

    kind: Kind
    help: str
    form: Form = Form.ONE
    default_text: str = ''
    alone: str | None = None
    short: str = ''
    flag: str = ''
    complete: Completer | None = None

    @property
    def is_switch(self) -> bool:
        """Whether it is true or false."""
        return self.form in (Form.FLAG, Form.SWITCH)

    @property
    def is_several(self) -> bool:
        """Whether it has several values."""
        return self.form in (Form.REPEATED, Form.SEVERAL)

    def value(self, given: Any) -> Any:
        """Convert a value from Python, YAML or text; a malformed text raises SetcmasError."""
        if given is None or self.is_switch:
            return given
        if self.is_several and isinstance(given, (list, tuple, str)):
            several = [given] if isinstance(given, str) else given
            return self.kind.gathered(map(self.kind.value, several))
        return self.kind.value(given)

    def read(self, entry: Entry, place: Callable[[str], str]) -> Any:
        """Return the value of a YAML entry, or raise SetcmasError with file and line.

        `place` returns the path of a file that a text names, and other texts unchanged.
        """
        with entry.located():
            if self.form is Form.ONE:
                value = self.kind.read(entry, place)
            else:
                value = self.value(entry.plain())
            self.check(entry.name, value)
            return value

    def check(self, name: str, value: Any) -> None:
        """Raise SetcmasError if a value is invalid."""
        if self.is_switch and not isinstance(value, bool):
            raise SetcmasError(f'{name} is {value!r}; it must be true or false')
        if self.is_switch:
            return
        for one in self.kind.spread(value) if self.is_several else [value]:
            self.kind.check(name, one)

    def add_to(
        self,
        group: argparse._ArgumentGroup,
        name: str,
        flag: str,
        default: Any,
        quiet: bool = False,
    ) -> None:
        """Add the option to a command line, as `name` in the parsed arguments and typed as `flag`.

        It is required if the default is MISSING. If `quiet`, the arguments lack it unless typed.
        """
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
        if quiet:
            known |= {'default': argparse.SUPPRESS, 'required': False}
        action = group.add_argument(*filter(None, (self.short, flag)), **known)
        action.option = self  # type: ignore[attr-defined]  # for VALUES
        if self.complete:
            action.completer = self.complete  # type: ignore[attr-defined]  # argcomplete's

    def _counted(self, default: Any) -> dict[str, Any]:
        if default is MISSING:
            return {'required': True}
        if self.form is Form.REPEATED:
            return {'default': [*self.kind.spread(default)], 'action': 'append'}
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
            try:
                value = self.kind.parse(text)
                self.kind.check(flag, value)
            except SetcmasError as error:
                raise argparse.ArgumentError(None, str(error)) from error
            return value

        return parse


def names_and_files(
    names: Callable[[], Iterable[str]], endings: tuple[str, ...] = ()
) -> Callable[..., list[str]]:
    """Return a completer of names, looked up on demand, and of files with endings such as 'py'."""

    def complete(prefix: str, **_: Any) -> list[str]:
        from argcomplete.completers import FilesCompleter

        files = FilesCompleter(endings)(prefix) if endings else []
        return [*(name for name in names() if name.startswith(prefix)), *files]

    return complete


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


def _of_unit(kind: Kind) -> str | None:
    return getattr(kind, 'unit', '').upper() or None
