"""Seeds of scripts: equal runs draw equal random numbers, also from generators without a seed."""

from __future__ import annotations

import functools
import hashlib
import inspect
import random
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from typing import Any

import numpy as np
from numpy.random import bit_generator

from setcmas_ctrl.laws.script_imports import calling_robot

SEED = 0
"""Default seed."""

_GENERATORS = (np.random.Generator, np.random.RandomState, random.Random)
_system_bits: Callable[[int], int] = vars(bit_generator)['randbits']
_seed_random = random.Random.seed
_seed = SEED
_on_unseeded: Callable[[], object] = bool
_nb_unseeded: Counter[int] = Counter()
"""How many generators without a seed a robot's script has made."""


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


@contextmanager
def seeded_generators(on_unseeded: Callable[[], object] = bool) -> Iterator[None]:
    """Seed the generators that scripts make without a seed, inside.

    Args:
        on_unseeded: Called when a generator is made without a seed, but by no script.
    """
    of_random = functools.partial(_seed_generator, vars(random)['_inst'])
    replacements = (
        (sys.modules[__name__], '_on_unseeded', on_unseeded),
        (bit_generator, 'randbits', _bits),
        (random.Random, 'seed', _seed_generator),
        (random, 'seed', of_random),
    )
    with ExitStack() as stack:
        for owner, name, value in replacements:
            stack.callback(setattr, owner, name, getattr(owner, name))
            setattr(owner, name, value)
        yield


def _bits(count: int) -> int:
    """Stand in for `secrets.randbits`, which numpy calls for each generator without a seed.

    For scripts the bits follow from seed, calling robot and a counter.
    """
    robot = calling_robot()
    if robot is None:
        _on_unseeded()
        return _system_bits(count)
    _nb_unseeded[robot] += 1
    name = f'{_seed} {robot} {_nb_unseeded[robot]}'
    return int.from_bytes(hashlib.shake_256(name.encode()).digest(count // 8), 'big')


def _seed_generator(generator: random.Random, a: Any = None, version: int = 2) -> None:
    """Stand in for `random.Random.seed`."""
    _seed_random(generator, _bits(128) if a is None else a, version)
