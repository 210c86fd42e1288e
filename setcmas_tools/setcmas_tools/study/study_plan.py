"""Plan of a study: names that it varies, of options and of variables of scripts, and its runs."""

from __future__ import annotations

import json
import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from setcmas_ctrl.laws.script_loader import names_to_set
from setcmas_ctrl.laws.script_search import LawScripts
from setcmas_ctrl.laws.script_settings import parse_setting
from setcmas_simu.errors import SetcmasError, did_you_mean
from setcmas_simu.option_groups import plain
from setcmas_tools.measures.metric import METRICS, Metric
from setcmas_tools.offline.offline_simulation import Simulation
from setcmas_tools.run.scenario import Scenario, name_of, options
from setcmas_tools.study.study_columns import COLUMNS, OUTCOME

SEED = 'seed'

_RESERVED = {*COLUMNS, *OUTCOME, 'run', SEED}


@dataclass(frozen=True)
class Plan:
    """A study before its runs.

    Attributes:
        base: The common scenario of all runs.
        vary: Values by their labels in the table, for each varied name.
        seeds: Number of seeds; the first one is that of the scenario.
        metrics: Its own metrics by name.
    """

    base: Scenario
    vary: Mapping[str, Mapping[str, Any]]
    seeds: int = 1
    metrics: Mapping[str, Metric] = field(default_factory=dict)

    @cached_property
    def runs(self) -> list[dict[str, Any]]:
        """Labels of each run by name, and its seed. The last name varies fastest, seeds last."""
        return [
            {**dict(zip(self.vary, labels, strict=True)), SEED: self.base.seed + k}
            for k in range(self.seeds)
            for labels in product(*self.vary.values())
        ]

    def scenario(self, run: int) -> Scenario:
        """Return the scenario of a run, numbered from 1."""
        labels = dict(self.runs[run - 1])
        seed = labels.pop(SEED)
        return self.scenario_of(labels).replace(seed=seed)

    def scenario_of(self, labels: Mapping[str, str]) -> Scenario:
        """Return the scenario with values by their labels; raise SetcmasError if they clash."""
        return with_values(self.base, {n: self.vary[n][label] for n, label in labels.items()})

    def cases(self) -> Iterator[Scenario]:
        """Yield scenarios that together have each value of each name, that of run 1 first."""
        first = {name: next(iter(values)) for name, values in self.vary.items()}
        yield self.scenario_of(first)
        for name, values in self.vary.items():
            for label in [*values][1:]:
                yield self.scenario_of({**first, name: label})


def make_plan(
    base: Scenario,
    vary: Iterable[tuple[str, Variation]],
    seeds: int = 1,
    metrics: Mapping[str, Metric] | None = None,
) -> Plan:
    """Return the plan of a study, with arguments as for `sweep`, or raise SetcmasError."""
    pairs = [*vary]
    laws = [base.law.algo]
    if 'algo' in dict(pairs):
        laws = [*values_by_label('algo', dict(pairs)['algo']).values()]
    texts = [law for law in laws if isinstance(law, str)]
    script_names = set().union(*(names_of_scripts(text, base.law.exercise) for text in texts))
    varied: dict[str, dict[str, Any]] = {}
    for given, values in pairs:
        name = checked_name(given, script_names)
        if name in varied:
            raise SetcmasError(f"'{name}' is varied twice; vary it once")
        if name in _RESERVED:
            raise SetcmasError(
                f"the table already has a column '{name}'; rename the variable of the script"
            )
        varied[name] = values_by_label(name, values)
    for name in metrics or {}:
        if name in METRICS or name in COLUMNS:
            raise SetcmasError(f"metric '{name}' exists already; choose another name")
    plan = Plan(base, varied, seeds, dict(metrics or {}))
    for scenario in plan.cases():
        Simulation(scenario)
        scenario.check()
    return plan


Variation = str | Sequence[Any] | Mapping[str, Any]
"""Values of a name: text as on the command line, a sequence, or values by label."""

_NOT_VARIED = ('set', 'exercise', 'pose', 'cmd_timeout', 'rtf', 'seed')
OPTIONS = {name: one for name, one in options().items() if name not in _NOT_VARIED}
"""The values of a scenario that a study can vary, by name."""


def names_of_scripts(algo: str, exercise: bool = False) -> set[str]:
    """Return the variables that the scripts of `--algo` assign, or raise SetcmasError."""
    paths = LawScripts(algo, exercise).paths
    return {name for path in paths for name in names_to_set(path)}


