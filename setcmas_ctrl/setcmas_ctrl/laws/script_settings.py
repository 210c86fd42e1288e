"""Settings of scripts: `--set kp=1.2` replaces a value that the script assigns.

A new value replaces the script's wherever its top level assigns the name, so that values derived
from it (`PERIOD = 2 * pi / W`) follow.
"""

from __future__ import annotations

import ast
import copy
import re
import symtable
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import yaml

from setcmas_ctrl.laws.script_function import literals
from setcmas_simu.errors import SetcmasError, did_you_mean

Settings = Mapping[str, Any]

CALL = '__setcmas_setting__'
"""Builtin that the added lines call with a name and the script's own value."""

_KINDS: tuple[tuple[type | tuple[type, ...], str], ...] = (
    ((bool, np.bool_), 'true or false'),
    ((int, float, np.number), 'a number'),
    (str, 'a string'),
    ((list, tuple, np.ndarray), 'a list'),
    (dict, 'a mapping'),
    (type(None), 'nothing'),
)
_FORM = "NAME=VALUE, such as kp=1.2 or 'WPL=[[1, 1], [2, 2]]'"


class _Loader(yaml.SafeLoader):
    """Reads 1e-3 as a number; for YAML 1.1 it is a text."""


_NUMBER = re.compile(r'[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?$')
_Loader.add_implicit_resolver('tag:yaml.org,2002:float', _NUMBER, list('-+.0123456789'))


def parse_setting(text: str) -> tuple[str, Any]:
    """Return the name and the value of a text such as 'kp=1.2', or raise SetcmasError."""
    name, equals, value = text.partition('=')
    if not (equals and name.strip().isidentifier() and value.strip()):
        raise SetcmasError(f"invalid setting '{text}'; must be {_FORM}")
    try:
        return name.strip(), yaml.load(value, _Loader)
    except yaml.YAMLError as error:
        reason = getattr(error, 'problem', None) or 'not YAML'
        raise SetcmasError(
            f"setting '{text}': invalid value ({reason}); must be {_FORM}"
        ) from error


def apply_settings(tree: ast.Module, source: str, settings: Settings, script: str) -> None:
    """Make a script use other values: add a line after `W = 0.5` in its tree.

    Raises:
        SetcmasError: The script does not assign a name, or assigns a value of another kind, as
            far as can be seen without running it.
    """
    symbols = _symbols(source, script)
    plain = plain_names(source, script)
    for name, value in settings.items():
        if name not in plain:
            raise SetcmasError(
                f'setting {name}: {_refusal(name, symbols.get(name), plain, script)}'
            )
        for assigned, own in literals(tree):
            if assigned == name:
                converted(name, own, value, script)
    _WithSettings(settings).visit(tree)


def plain_names(source: str, script: str) -> list[str]:
    """Return the names that a script assigns at its top level, which `--set` may change."""
    return [
        name
        for name, symbol in _symbols(source, script).items()
        if symbol.is_assigned() and not symbol.is_imported() and not symbol.is_namespace()
    ]


def _symbols(source: str, script: str) -> dict[str, symtable.Symbol]:
    return {s.get_name(): s for s in symtable.symtable(source, script, 'exec').get_symbols()}


class _WithSettings(ast.NodeTransformer):
    """Adds a line for each name to set after the statements outside of functions that assign it.

    A mapping as the script's variables would avoid the extra lines, but Python bypasses it for
    names that a function declares `global`.
    """

    def __init__(self, settings: Settings) -> None:
        self._settings = settings

    def visit(self, node: ast.AST) -> Any:
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef, ast.expr)):
            return node
        self.generic_visit(node)
        return [node, *self._lines_after(node)] if isinstance(node, ast.stmt) else node

    def _lines_after(self, node: ast.stmt) -> Iterator[ast.stmt]:
        names = (part for part in ast.walk(node) if isinstance(part, ast.Name))
        assigned = {name.id for name in names if isinstance(name.ctx, ast.Store)}
        for name in self._settings.keys() & assigned:
            # A loop that never ran assigns nothing.
            text = f'if {name!r} in globals(): {name} = {CALL}({name!r}, {name})'
            line = ast.parse(text).body[0]
            for part in ast.walk(line):
                ast.copy_location(part, node)
            yield line


def _refusal(name: str, symbol: symtable.Symbol | None, plain: list[str], script: str) -> str:
    names = ', '.join(sorted(plain)) or 'none'
    if symbol and symbol.is_imported():
        return f'{script} imports it; choose a name that {script} assigns itself: {names}'
    if symbol and symbol.is_namespace():
        return f'in {script} it is a function or a class; choose a plain value: {names}'
    hint = did_you_mean(name, plain, 3)
    return f"{script} has no module-level name '{name}'; it has {names}{hint}"


def converted(name: str, own: Any, value: Any, script: str) -> Any:
    """Convert a value to the type of the script's own, or raise SetcmasError for other kinds."""
    wanted, given = _kind(own), _kind(value)
    if wanted is None:
        raise SetcmasError(
            f'setting {name}: in {script} it is a {type(own).__name__}; choose a name '
            'with a plain value'
        )
    if own is not None and wanted != given:
        raise SetcmasError(
            f'setting {name}: {value!r} is {given or "no plain value"}; it must be {wanted}, '
            f'since {script} has {name} = {own!r}'
        )
    if isinstance(own, np.ndarray):
        return np.array(value, dtype=np.result_type(own.dtype, np.asarray(value).dtype))
    if isinstance(own, tuple) and isinstance(value, list):
        return tuple(value)
    return copy.deepcopy(value)  # one for each robot


def _kind(value: Any) -> str | None:
    return next((kind for types, kind in _KINDS if isinstance(value, types)), None)
