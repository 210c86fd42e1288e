"""Checks of a study before it starts: its names, and a run with each of its values."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from setcmas_ctrl.communication.options import CommunicationOptions
from setcmas_ctrl.communication.settings import check_communication
from setcmas_ctrl.control.law_scripts import LawScripts
from setcmas_simu.errors import SetcmasError
from setcmas_tools.studies.cases.case_table import SEED, CaseTable
from setcmas_tools.studies.columns import COLUMNS
from setcmas_tools.studies.workers.row import arguments_of, simulation_of

_RESERVED = {*COLUMNS, 'run', 'state', 'robots', 'message'}


def check_names(names: Sequence[str], seeds: int) -> None:
    """See that names that are varied can be columns of one table.

    Raises:
        SetcmasError: They cannot.
    """
    twice = {name for name in names if names.count(name) > 1}
    if twice:
        raise SetcmasError(f"'{min(twice)}' is varied twice; it must be varied once")
    if taken := _RESERVED.intersection(names):
        raise SetcmasError(
            f"the table has a column '{min(taken)}' already; rename that name of the script"
        )
    if SEED in names and seeds > 1:
        raise SetcmasError(f'seeds are varied by --vary {SEED} and --seeds; leave one out')


def telling_runs(table: CaseTable) -> Iterator[int]:
    """Yield runs that together have each value of each axis."""
    stride = table.seeds
    for _, values in reversed(table.axes):
        yield from (1 + index * stride for index in range(len(values)))
        stride *= len(values)


def check_parameters(parameters: Mapping[str, Any]) -> None:
    """See that a run can be made.

    Raises:
        SetcmasError: It cannot.
    """
    simulation_of(arguments_of(parameters, print))
    check_communication(CommunicationOptions.among(parameters), parameters['nb_robots'])
    if isinstance(parameters['algo'], str):
        scripts = LawScripts(parameters['algo'], settings=parameters['set'])
        scripts.check(parameters['nb_robots'])
    elif parameters['set']:
        raise SetcmasError('settings are for scripts; a function takes none')
