"""Names that a study varies, of options and of variables of scripts, and their values."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from setcmas_ctrl.laws.control_law import LawScripts
from setcmas_ctrl.laws.script_loader import names_to_set
from setcmas_ctrl.laws.script_settings import parse_setting
from setcmas_simu.errors import SetcmasError, did_you_mean
from setcmas_simu.option_kinds import Number, Whole
from setcmas_simu.options import Form
from setcmas_tools.scenario.scenario import Scenario, options

SETTING, OPTION = 'set.', 'option.'
"""Prefixes for names that are both an option and a variable of the script."""


def names_of_scripts(algo: str, exercise: bool = False) -> set[str]:
    """Return the variables that the scripts of `--algo` assign, or raise SetcmasError."""
    paths = LawScripts(algo, exercise).paths
    return {name for path in paths for name in names_to_set(path)}


_NOT_VARIED = ('set', 'exercise', 'pose', 'cmd_timeout', 'rtf')
OPTIONS = {name: one for name, one in options().items() if name not in _NOT_VARIED}
"""The values of a scenario that a study can vary, by name."""


def is_setting(name: str) -> bool:
    """Return whether a varied name is a variable of the script."""
    return name.startswith(SETTING) or plain(name) not in OPTIONS


def plain(name: str) -> str:
    """Return a name without its prefix."""
    return name.removeprefix(SETTING).removeprefix(OPTION)


def checked_name(name: str, script_names: Collection[str]) -> str:
    """Return a varied name with _ for - in options, or raise SetcmasError if unknown or both."""
    own = plain(name)
    option = own.replace('-', '_')
    if option in OPTIONS and not name.startswith(SETTING):
        if own in script_names and not name.startswith(OPTION):
            raise SetcmasError(
                f'--vary {name}: both an option and a variable of the script; write '
                f"'{OPTION}{name}' or '{SETTING}{name}'"
            )
        return name.replace('-', '_')
    if own in script_names and not name.startswith(OPTION):
        return name
    known = [*OPTIONS, *script_names]
    raise SetcmasError(
        f'--vary {name}: unknown name{did_you_mean(own, known, 2) or ";"} options are '
        f'{", ".join(OPTIONS)}; names of the script: {", ".join(sorted(script_names)) or "none"}'
    )


def value_of(name: str, value: Any) -> Any:
    """Convert a text, a number or a value from Python for its option, or raise SetcmasError."""
    if is_setting(name):
        text = f'{plain(name)}={value}'
        return parse_setting(text)[1] if isinstance(value, str) else value
    option = OPTIONS[plain(name)]
    if option.form is Form.FLAG:
        return _truth(name, value)
    if callable(value):
        return value
    is_number = isinstance(option.kind, (Number, Whole))
    if is_number and isinstance(value, str):
        value = option.kind.parse(value)
    value = option.value(value)
    if is_number:
        option.kind.check(f'--vary {name}', value)
    return str(value) if isinstance(value, Path) else value


def _truth(name: str, value: Any) -> bool:
    known = yaml.safe_load(value) if isinstance(value, str) else value
    if not isinstance(known, bool):
        raise SetcmasError(f'--vary {name} is {value!r}; it must be yes or no')
    return known


def with_values(base: Scenario, values: Mapping[str, Any]) -> Scenario:
    """Return a scenario with varied values, or raise SetcmasError if they contradict."""
    changes = {plain(name): value for name, value in values.items() if not is_setting(name)}
    settings = {plain(name): value for name, value in values.items() if is_setting(name)}
    return base.replace(**changes, set={**base.law.set, **settings})


_NUMBER = r'[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?'
_RANGE = re.compile(rf'(log:)?({_NUMBER}):({_NUMBER}):(\d+)')
_MISTAKEN = re.compile(rf'(?:log:{_NUMBER}|{_NUMBER}:{_NUMBER})(?::{_NUMBER})*')
_DIGITS = 12  # so that 0.2:2:10 has 0.4 instead of 0.4000000000000001


def parse_values(name: str, text: str) -> list[Any]:
    """Return the values in a text such as '0.2:2:10' or '0,0.2,0.4', or raise SetcmasError.

    Values of a list stay strings unless the list is YAML, such as '[[1, 2], [3, 4]]'.
    """
    if found := _RANGE.fullmatch(text):
        return _range(name, text, bool(found[1]), float(found[2]), float(found[3]), int(found[4]))
    values: Any = text.split(',')
    if text.startswith('['):
        values = []
        with suppress(yaml.YAMLError):
            values = yaml.safe_load(text)
    empty = not values or not all(str(value).strip() for value in values)
    if empty or _MISTAKEN.fullmatch(text):
        raise SetcmasError(
            f"--vary {name} '{text}' must be a list (0,0.2,0.4), or a range FIRST:LAST:COUNT or "
            'log:FIRST:LAST:COUNT'
        )
    return [value.strip() if isinstance(value, str) else value for value in values]


def _range(name: str, text: str, log: bool, first: float, last: float, count: int) -> list[float]:
    if count < 1 or (log and not (first > 0 and last > 0)):
        more = ' with bounds above 0' if log else ''
        raise SetcmasError(f"--vary {name} '{text}' must be a range of 1 value or more{more}")
    numbers = np.geomspace(first, last, count) if log else np.linspace(first, last, count)
    return [float(f'{number:.{_DIGITS}g}') for number in numbers.tolist()]
