"""Shared state of the process: seeds scripts' random generators, guards numpy and the builtins."""

from __future__ import annotations

import builtins
import contextlib
import functools
import hashlib
import inspect
import math
import random
import sys
import traceback
import types
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.random import bit_generator

from setcmas_ctrl.scripts.imports import calling_robot, robot_of_frame
from setcmas_ctrl.scripts.script_errors import describe_failure
from setcmas_simu.errors import SetcmasError

SEED = 0
"""Default seed: equal runs draw equal numbers."""

_GENERATORS = (np.random.Generator, np.random.RandomState, random.Random)
_system_bits: Callable[[int], int] = vars(bit_generator)['randbits']
_seed_random = random.Random.seed
_seed = SEED
_on_unseeded: Callable[[], object] = bool
_nb_unseeded: Counter[int] = (
    Counter()
)  # by robot: generators that its script has made without a seed


def seed_scripts(seed: int, first_robot: int = 1) -> None:
    """Seed `random` and `numpy.random` for scripts, and the generators that they will make.

    Processes with another first robot draw other numbers.
    """
    global _seed
    _seed = seed
    _nb_unseeded.clear()
    own = seed
    if first_robot > 1:  # other sequences than those of other seeds
        own = int(np.random.SeedSequence([seed, first_robot]).generate_state(1)[0])
    random.seed(own)
    np.random.seed(own)


def warn_of_generators(function: Callable[..., Any], warn: Callable[[str], None]) -> None:
    """Warn of random generators that a function uses but does not make itself."""
    try:
        used = inspect.getclosurevars(function)
    except (TypeError, ValueError):  # not a Python function
        return
    for name, value in {**used.globals, **used.nonlocals}.items():
        if isinstance(value, _GENERATORS):
            warn(
                f'{function.__name__} draws from {name}, which keeps its state between runs, so '
                'repeated runs will differ; move both to a script, which is reloaded for each run'
            )


