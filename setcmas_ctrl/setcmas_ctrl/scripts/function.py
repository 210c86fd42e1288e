"""Required function of a script: checks it before and after the script runs."""

from __future__ import annotations

import ast
import inspect
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

from setcmas_simu.errors import SetcmasError, nearest

Control = Callable[..., Any]

CONTROL = 'control(robotNo, nbRobots, poses, t)'
"""The function that a control script must define."""

_OPTIONS = {
    'control': '--algo',
    'ctc': '--event-triggered --ctc',
    'step': '--model',
    'si_to_uni': '--si-to-uni',
}
_COUNTS = {2: 'two', 3: 'three', 4: 'four'}


def check_defines(tree: ast.Module, expected: str, path: Path) -> None:
    """Raise SetcmasError unless a script defines a function, as far as seen without running it."""
    name = expected.partition('(')[0]
    if all({name, '*'}.isdisjoint(_defined(node)) for node in ast.walk(tree)):
        raise SetcmasError(
            f'{path.name} has no function {name}; {_hint(tree, name, path)}it must have {expected}'
        )


def checked_function(
    function: Any, path: Path, expected: str = CONTROL, result: str = 'vx, vy'
) -> Control:
    """Return a script's function if it takes the expected arguments, or raise SetcmasError.

    `result` is what it returns, for messages.
    """
    name, _, parameters = expected.partition('(')
    if not callable(function):
        raise SetcmasError(f'{path.name} has no function {name}; it must have {expected}')
    if inspect.isgeneratorfunction(function) or inspect.iscoroutinefunction(function):
        kind = 'has a yield' if inspect.isgeneratorfunction(function) else 'is async'
        raise SetcmasError(
            f'{path.name}: {name} {kind}; it must be a plain function that ends with '
            f'return {result}'
        )
    checked: Control = function
    wanted = parameters.rstrip(')').split(', ')
    count = len(wanted)
    try:
        signature = inspect.signature(function)
    except (TypeError, ValueError):  # some callables written in C have no signature
        return checked
    try:
        signature.bind(*range(count))
    except TypeError as error:
        raise SetcmasError(
            f'{path.name}: {name}{signature} does not take {_COUNTS[count]} arguments; '
            f'it must be {expected}'
        ) from error
    places = zip(signature.parameters, wanted, strict=False)
    if any(own in wanted and own != place for own, place in places):
        raise SetcmasError(
            f'{path.name}: {name}{signature} has its arguments in another order; it must be '
            f'{expected}'
        )
    return checked


def literals(tree: ast.Module) -> Iterator[tuple[str, Any]]:
    """Yield the names that the top level of a script assigns, with their literal values."""
    for node in tree.body:
        if isinstance(node, (ast.Assign, ast.AnnAssign)) and node.value:
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            with suppress(ValueError, TypeError, RecursionError, MemoryError):
                value = ast.literal_eval(node.value)
                yield from ((name.id, value) for name in targets if isinstance(name, ast.Name))


def _defined(node: ast.AST) -> list[str]:
    """Return the names that a statement or expression itself defines."""
    if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)):
        return [node.name]
    if isinstance(node, (ast.Import, ast.ImportFrom)):
        return [alias.asname or alias.name for alias in node.names]
    return [node.id] if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store) else []


def _hint(tree: ast.Module, name: str, path: Path) -> str:
    """Return a hint: the script is of another kind, or misspells its function; '' if unknown."""
    functions = {
        node.name.lower(): node for node in tree.body if isinstance(node, ast.FunctionDef)
    }
    for other, option in _OPTIONS.items():
        if other != name and other in functions:
            return f'its {other} is for {option} {path.name}; '
    for near in nearest(name, functions):
        node = functions[near]
        return f'{node.name} in line {node.lineno} must be called {name}; '
    return ''
