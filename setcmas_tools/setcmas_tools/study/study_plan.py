"""Plan of a study: its common scenario, and the values of each run."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from itertools import product
from typing import Any

from setcmas_simu.errors import SetcmasError
from setcmas_tools.measures.metric import METRICS, Metric
from setcmas_tools.offline.offline_simulation import Simulation
from setcmas_tools.run.scenario import Scenario
from setcmas_tools.study.study_columns import COLUMNS, OUTCOME
from setcmas_tools.study.variation import (
    Variation,
    checked_name,
    names_of_scripts,
    values_by_label,
    with_values,
)

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
    for labels in _covering(plan.vary):
        scenario = plan.scenario_of(labels)
        Simulation(scenario)
        scenario.check()
    return plan


def _covering(vary: Mapping[str, Mapping[str, Any]]) -> Iterator[dict[str, str]]:
    """Yield labels by name of runs that together have each value of each name."""
    first = {name: next(iter(values)) for name, values in vary.items()}
    yield first
    for name, values in vary.items():
        for label in [*values][1:]:
            yield {**first, name: label}