def _script_bits(count: int) -> int | None:
    """Return bits that follow from seed, calling robot and a counter; None outside scripts."""
    robot = calling_robot()
    if robot is None:
        return None
    _nb_unseeded[robot] += 1
    name = f'{_seed} {robot} {_nb_unseeded[robot]}'
    return int.from_bytes(hashlib.shake_256(name.encode()).digest(count // 8), 'big')


def _bits(count: int) -> int:
    """Stand in for `secrets.randbits`, which numpy calls for each generator without a seed."""
    bits = _script_bits(count)
    if bits is None:
        _on_unseeded()
        return _system_bits(count)
    return bits


def _seed_generator(generator: random.Random, a: Any = None, version: int = 2) -> None:
    """Stand in for `random.Random.seed`."""
    _seed_random(generator, _bits(128) if a is None else a, version)


_MODULES = (builtins, math, np, np.linalg, np.random)
_MISSING = object()
_USUAL_RECURSION = 1000  # Python's default; notebooks have more


class _SharedModule(types.ModuleType):
    """A module whose names scripts cannot replace."""

    def __setattr__(self, name: str, value: Any) -> None:
        if vars(self).get(name, value) is not value:
            if isinstance(value, type) and value is vars(builtins).get(name):
                return  # np.bool = bool, for code of earlier versions
            self._refuse_scripts(name)
        super().__setattr__(name, value)

    def __delattr__(self, name: str) -> None:
        self._refuse_scripts(name)
        super().__delattr__(name)

    def _refuse_scripts(self, name: str) -> None:
        if calling_robot() is not None:
            raise AttributeError(
                f'scripts cannot replace {self.__name__}.{name}, because setcmas uses it too'
            )


def _refusing(name: str, refuses: Callable[[Any], bool], what: str) -> Callable[..., Any]:
    """Return a function of `sys` that scripts cannot call with some arguments."""
    function = getattr(sys, name)

    def call(argument: Any) -> Any:
        if robot_of_frame(sys._getframe(1)) is not None and refuses(argument):
            raise ValueError(f'scripts cannot {what}, because it affects setcmas too')
        return function(argument)

    return call


class _State:
    """What setcmas needs of its process, as it was before scripts were loaded."""

    def __init__(self) -> None:
        self._names = [(vars(module), vars(module).copy()) for module in _MODULES]
        self._modules = sys.modules.copy()
        self.limit = sys.getrecursionlimit()
        self.least = min(self.limit, _USUAL_RECURSION)
        self._tracing = sys.gettrace(), sys.getprofile()

    def restore(self) -> list[str]:
        """Restore it; return what scripts had changed."""
        tracing = sys.gettrace(), sys.getprofile()
        if tracing[0] is not self._tracing[0]:  # before Python 3.12 a profiler cannot be set again
            sys.settrace(self._tracing[0])
        if tracing[1] is not self._tracing[1]:
            sys.setprofile(self._tracing[1])
        now = [names.copy() for names, _ in self._names]
        for names, before in self._names:  # builtins first
            names.update(before)
        sys.modules.update({k: v for k, v in self._modules.items() if k not in sys.modules})
        changed = [
            f'{before["__name__"]}.{name}'
            for (_, before), after in zip(self._names, now, strict=True)
            for name, value in before.items()
            if after.get(name, _MISSING) is not value
        ]
        if tracing != self._tracing:
            changed.append('the trace function')
        if sys.getrecursionlimit() < self.least:
            changed.append('the recursion limit')
        sys.setrecursionlimit(self.limit)
        return changed


@contextlib.contextmanager
def kept_state(on_unseeded: Callable[[], object] = bool) -> Iterator[None]:
    """Seed the generators of scripts, and keep what setcmas needs of the process, inside.

    Scripts cannot replace names of `builtins`, `math` and `numpy`, trace, or lower the recursion
    limit.

    Args:
        on_unseeded: Called when a generator is made without a seed, but by no script.

    Raises:
        SetcmasError: A script has done so in a roundabout way, so results may be wrong; or an
            error comes from a script that setcmas did not call, such as a trace function.
    """
    state = _State()
    error: Exception | None = None
    with contextlib.ExitStack() as stack:
        for owner, name, value in _replacements(state.least, on_unseeded):
            stack.callback(setattr, owner, name, getattr(owner, name))
            setattr(owner, name, value)
        try:
            yield
        except Exception as raised:
            error = raised
        finally:
            changed = state.restore()
    if changed and not isinstance(error, SetcmasError):
        raise SetcmasError(
            f'a script has changed {", ".join(changed)}, which setcmas uses too; '
            'its results would be wrong'
        ) from error
    if error:
        raise _located(error) from error.__cause__


def _replacements(
    least: int, on_unseeded: Callable[[], object]
) -> Iterator[tuple[object, str, object]]:
    """Yield objects with a name and what replaces its value."""
    lower = f'lower the recursion limit below {least}'
    yield sys, 'setrecursionlimit', _refusing('setrecursionlimit', lambda n: n < least, lower)
    for name in ('settrace', 'setprofile'):
        yield sys, name, _refusing(name, callable, f'call sys.{name}')
    yield sys.modules[__name__], '_on_unseeded', on_unseeded
    yield bit_generator, 'randbits', _bits
    yield random.Random, 'seed', _seed_generator
    yield random, 'seed', functools.partial(_seed_generator, vars(random)['_inst'])
    for module in _MODULES:
        yield module, '__class__', _SharedModule


def _located(error: Exception) -> Exception:
    """Return an error with its place if a script has raised it in a function of setcmas."""
    frames = [frame for frame, _ in traceback.walk_tb(error.__traceback__)]
    if isinstance(error, SetcmasError) or robot_of_frame(frames[-1]) is None:
        return error
    return SetcmasError(describe_failure(error, Path(frames[-1].f_code.co_filename)))
