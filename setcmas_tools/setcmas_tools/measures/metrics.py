"""Metrics of a run: computation, table for the terminal, and metrics.yaml."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from setcmas_simu.errors import SetcmasError, file_errors
from setcmas_simu.fleet.topics import robot_name
from setcmas_simu.limited_file import written_whole
from setcmas_simu.plugins import InvalidPluginError
from setcmas_tools.measures.agreement import have_met
from setcmas_tools.measures.metric import METRICS, Columns, Measured, Metric, measured
from setcmas_tools.measures.predicted_metrics import Comparison, Departure, compared
from setcmas_tools.measures.robot_metrics import largest_speed
from setcmas_tools.run.run import Run

PREDICTION = 'prediction'
"""The name of what theory says, in metrics.yaml."""

MOST_ROBOTS_IN_ROWS = 50
"""For larger fleets the table has the minimum, mean and maximum."""


def fleet_lines(parts: Mapping[str, Measured]) -> list[str]:
    """Return the metrics of the fleet as lines of text, without what theory says.

    Robots that are meant to meet do not collide, unless in an experiment or with a filter.
    """
    lines = {name: part.lines for name, part in parts.items() if name != PREDICTION}
    if not (sentence := meeting(parts)):
        return [*chain(*lines.values())]
    if not {'safety', 'filter'} & parts.keys():
        lines.pop('separation', None)
    return [sentence, *chain(*lines.values())]


def theory_lines(parts: Mapping[str, Measured]) -> list[str]:
    """Return what theory says of a run as lines of text."""
    theory = parts.get(PREDICTION)
    return [*theory.lines] if theory else ['theory: nothing is predicted for this law']


_RATE = 'consensus.convergence_rate_1_s'
_RATES_DIFFER = 0.05


def meeting(parts: Mapping[str, Measured]) -> str:
    """Return the sentence from the metrics of a run by name; '' if its robots need not meet."""
    agreement, separation, theory = map(parts.get, ('consensus', 'separation', PREDICTION))
    if not agreement or not agreement.lines:
        return ''
    text = f'The robots {"met" if have_met(agreement) else "did not meet"}'
    if separation and separation.largest_distance_at_end_m is not None:
        text += f': at most {separation.largest_distance_at_end_m:.2f} m apart at the end'
    rate = agreement.convergence_rate_1_s
    if rate is None:
        return f'{text}.'
    text += f'. Rate {rate:.3g} 1/s'
    if isinstance(theory, Comparison) and (figure := theory.figure(_RATE)):
        expected, limit = figure.predicted, theory.departures.get(Departure.SPEED_LIMIT)
        text += f', theory {expected:.3g}'
        if limit and expected and abs(rate / expected - 1.0) > _RATES_DIFFER:
            text += f' (the speed limit was {limit})'
    return f'{text}.'


def robots_table(parts: Mapping[str, Measured], form: str = 'simple') -> str:
    """Return `robots_rows` as a table in a format of `tabulate`; empty without rows."""
    from tabulate import tabulate  # here: a simulation does not need it

    if not (rows := robots_rows(parts)):
        return ''
    table: str = tabulate(
        rows, 'firstrow', form, stralign='right', colalign=('left',), disable_numparse=True
    )
    return table


def robots_rows(parts: Mapping[str, Measured]) -> list[list[str]]:
    """Return heads and a row for each robot; nothing if no metric is of robots."""
    columns: Columns = {k: c for part in parts.values() for k, c in part.columns.items()}
    if not columns:
        return []
    robots = sorted({robot for _, values in columns.values() for robot in values})
    if len(robots) <= MOST_ROBOTS_IN_ROWS:
        rows = [
            [
                robot_name(robot),
                *(_text(values.get(robot), form) for form, values in columns.values()),
            ]
            for robot in robots
        ]
    else:
        rows = [[name] for name in ('least', 'mean', 'largest')]
        for form, values in columns.values():
            known = [value for value in values.values() if value is not None]
            of_all = (min(known), float(np.mean(known)), max(known)) if known else (None,) * 3
            for row, value in zip(rows, of_all, strict=True):
                row.append(_text(value, form))
    first = f'{len(robots)}\nrobots' if len(rows) != len(robots) else 'robot'
    return [[first, *columns], *rows]


def _text(value: float | None, form: str = '.2f') -> str:
    text = '-' if value is None else format(value, form)
    return text.lstrip('-') if text.startswith('-0') and not float(text) else text


_FIRST = (
    'robots', 'separation', 'consensus', 'messages', 'formation', 'distances', 'tracking',
    'waypoints', 'coverage', 'honest', 'alignment',
)  # fmt: skip
"""The first metrics of the table; then all others."""


class Metrics(dict[str, Any]):
    """The metrics of a run that apply to it, by name.

    The duration is from the first to the last row at t >= 0; vnom is the limit of commands;
    communication is 'periodic' (each odometry is sent) or 'event-triggered'.
    """

    def __init__(self, parts: Mapping[str, Measured], run: Run) -> None:
        """Take the metrics of a run."""
        super().__init__(parts)
        self.task = run.references.task if run.references else None
        self.duration_s = float(run.counted.t[-1] - run.counted.t[0])
        self.vnom_m_s = largest_speed(run)
        triggered = run.record is not None and run.record.is_event_triggered
        self.communication = 'event-triggered' if triggered else 'periodic'

    def __str__(self) -> str:
        return '\n'.join([*robots_table(self).splitlines(), *fleet_lines(self)])

    __repr__ = __str__


def measure(
    run: Run, warn: Callable[[str], None] = print, own: Mapping[str, Metric] | None = None
) -> Metrics:
    """Return the metrics of a run; its rows at t >= 0 count.

    `warn` shows the error of a failing metric; the others continue. `own` adds metrics by name.

    Raises:
        SetcmasError: No row has t >= 0.
    """
    if not len(run.counted.t):
        raise SetcmasError('no row has t >= 0: the robots were never commanded')
    found = _found(run, warn, own or {})
    first = {name: found.pop(name) for name in _FIRST if name in found}
    known = {name: part for name, part in (first | found).items() if part is not None}
    with failures(PREDICTION, warn):
        if prediction := compared(run, known):
            known[PREDICTION] = prediction
    return Metrics(known, run)


def _found(
    run: Run, warn: Callable[[str], None], own: Mapping[str, Metric]
) -> dict[str, Measured | None]:
    found: dict[str, Measured | None] = {}
    for name, metric in {**METRICS.usable(warn), **own}.items():
        title = f"'{name}'" if name in own else METRICS.plugin(name).title
        with failures(f'metric {title}', warn):
            found[name] = measured(name, metric(run))
    return found


@contextmanager
def failures(title: str, warn: Callable[[str], None]) -> Iterator[None]:
    """Report in one line that a metric or plot, called by its title, failed."""
    try:
        yield
    except SetcmasError:
        raise
    except InvalidPluginError as error:
        warn(f'{title} {error}')
    except Exception as error:  # a plugin may raise anything
        reason = ' '.join(f'{type(error).__name__}: {error}'.split())
        warn(f'{title} failed: {reason}')


FILE_NAME = 'metrics.yaml'

_DIGITS = 6


class _Dumper(yaml.SafeDumper):
    """Writes lists in one line."""


_Dumper.add_representer(
    list, lambda dumper, data: dumper.represent_sequence('tag:yaml.org,2002:seq', data, True)
)


def as_dict(metrics: Metrics) -> dict[str, Any]:
    """Return metrics as plain, rounded values in a fixed order."""
    values = {**vars(metrics), **metrics}
    return {name: _rounded(value) for name, value in values.items() if value is not None}


def write_yaml(metrics: Metrics, path: Path) -> None:
    """Write metrics with 6 significant digits, or raise SetcmasError."""
    text = yaml.dump(as_dict(metrics), Dumper=_Dumper, sort_keys=False, width=98)
    with file_errors(f"'{path}' cannot be written"), written_whole(path) as file:
        file.write(text)


def _rounded(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _rounded(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_rounded(item) for item in value]
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float):
        return float(f'{value:.{_DIGITS}g}') + 0.0  # + 0.0: no minus before zero
    return value