def checked_name(name: str, script_names: Collection[str]) -> str:
    """Return a varied name with _ for - in options, or raise SetcmasError if unknown or both."""
    option = name.replace('-', '_')
    if option in OPTIONS and name in script_names:
        raise SetcmasError(
            f'--vary {name}: this is both an option and a variable of the script; rename the '
            'variable'
        )
    if option in OPTIONS:
        return option
    if name in script_names:
        return name
    raise SetcmasError(
        f'--vary {name}: unknown name{did_you_mean(name, [*OPTIONS, *script_names], 2) or ";"} '
        f'options are {", ".join(OPTIONS)}; names of the script: '
        f'{", ".join(sorted(script_names)) or "none"}'
    )


def with_values(base: Scenario, values: Mapping[str, Any]) -> Scenario:
    """Return a scenario with varied values, or raise SetcmasError if one is invalid."""
    changes = {name: value for name, value in values.items() if name in OPTIONS}
    settings = {name: value for name, value in values.items() if name not in OPTIONS}
    return base.replace(**changes, set={**base.law.set, **settings})


def values_by_label(name: str, values: Variation) -> dict[str, Any]:
    """Return the values of a name by their labels in the table, or raise SetcmasError."""
    if isinstance(values, str):
        values = parse_values(name, values)
    if isinstance(values, Mapping):
        return {str(label): value_of(name, value) for label, value in values.items()}
    found = [value_of(name, one) for one in values]
    by_label = {label_of(value): value for value in found}
    if len(by_label) < len(found):
        labels = ', '.join(map(label_of, found))
        raise SetcmasError(
            f'--vary {name}: {len(found)} values, some of one name: {labels}; leave out equal '
            'values, and give functions names, or a dictionary of values by name'
        )
    return by_label


def value_of(name: str, value: Any) -> Any:
    """Convert a text, a number or a value from Python for its option, or raise SetcmasError."""
    if name not in OPTIONS:
        return parse_setting(f'{name}={value}')[1] if isinstance(value, str) else plain(value)
    if callable(value):
        return value
    if OPTIONS[name].is_switch:
        return yaml.safe_load(value) if isinstance(value, str) else value
    value = OPTIONS[name].value(value)
    return str(value) if isinstance(value, Path) else value


def value_in_table(name: str, cell: Any) -> Any:
    """Return the value that has a cell of the table as its label, or raise SetcmasError."""
    if isinstance(cell, str) and cell.startswith('['):
        with suppress(ValueError):
            return value_of(name, json.loads(cell))
    return value_of(name, plain(cell))


def label_of(value: Any) -> str:
    """Return the text of a value in the table."""
    if callable(value):
        return str(name_of(value))
    value = plain(value)
    if isinstance(value, float):
        return repr(value).removesuffix('.0')
    if isinstance(value, (list, Mapping, bool)):
        return json.dumps(value)
    return '' if value is None else str(value)


_NUMBER = r'[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?'
_RANGE = re.compile(rf'(log:)?({_NUMBER}):({_NUMBER}):(\d+)')
_MISTAKEN = re.compile(rf'(?:log:{_NUMBER}|{_NUMBER}:{_NUMBER})(?::{_NUMBER})*')
_DIGITS = 12  # so that 0.2:2:10 has 0.4 instead of 0.4000000000000001


def parse_values(name: str, text: str) -> list[Any]:
    """Return the values in a text such as '0.2:2:10' or '0,0.2,0.4', or raise SetcmasError.

    Values of a list stay strings unless the list is YAML, such as '[[1, 2], [3, 4]]'.
    """
    if found := _RANGE.fullmatch(text):
        log, first, last, count = bool(found[1]), float(found[2]), float(found[3]), int(found[4])
        if count < 1 or (log and not (first > 0 and last > 0)):
            more = ' with bounds above 0' if log else ''
            raise SetcmasError(f"--vary {name} '{text}' must be a range of 1 value or more{more}")
        numbers = np.geomspace(first, last, count) if log else np.linspace(first, last, count)
        return [float(f'{number:.{_DIGITS}g}') for number in numbers.tolist()]
    values: Any = text.split(',')
    if text.startswith('['):
        values = []
        with suppress(yaml.YAMLError):
            values = yaml.safe_load(text)
    empty = not values or not all(str(value).strip() for value in values)
    if empty or _MISTAKEN.fullmatch(text):
        raise SetcmasError(
            f"--vary {name} '{text}' must be a list (0,0.2,0.4), or a range FIRST:LAST:COUNT or "
            'log:FIRST:LAST:COUNT'
        )
    return [value.strip() if isinstance(value, str) else value for value in values]
