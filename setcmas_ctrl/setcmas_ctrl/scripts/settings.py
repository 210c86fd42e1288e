"""Other values for a script's module-level names: `--set kp=1.2 --set 'WPL=[[1,1],[2,2]]'`.

A value replaces the script's own wherever the top level of the script assigns the name, so that
what the script derives from it (`PERIOD = 2 * pi / W`) follows.
"""

from __future__ import annotations

import ast
import copy
import difflib
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import yaml

from setcmas_simu.errors import SetcmasError

Settings = Mapping[str, Any]

CALL = '__setcmas_setting__'
"""The builtin that the compiled script calls for each name that is set."""

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
            raise SetcmasError(f"--set '{text}' is not understood; accepted is {_FORM}")
        try:
            settings[name.strip()] = _with_numbers(yaml.safe_load(value))
        except yaml.YAMLError as error:
            reason = getattr(error, 'problem', None) or 'it is not YAML'
            raise SetcmasError(
                f"--set '{text}': the value cannot be read ({reason}); accepted is {_FORM}"
            ) from error
    return settings


def _with_numbers(value: Any) -> Any:
    if isinstance(value, list):
        return [_with_numbers(item) for item in value]
    if isinstance(value, dict):
        return {key: _with_numbers(item) for key, item in value.items()}
    return float(value) if isinstance(value, str) and _NUMBER.fullmatch(value) else value


def apply_settings(tree: ast.Module, settings: Settings, script: str) -> None:
    """Let a script, not yet compiled, take other values for names of its top level.

    Args:
        tree: The script; a statement is inserted behind each that gives a name its value.
        settings: The names and their values.
        script: What the script is called in messages.

    Raises:
        SetcmasError: A name does not exist there, means a function or a module, or has a value
            of another kind.
    """
    known = {name: kind for node in _statements(tree.body) for name, kind in _bound(node)}
    for name, value in settings.items():
        if name not in known and '*' not in known:
            plain = sorted(name for name, kind in known.items() if kind is None)
            lower = {own.lower(): own for own in plain}
            near = [lower[own] for own in difflib.get_close_matches(name.lower(), lower, n=3)]
            hint = f'did you mean {" or ".join(near)}? ' if near else ''
            raise SetcmasError(
                f"--set {name}: {script} has no module-level name '{name}'; {hint}"
                f'it has {", ".join(plain) or "none that can be set"}'
            )
        if kind := known.get(name):
            raise SetcmasError(
                f'--set {name}: in {script} it is {kind}; accepted are names of plain values'
            )
        for own in _literals(tree, name):
            converted(name, own, value, script)
    _insert(tree.body, settings)
    ast.fix_missing_locations(tree)


def converted(name: str, own: Any, value: Any, script: str) -> Any:
    """Return a value for a name, of the type that the script's own value has.

    Raises:
        SetcmasError: It is of another kind, such as a text for a number.
    """
    wanted, given = _kind(own), _kind(value)
    if wanted is None:
        raise SetcmasError(
            f'--set {name}: in {script} it is a {type(own).__name__}; accepted are names of '
            'plain values'
        )
    if own is not None and wanted != given:
        raise SetcmasError(
            f'--set {name}: {value!r} is {given or "no plain value"}; in {script} {name} is '
            f'{own!r}, so accepted is {wanted}'
        )
    if isinstance(own, np.ndarray):
        return np.array(value, dtype=np.result_type(own.dtype, np.asarray(value).dtype))
    if isinstance(own, tuple) and isinstance(value, list):
        return tuple(value)
    return copy.deepcopy(value)  # every robot has its own


def _kind(value: Any) -> str | None:
    return next((kind for types, kind in _KINDS if isinstance(value, types)), None)


def _statements(body: list[ast.stmt]) -> Iterator[ast.stmt]:
    """Yield the statements of a script's top level, also inside if, for, while, with and try."""
    for node in body:
        yield node
        for inner in _bodies(node):
            yield from _statements(inner)


def _bodies(node: ast.AST) -> Iterator[list[ast.stmt]]:
    if not isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)):
        for field in ('body', 'orelse', 'finalbody'):
            if isinstance(body := getattr(node, field, None), list):
                yield body
        for part in [*getattr(node, 'handlers', []), *getattr(node, 'cases', [])]:
            yield part.body


def _bound(node: ast.stmt) -> Iterator[tuple[str, str | None]]:
    """Yield the names that a statement itself binds, with what they are if no plain value."""
    if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
        yield node.name, 'a function'
    elif isinstance(node, ast.ClassDef):
        yield node.name, 'a class'
    elif isinstance(node, ast.Import):
        for alias in node.names:
            yield alias.asname or alias.name.partition('.')[0], 'a module'
    elif isinstance(node, ast.ImportFrom):
        for alias in node.names:
            yield alias.asname or alias.name, None
    else:
        targets = [*getattr(node, 'targets', []), getattr(node, 'target', None)]
        targets += [item.optional_vars for item in getattr(node, 'items', [])]
        for target in targets:
            for part in ast.walk(target) if target else ():
                if isinstance(part, ast.Name) and isinstance(part.ctx, ast.Store):
                    yield part.id, None


def _literals(tree: ast.Module, name: str) -> Iterator[Any]:
    """Yield the values that the top level gives a name, where they stand there as such."""
    for node in tree.body:
        if isinstance(node, (ast.Assign, ast.AnnAssign)) and node.value:
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            if any(isinstance(target, ast.Name) and target.id == name for target in targets):
                try:
                    yield ast.literal_eval(node.value)
                except ValueError:
                    continue


def _insert(body: list[ast.stmt], settings: Settings) -> None:
    for node in list(body):
        for inner in _bodies(node):
            _insert(inner, settings)
        names = {name for name, _ in _bound(node)}
        chosen = [name for name in settings if name in names or '*' in names]
        if isinstance(node, ast.AnnAssign) and node.value is None:
            chosen = []
        at = body.index(node) + 1
        body[at:at] = [_assignment(name, node) for name in chosen]


def _assignment(name: str, after: ast.stmt) -> ast.stmt:
    # `from gains import *` may bind the name or not.
    new = ast.parse(f'if {name!r} in globals(): {name} = {CALL}({name!r}, {name})').body[0]
    for part in ast.walk(new):
        ast.copy_location(part, after)
    return new
