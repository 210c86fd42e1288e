"""Runs of a study made together, as long as no run can tell that it is not alone.

One step of numpy then moves the robots of all of them. It is a short cut, which is taken if
nothing has happened that is for a run of its own to tell: no message, no random number from a
generator that the runs share, and nothing left in the process by a script: no module, folder,
thread or name of a module changed. What cannot be seen is a script that fills an object of an
installed package, such as a dictionary of numpy's, and reads it again.
"""

from __future__ import annotations

import operator
import os
import random
import sys
import threading
import warnings
from collections.abc import Callable, Collection, Mapping, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any, cast

import numpy as np

from setcmas_ctrl import drawing, network
from setcmas_ctrl.control.options import RATE_HZ
from setcmas_ctrl.filter.options import BARRIER
from setcmas_ctrl.scripts.output import named_output
from setcmas_ctrl.scripts.random_seed import seed_scripts
from setcmas_tools.offline.engine import made, radio_of
from setcmas_tools.offline.history import recorded_drawings
from setcmas_tools.offline.simulation import Simulation
from setcmas_tools.run.run import Run
from setcmas_tools.studies.workers.row import Row, arguments_of, row_of_run, simulation_of

_SHARED_SEED = 0x5E7C3A5  # of no run in particular: a script that draws in its calls changes it
_MOST_CALLS = 24_000  # of laws in a run; they take a few microseconds each, or more
_OWN = ('set', 'seed')
_KNOWN = sys.stdlib_module_names | {'setcmas_simu', 'setcmas_ctrl', 'setcmas_tools'}
_CHANGING = (network,)  # each call of a law sets it anew


def kind_of(parameters: Mapping[str, Any]) -> bytes:
    """Return what runs must have in common to be made together; empty for one that cannot be.

    Functions, scripts beside the laws, graphs that depend on places and the safety filter are for
    runs alone; so are long runs, which would be told late.

    Args:
        parameters: As for `run_of`.
    """
    import cloudpickle

    calls = parameters['nb_robots'] * parameters['duration'] * parameters.get('rate', RATE_HZ)
    others = any(parameters.get(name) for name in ('ctc', 'model', 'range'))
    others |= parameters.get('filter') == BARRIER
    if others or calls > _MOST_CALLS or not isinstance(parameters['algo'], str):
        return b''
    kind: bytes = cloudpickle.dumps({n: v for n, v in parameters.items() if n not in _OWN})
    return kind


def rows_together(
    parameters: Mapping[int, Mapping[str, Any]], progress: Callable[[float], object]
) -> list[Row]:
    """Make runs of one kind and return their rows; none if each must be made alone.

    Args:
        parameters: As for `run_of`, by the number of the run.
        progress: As for `simulate`.

    Raises:
        Exception: They must be made alone, too.
    """
    messages: list[str] = []
    simulations = [
        simulation_of(arguments_of(one, messages.append, progress)) for one in parameters.values()
    ]
    runs = runs_together(simulations)
    drawn = _random_states()
    rows = [
        row_of_run(number, run, messages) for number, run in zip(parameters, runs, strict=False)
    ]
    return [] if messages or _random_states() != drawn else rows


def runs_together(simulations: Sequence[Simulation]) -> list[Run]:
    """Make runs of one kind; none if their scripts have shared anything.

    Raises:
        Exception: As `simulate` does for one of them.
    """
    before, threads, fleets = _process(), {*threading.enumerate()}, []
    radio = radio_of(simulations)
    with named_output():
        for one in simulations:
            seed_scripts(one.seed)
            fleets.append(_Fleet(one))
            if fleets[-1].is_shared:
                return []
        seed_scripts(_SHARED_SEED)
        seeded = _random_states()
        with recorded_drawings():  # which each fleet has replaced
            runs = made(simulations, radio, [one.drawings for one in fleets], fleets)
    own = {name for one in fleets for name in one.modules}
    same = _are_same(before, _process(), own) and _random_states() == seeded
    return runs if same and threads.issuperset(threading.enumerate()) else []


class _Fleet:
    """What the scripts of a run have of their own, in a process with other runs.

    Attributes:
        modules: Theirs in `sys.modules`.
        drawings: What they draw.
        is_shared: Whether other modules were imported, whose state runs would share.
    """

    def __init__(self, one: Simulation) -> None:
        """Load the scripts of a run."""
        known = sys.modules.copy()
        with recorded_drawings() as self.drawings:
            one.load()
        new = {name for name, module in sys.modules.items() if known.get(name) is not module}
        own = {str(law.names['__name__']) for law in one.laws}
        self.modules = {name: sys.modules[name] for name in own}
        self.is_shared = not {name.partition('.')[0] for name in new - own} <= _KNOWN

    def __call__(self) -> None:
        """Make room for the calls of this fleet's laws."""
        sys.modules.update(self.modules)
        drawing.canvas = self.drawings


def _random_states() -> tuple[Any, ...]:
    kind, words, *rest = cast(tuple[Any, ...], np.random.get_state())
    return random.getstate(), kind, words.tobytes(), rest


def _process() -> dict[str, list[Any]]:
    """Return what scripts can change of their process, as far as it can be seen."""
    modules = {
        name: list(vars(module).values())
        for name, module in sys.modules.copy().items()
        if isinstance(module, ModuleType) and module not in _CHANGING
    }
    settings = [Path.cwd(), dict(os.environ), np.geterr()]
    return {**modules, '': [*settings, *warnings.filters]}


def _are_same(
    before: Mapping[str, list[Any]], after: Mapping[str, list[Any]], own: Collection[str]
) -> bool:
    """Return whether all is as it was, but for modules of their own, and new ones of packages."""
    if before[''] != after['']:
        return False
    for name in before.keys() - {'', *own}:
        old, now = before[name], after.get(name, [])
        if len(now) < len(old) or not all(map(operator.is_, old, now)):
            return False
        if not all(isinstance(value, ModuleType) for value in now[len(old) :]):
            return False
    return True
