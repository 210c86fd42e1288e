"""Seeds of scripts: equal runs draw equal random numbers, also from generators without a seed."""

from __future__ import annotations

import functools
import importlib.util
import random
import sys
import types
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from importlib.machinery import ModuleSpec
from typing import Any

import numpy as np

from setcmas_ctrl.laws.script_imports import calling_robot

SEED = 0
"""Default seed."""

_NUMPY_RANDOM = 'numpy.random'
_seed_random = random.Random.seed
_seed = _seed_of_numpy = SEED
_nb_unseeded: Counter[int] = Counter()
"""How many generators without a seed a robot's script has made."""


def seed_scripts(seed: int, first_robot: int = 1) -> None:
    """Seed `random` and `numpy.random` for scripts, and the generators that they will make.

    Processes with another first robot draw other numbers.
    """
    global _seed, _seed_of_numpy
    _seed = seed
    _nb_unseeded.clear()
    own = seed
    if first_robot > 1:  # other sequences than those of other seeds
        own = int(np.random.SeedSequence([seed, first_robot]).generate_state(1)[0])
    random.seed(own)
    _seed_of_numpy = own
    if _NUMPY_RANDOM in sys.modules:
        np.random.seed(own)


@contextmanager
def seeded_generators() -> Iterator[None]:
    """Within this context, seed the generators that scripts create without a seed."""
    of_random = functools.partial(_seed_generator, vars(random)['_inst'])
    with ExitStack() as stack:
        replace = functools.partial(_replace, stack)
        replace(random.Random, 'seed', _seed_generator)
        replace(random, 'seed', of_random)
        if _NUMPY_RANDOM in sys.modules:
            _seed_numpy(replace)
        else:
            finder = _NumpyRandom(replace)
            sys.meta_path.insert(0, finder)
            stack.callback(finder.leave)
        yield


Replace = Callable[[Any, str, object], None]
"""Replaces an attribute of an object."""


def _replace(stack: ExitStack, owner: Any, name: str, value: object) -> None:
    """Replace an attribute until the context ends."""
    stack.callback(setattr, owner, name, getattr(owner, name))
    setattr(owner, name, value)


def _seed_numpy(replace: Replace) -> None:
    replace(sys.modules[f'{_NUMPY_RANDOM}.bit_generator'], 'randbits', _bits)


class _NumpyRandom:
    """Seeds numpy.random as soon as a script imports it: a finder for `sys.meta_path`.

    Most laws draw nothing, and numpy.random with the OpenSSL that it imports takes 2 MB and 10 ms
    of a process of controllers (benchmarks/fleet.py).
    """

    def __init__(self, replace: Replace) -> None:
        self._replace = replace

    def find_spec(
        self, name: str, path: Sequence[str] | None = None, target: types.ModuleType | None = None
    ) -> ModuleSpec | None:
        """Find numpy.random, whose import shall seed it (called by Python)."""
        del path, target
        if name != _NUMPY_RANDOM:
            return None
        self.leave()
        spec = importlib.util.find_spec(name)  # contexts around this one do the same
        if spec and spec.loader:
            execute = functools.partial(self._execute, spec.loader.exec_module)
            vars(spec.loader)['exec_module'] = execute
        return spec

    def _execute(
        self, execute: Callable[[types.ModuleType], None], module: types.ModuleType
    ) -> None:
        execute(module)
        _seed_numpy(self._replace)
        vars(module)['seed'](_seed_of_numpy)

    def leave(self) -> None:
        """Find no modules any more."""
        if self in sys.meta_path:
            sys.meta_path.remove(self)


def _bits(count: int) -> int:
    """Stand in for `secrets.randbits`, which numpy calls for each generator without a seed.

    For scripts the bits follow from seed, calling robot and a counter.
    """
    robot = calling_robot()
    if robot is None:
        return random.SystemRandom().getrandbits(count)
    import hashlib  # here: it imports OpenSSL

    _nb_unseeded[robot] += 1
    name = f'{_seed} {robot} {_nb_unseeded[robot]}'
    return int.from_bytes(hashlib.shake_256(name.encode()).digest(count // 8), 'big')


def _seed_generator(generator: random.Random, a: Any = None, version: int = 2) -> None:
    """Stand in for `random.Random.seed`."""
    _seed_random(generator, _bits(128) if a is None else a, version)
