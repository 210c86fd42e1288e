"""Seeds of scripts: equal runs draw equal random numbers, also from generators without a seed."""

from __future__ import annotations

import functools
import hashlib
import random
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from typing import Any

import numpy as np
from numpy.random import bit_generator

from setcmas_ctrl.laws.script_imports import calling_robot

SEED = 0
"""Default seed."""

_system_bits: Callable[[int], int] = vars(bit_generator)['randbits']
_seed_random = random.Random.seed
_seed = SEED
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


@contextmanager
def seeded_generators() -> Iterator[None]:
    """Within this context, seed the generators that scripts create without a seed."""
    of_random = functools.partial(_seed_generator, vars(random)['_inst'])
    replacements = (
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
        return _system_bits(count)
    _nb_unseeded[robot] += 1
    name = f'{_seed} {robot} {_nb_unseeded[robot]}'
    return int.from_bytes(hashlib.shake_256(name.encode()).digest(count // 8), 'big')


def _seed_generator(generator: random.Random, a: Any = None, version: int = 2) -> None:
    """Stand in for `random.Random.seed`."""
    _seed_random(generator, _bits(128) if a is None else a, version)
