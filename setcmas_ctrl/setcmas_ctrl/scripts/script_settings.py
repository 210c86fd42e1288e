"""Values for names of a script (`--set kp=1.2 --set 'WPL=[[1,1],[2,2]]'`) in place of its own.

A value takes the place of the script's own wherever the top level of the script assigns the name,
so that what the script derives from it (`PERIOD = 2 * pi / W`) follows.
"""

from __future__ import annotations

import ast
import copy
import difflib
import re
import symtable
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import yaml

from setcmas_simu.errors import SetcmasError

Settings = Mapping[str, Any]

CALL = '__setcmas_setting__'
"""The builtin that the added lines call with a name and the script's own value."""

# YAML 1.1 reads 1e-3 as a text.
_NUMBER = re.compile(r'[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?')
_KINDS: tuple[tuple[type | tuple[type, ...], str], ...] = (
    ((bool, np.bool_), 'true or false'),
    ((int, float, np.number), 'a number'),
    (str, 'a text'),
    ((list, tuple, np.ndarray), 'a list'),
    (dict, 'a mapping'),
    (type(None), 'nothing'),
)
_FORM = "NAME=VALUE, such as kp=1.2 or 'WPL=[[1, 1], [2, 2]]'"


def parse_settings(texts: Sequence[str]) -> dict[str, Any]:
    """Return the names and values of texts such as 'kp=1.2'; the last of a name counts.

    Raises:
        SetcmasError: A text has another form.
    """
    settings = {}
    for text in texts:
        name, equals, value = text.partition('=')
        if not (equals and name.strip().isidentifier() and value.strip()):
            raise SetcmasError(f"--set '{text}' is not understood; it must be {_FORM}")
        try:
            settings[name.strip()] = _with_numbers(yaml.safe_load(value))
        except yaml.YAMLError as error:
            reason = getattr(error, 'problem', None) or 'it is not YAML'
            raise SetcmasError(
                f"--set '{text}': the value cannot be read ({reason}); it must be {_FORM}"
            ) from error
    return settings


def _with_numbers(value: Any) -> Any:
    if isinstance(value, list):
        return [_with_numbers(item) for item in value]
    if isinstance(value, dict):
        return {key: _with_numbers(item) for key, item in value.items()}
    return float(value) if isinstance(value, str) and _NUMBER.fullmatch(value) else value


def apply_settings(tree: ast.Module, source: str, settings: Settings, script: str) -> None:
    """Let a script take other values for names of its top level: `W = 0.5` gets a next line.

    A mapping as the script's variables would do without the lines, but Python passes it over for
    names that a function declares `global`.

    Args:
        tree: The script, not compiled yet; it is changed.
        source: Its text.
        settings: The names and their values.
        script: What the script is called in messages.

    Raises:
        SetcmasError: The script does not assign a name, or gives it a value of another kind, as
            far as can be told without running it.
    """
    symbols = _symbols(source, script)
    plain = plain_names(source, script)
    for name, value in settings.items():
        if name not in plain:
            raise SetcmasError(f'--set {name}: {_refusal(name, symbols.get(name), plain, script)}')
        for own in _literals(tree, name):
            converted(name, own, value, script)
    ast.fix_missing_locations(_NextLines(settings).visit(tree))


def plain_names(source: str, script: str) -> list[str]:
    """Return the names that the top level of a script assigns, so that they can be set."""
    return [name for name, symbol in _symbols(source, script).items() if _is_variable(symbol)]


def _symbols(source: str, script: str) -> dict[str, symtable.Symbol]:
    return {s.get_name(): s for s in symtable.symtable(source, script, 'exec').get_symbols()}


class _NextLines(ast.NodeTransformer):
    """Adds a line behind each statement of the top level that assigns a name that is set."""

    def __init__(self, settings: Settings) -> None:
        self._settings = settings

    def visit(self, node: ast.AST) -> Any:
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef, ast.expr)):
            return node
        self.generic_visit(node)
        if not isinstance(node, ast.stmt):
            return node
        return [node, *(self._line(name, node) for name in self._settings if _assigns(node, name))]

    def _line(self, name: str, after: ast.stmt) -> ast.stmt:
        # A loop that never ran assigns nothing.
        line = ast.parse(f'if {name!r} in globals(): {name} = {CALL}({name!r}, {name})').body[0]
        for part in ast.walk(line):
            ast.copy_location(part, after)
        return line


def _assigns(node: ast.stmt, name: str) -> bool:
    """Return whether a statement itself, not those inside it, assigns a name."""
    inner = (ast.stmt, ast.excepthandler, ast.match_case)
    own = [part for part in ast.iter_child_nodes(node) if not isinstance(part, inner)]
    return any(
        isinstance(part, ast.Name) and part.id == name and isinstance(part.ctx, ast.Store)
        for child in own
        for part in ast.walk(child)
    )


def _is_variable(symbol: symtable.Symbol) -> bool:
    return symbol.is_assigned() and not symbol.is_imported() and not symbol.is_namespace()


def _refusal(name: str, symbol: symtable.Symbol | None, plain: list[str], script: str) -> str:
    names = ', '.join(sorted(plain)) or 'none'
    if symbol and symbol.is_imported():
        return f'{script} imports it; it must be a name that {script} itself assigns: {names}'
    if symbol and symbol.is_namespace():
        return f'in {script} it is a function or a class; it must be a plain value: {names}'
    lower = {own.lower(): own for own in plain}
    near = [lower[own] for own in difflib.get_close_matches(name.lower(), lower, n=3)]
    hint = f'did you mean {" or ".join(near)}? ' if near else ''
    return f"{script} has no module-level name '{name}'; {hint}it has {names}"


def converted(name: str, own: Any, value: Any, script: str) -> Any:
    """Return a value for a name, of the type that the script's own value has.

    Raises:
        SetcmasError: It is of another kind, such as a text for a number.
    """
    wanted, given = _kind(own), _kind(value)
    if wanted is None:
        raise SetcmasError(
            f'--set {name}: in {script} it is a {type(own).__name__}; it must be a name '
            'with a plain value'
        )
    if own is not None and wanted != given:
        raise SetcmasError(
            f'--set {name}: {value!r} is {given or "no plain value"}; in {script} {name} is '
            f'{own!r}, so it must be {wanted}'
        )
    if isinstance(own, np.ndarray):
        return np.array(value, dtype=np.result_type(own.dtype, np.asarray(value).dtype))
    if isinstance(own, tuple) and isinstance(value, list):
        return tuple(value)
    return copy.deepcopy(value)  # every robot has its own


def _kind(value: Any) -> str | None:
    return next((kind for types, kind in _KINDS if isinstance(value, types)), None)


def _literals(tree: ast.Module, name: str) -> Iterator[Any]:
    """Yield the values that the top level gives a name, where they stand there as such."""
    for node in tree.body:
        if isinstance(node, (ast.Assign, ast.AnnAssign)) and node.value:
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            if any(isinstance(target, ast.Name) and target.id == name for target in targets):
                try:
                    yield ast.literal_eval(node.value)
                except (ValueError, TypeError, RecursionError, MemoryError):
                    continue
