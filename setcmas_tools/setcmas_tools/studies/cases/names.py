"""Names for a study to vary: options of a run, and names of its control scripts."""

from __future__ import annotations

import difflib
import inspect
from collections.abc import Collection, Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any

import yaml

from setcmas_ctrl.communication.options import CommunicationOptions
from setcmas_ctrl.control.law_scripts import LawScripts
from setcmas_ctrl.control.options import LawOptions
from setcmas_ctrl.filter.options import FilterOptions
from setcmas_ctrl.scripts.loader import names_to_set
from setcmas_ctrl.scripts.settings import parse_settings
from setcmas_simu.errors import SetcmasError
from setcmas_simu.options.kinds import Number, Whole
from setcmas_simu.options.option import Form, Option
from setcmas_simu.simulator.options import SimulationOptions
from setcmas_tools.offline.engine import simulate
from setcmas_tools.run.options import RunOptions

SETTING, OPTION = 'set.', 'option.'
"""What stands before a name that is both, to say which is meant."""


def names_of_scripts(algo: str, exercise: bool = False) -> set[str]:
    """Return what the control scripts assign that `--algo` means.

    Raises:
        SetcmasError: There is no such script, or it has a mistake.
    """
    paths = LawScripts(algo, exercise).paths
    return {name for path in paths for name in names_to_set(path)}


def varied_options() -> dict[str, Option]:
    """Return the options of a run that a study can vary, by name."""
    groups = (LawOptions, CommunicationOptions, FilterOptions, SimulationOptions, RunOptions)
    found = {one.name: one.metadata['option'] for group in groups for one in fields(group)}
    taken = inspect.signature(simulate).parameters
    return {name: option for name, option in found.items() if name in taken}


OPTIONS = varied_options()


def is_setting(name: str) -> bool:
    """Return whether a varied name is that of the script."""
    return name.startswith(SETTING) or plain(name) not in OPTIONS


def plain(name: str) -> str:
    """Return a name without what tells options from names of the script."""
    return name.removeprefix(SETTING).removeprefix(OPTION)


def checked_name(name: str, script_names: Collection[str]) -> str:
    """Return a name that is varied, with _ for - in options.

    Args:
        name: As it was typed.
        script_names: What the control scripts assign.

    Raises:
        SetcmasError: It is neither an option nor a name of the script, or both.
    """
    own = plain(name)
    option = own.replace('-', '_')
    if option in OPTIONS and not name.startswith(SETTING):
        if own in script_names and not name.startswith(OPTION):
            raise SetcmasError(
                f'--vary {name}: it is an option and a name of the script; it must be '
                f"'{OPTION}{name}' or '{SETTING}{name}'"
            )
        return name.replace('-', '_')
    if own in script_names and not name.startswith(OPTION):
        return name
    known = [*OPTIONS, *script_names]
    near = difflib.get_close_matches(own, known, n=2)
    hint = f'did you mean {" or ".join(near)}? ' if near else ''
    raise SetcmasError(
        f'--vary {name}: there is no such name; {hint}options are {", ".join(OPTIONS)}; names of '
        f'the script are {", ".join(sorted(script_names)) or "none"}'
    )


def value_of(name: str, value: Any) -> Any:
    """Return a value for a name as its option or the script takes it.

    Args:
        name: What is varied.
        value: A text, a number of a range, or anything else that Python has given.

    Raises:
        SetcmasError: The option takes no such value.
    """
    if is_setting(name):
        text = f'{plain(name)}={value}'
        return parse_settings([text])[plain(name)] if isinstance(value, str) else value
    option = OPTIONS[plain(name)]
    if option.form is Form.FLAG:
        return _truth(name, value)
    if isinstance(option.kind, Whole) and isinstance(value, float) and value.is_integer():
        value = int(value)
    if isinstance(value, str):
        value = option.kind.parse(value)
    if isinstance(option.kind, (Number, Whole)) and not callable(value):
        option.kind.check(f'--vary {name}', value)
    return str(value) if isinstance(value, Path) else value


def _truth(name: str, value: Any) -> bool:
    known = yaml.safe_load(value) if isinstance(value, str) else value
    if not isinstance(known, bool):
        raise SetcmasError(f'--vary {name} is {value!r}; it must be yes or no')
    return known


def with_values(parameters: Mapping[str, Any], values: Mapping[str, Any]) -> dict[str, Any]:
    """Return parameters of a run with the varied ones in their place, settings under 'set'."""
    options = {plain(name): value for name, value in values.items() if not is_setting(name)}
    settings = {plain(name): value for name, value in values.items() if is_setting(name)}
    return {**parameters, **options, 'set': {**parameters['set'], **settings}}
