"""Function of a script: checked before and after the script runs, and its results.

A function that has returned leaves no trace of its `return`, so a loaded script notes the lines:
`return v` becomes `return noted(12, v)`.
"""

from __future__ import annotations

import ast
import inspect
import re
from collections.abc import Callable, Iterator
from contextlib import suppress
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np

from setcmas_ctrl.laws.script_errors import (
    ControlError,
    StopCall,
    described_place,
    failure_of,
    quoted_line,
    scripts_own,
    short_repr,
)
from setcmas_simu.arrays import Floats
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


def file_of(function: Any, name: str) -> Path:
    """Return the file of a function; a path of this name if it has none."""
    code = getattr(function, '__code__', None)
    return Path(code.co_filename if code else name)


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


NOTED = '__setcmas_return__'
"""Builtin of loaded scripts: `noted`."""

_FUNCTIONS = ('control', 'ctc', 'si_to_uni', 'step', 'start', 'command')
_FINITE = 'is there a division by zero, or the square root of a negative number?'
_line = 0  # of the last return; 0 since the beginning of a function


def noted(line: int, value: Any = None) -> Any:
    """Note the line of a return; return the value."""
    global _line
    _line = line
    return value


def note_returns(tree: ast.Module) -> None:
    """Let the functions that setcmas calls note the lines of their returns."""
    functions = (node for node in tree.body if isinstance(node, ast.FunctionDef))
    for node in functions:
        # A decorator may compile the function, which then knows no other builtins.
        if node.name in _FUNCTIONS and not node.decorator_list:
            _NotedReturns().generic_visit(node)
            begin = ast.copy_location(ast.Expr(_noting(0)), node.body[0])
            node.body.insert(ast.get_docstring(node) is not None, begin)
            ast.fix_missing_locations(node)


class _NotedReturns(ast.NodeTransformer):
    """Changes the returns of a function, but not those of functions inside it."""

    def visit(self, node: ast.AST) -> Any:
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef, ast.expr)):
            return node
        if isinstance(node, ast.Return):
            node.value = _noting(node.lineno, *([node.value] if node.value else []))
            return node
        return self.generic_visit(node)


def _noting(line: int, *values: ast.expr) -> ast.Call:
    return ast.Call(ast.Name(NOTED, ast.Load()), [ast.Constant(line), *values], [])


class WrongResultError(ValueError):
    """A result is not what a function of a script must return.

    Attributes:
        is_nan: Whether it has the right form, but a number is NaN or infinite.
    """

    def __init__(self, message: str, is_nan: bool = False) -> None:
        """Take a message such as 'control returned 3 values: (1, 2, 3)'."""
        super().__init__(message)
        self.is_nan = is_nan


def numbers_of(result: Any, sizes: range | tuple[int, ...], name: str) -> Floats:
    """Return what a function of a script returned as an array of one of these sizes.

    Tuples, lists and arrays of any shape will do, and integers.

    Raises:
        WrongResultError: It is something else, or has numbers that are not finite.
    """
    try:
        array = np.asarray(unmasked(result))
    except StopCall:
        raise
    except BaseException:  # it may be an object of the script's own
        array = np.empty(0, dtype=object)
    if array.dtype.kind not in 'iufb':
        raise WrongResultError(f'{name} returned {_kind(result, array)}')
    if array.size not in sizes:
        shape = f' in {" x ".join(map(str, array.shape))}' if array.ndim > 1 else ''
        values = f'{array.size} value{"s" * (array.size != 1)}{shape}'
        raise WrongResultError(f'{name} returned {values}: {_short(result)}')
    numbers = array.astype(float).ravel()
    if not np.isfinite(numbers).all():
        what = f'{name} returned a value that is not finite: {_short(result)}'
        raise WrongResultError(what, is_nan=True)
    return numbers


def unmasked(value: Any) -> Any:
    """Return a value, or a sequence of values, with NaN for what is masked in masked arrays."""
    if hasattr(value, 'filled'):  # does not import numpy.ma for other scripts
        return value.astype(float).filled(np.nan)
    return [unmasked(one) for one in value] if type(value) in (tuple, list) else value


def _kind(result: Any, array: Any) -> str:
    """Return what a result is that holds no numbers."""
    if result is None:
        return 'None'
    if array.dtype.kind in 'US':
        return f'text: {_short(result)}'
    if array.dtype.kind == 'c':
        return f'complex numbers: {_short(result)}'
    if type(result) in (tuple, list):
        if any(value is None for value in result):
            return f'None in place of a number: {_short(result)}'
        return f'values of unequal kinds or lengths: {_short(result)}'
    return f'a {type(result).__name__}: {_short(result)}'


def _short(value: Any) -> str:
    return re.sub(r'np\.\w+\(([^()]*)\)', r'\1', short_repr(value))  # nan, not np.float64(nan)


_FLOATS = {np.float64, float}


class ScriptFunction:
    """A function of a script, or of Python, that must return numbers.

    Attributes:
        path: The script, or the file of the function.
        function: The function itself.
        sizes: How many numbers it may return.
    """

    def __init__(
        self,
        function: Callable[..., Any],
        path: Path,
        name: str,
        sizes: tuple[int, ...] | range = (2,),
        expected: str = '',
    ) -> None:
        """Take a function; `expected` are the words that follow "it must return" in messages."""
        self.path = path
        self.function, self._name = function, name
        self.sizes, self._expected = sizes, expected

    def __call__(self, *arguments: Any, **keywords: Any) -> tuple[float, ...]:
        """Call the function; return its numbers, as many as one of the sizes says.

        Raises:
            ControlError: It has failed, or returned something else.
        """
        try:
            result = self.function(*arguments, **keywords)
        except (StopCall, ControlError):  # ControlError: from another law
            raise
        except BaseException as error:  # whatever a script raises, the other robots continue
            if isinstance(error, KeyboardInterrupt) and not scripts_own(error):
                raise
            raise failure_of(error, self.path) from error
        if type(result) is tuple and len(result) == 2 and 2 in self.sizes:  # the usual case
            one, other = result
            are_floats = type(one) in _FLOATS and type(other) in _FLOATS
            if are_floats and isfinite(one) and isfinite(other):
                return one, other
        try:
            return tuple(numbers_of(result, self.sizes, self._name).tolist())
        except WrongResultError as error:
            raise self._wrong(result, error) from error

    def _wrong(self, result: Any, error: WrongResultError) -> ControlError:
        """Return the error for a wrong result, with the return that it has just taken."""
        code: Any = getattr(self.function, '__code__', None)
        file, line, text = self.path, None, str(error)
        if code:
            file, line = Path(code.co_filename), code.co_firstlineno
            if NOTED in code.co_names and _line:
                line = _line
            elif NOTED in code.co_names and result is None:
                text += ': it reached its end without a return'
        sizes = self.sizes
        count = ' or '.join(map(str, sizes)) if isinstance(sizes, tuple) else '3 or more'
        expected = f'it must return {self._expected or f"{count} finite numbers"}'
        advice = _FINITE if error.is_nan else expected
        place = described_place(file, line, self.path)
        message = f'{place}: {text}; {advice}{quoted_line(file, line)}'
        return ControlError(message, (text.partition(':')[0], file, line), place=(file, line))
