"""List laws, exercises, robot models, mocap sources, tasks, metrics and plots.

Each entry names its package. The last two tables list columns of studies, and
comparisons for rubrics.

Examples:
  setcmas list
"""

from __future__ import annotations

import argparse
import inspect
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from tabulate import tabulate

from setcmas_ctrl.laws.references import TASKS
from setcmas_ctrl.laws.script_loader import ALGORITHMS, CONDITIONS, EXERCISES
from setcmas_ctrl.laws.script_search import scripts_in, summary_of
from setcmas_expe.mocap.sources import MOCAP_SOURCES, MocapSource
from setcmas_simu.plugins import Plugin, PluginError, PluginGroup, ScriptGroup
from setcmas_simu.robots.models_by_name import MODELS
from setcmas_tools.grade.criteria import COMPARED
from setcmas_tools.measures.metric import METRICS
from setcmas_tools.plots.plot import PLOTS
from setcmas_tools.study.study_columns import COLUMNS


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb: none."""
    del parser


def main(args: argparse.Namespace) -> int:
    """Print a table per group of plugins; return the exit status."""
    del args
    _print('control laws, for --algo', _scripts(ALGORITHMS))
    _print('exercises, for --algo with --exercise', _scripts(EXERCISES))
    _print('triggering conditions, for --ctc', _scripts(CONDITIONS))
    _print('in this folder, for --algo (these take precedence)', _own_scripts(Path.cwd()))
    _print('robot models, for --model', _rows(MODELS, _purpose))
    _print('motion capture, for --mocap and lab files', _rows(MOCAP_SOURCES, _source))
    _print("tasks, for a law that says task = '...'", _tasks())
    _print('metrics, for every run', _rows(METRICS, _purpose))
    _print('plots, for every run they apply to', _rows(PLOTS, _purpose))
    columns = ((name, column.unit, column.purpose) for name, column in COLUMNS.items())
    _print('columns of a study (setcmas sweep), for --metric and rubrics', columns)
    compared = ((name, *unit_and_purpose) for name, unit_and_purpose in COMPARED.items())
    _print('comparisons with a solution, for rubrics', compared)
    return 0


def _own_scripts(folder: Path) -> Iterable[tuple[str, ...]]:
    for path in scripts_in(folder):
        summary = summary_of(path)
        if summary is not None:
            yield path.stem, summary


def _scripts(group: ScriptGroup) -> Iterable[tuple[str, ...]]:
    return _described(group, lambda name: summary_of(group.file(name)) or '(must define control)')


def _rows(group: PluginGroup[Any], describe: Callable[[Any], str]) -> Iterable[tuple[str, ...]]:
    return _described(group, lambda name: describe(group.get(name)))


def _purpose(thing: object) -> str:
    """Return the first line of the docstring of a function or of an object's class."""
    purpose = (inspect.getdoc(thing) or '').partition('\n')[0].removeprefix('Return ')
    return purpose[:1].upper() + purpose[1:]


def _source(source: MocapSource) -> str:
    return f'{source.message_type.rpartition("/")[2]} on {source.topic}'


def _tasks() -> Iterable[tuple[str, ...]]:
    for task, references in TASKS.items():
        yield task, f'takes {", ".join(references) or "nothing"} from the law'


def _described(
    group: PluginGroup[Any] | ScriptGroup, summary: Callable[[str], str]
) -> Iterable[tuple[str, ...]]:
    """Yield names, package and summary; names of the same object share a row."""
    same: dict[str, list[Plugin]] = {}
    for plugin in group.plugins().values():
        same.setdefault(plugin.entry.value, []).append(plugin)
    for same_object in same.values():
        try:
            described = summary(same_object[0].name)
        except PluginError as error:
            described = f'(cannot be used: {error.reason})'
        names = ', '.join(plugin.name for plugin in same_object)
        yield names, f'{same_object[0].package} {same_object[0].version}', described


def _print(title: str, rows: Iterable[tuple[str, ...]]) -> None:
    table = tabulate(rows, tablefmt='plain', disable_numparse=True)
    lines = table.splitlines() or ['none; write one with setcmas new my_law']
    print(f'{title}:')
    for line in lines:
        print(f'  {line}'.rstrip())
