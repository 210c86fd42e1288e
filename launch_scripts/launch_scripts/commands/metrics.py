"""Measure a run: path, speed and separation of the robots, and how well they did their task.

The table goes to the terminal and, without rounding to the table's digits, into metrics.yaml in
the folder of the run. The task is that of the run's built-in law; for a script of your own that
defines the same names as a built-in one (WPL; PLACES; D; R and W) it is told with --task.

Examples:
  setcmas metrics out                                a run's folder
  setcmas metrics out --task waypoints --algo my_law.py
  setcmas metrics somebody_elses.bag --vnom 0.2
"""

from __future__ import annotations

import argparse
import shutil
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from launch_scripts.terminal.output_lines import warn
from setcmas_simu.errors import SetcmasError
from setcmas_simu.options.group import Options, option
from setcmas_simu.options.kinds import Kind, Number, OneOf
from setcmas_tools.run.references import TASKS

if TYPE_CHECKING:
    from setcmas_tools.metrics.compute import Metrics

_BAG_ENDINGS = ('.mcap', '.db3', '.bag', '.active')


@dataclass(frozen=True, kw_only=True)
class MetricsOptions(Options):
    """What is measured against, where the run does not tell."""

    task: str | None = option(
        OneOf(tuple(TASKS)),
        'what the robots were to do',
        default=None,
        default_text="the built-in law's",
    )
    algo: str | None = option(
        Kind(metavar='NAME'),
        'control law that defines the numbers of the task',
        default=None,
        default_text='that of run.yaml',
    )
    vnom: float | None = option(
        Number(above=0, unit='m/s'),
        'largest speed of a robot in m/s',
        default=None,
        default_text='that of run.yaml, else 0.5',
    )


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    parser.add_argument(
        'run',
        type=Path,
        metavar='DIR',
        help='folder of a run, of its CSV files, a fleet.csv, or a bag',
    )
    MetricsOptions.add_to(parser)


def main(args: argparse.Namespace) -> int:
    """Measure; returns the exit status."""
    from setcmas_tools.metrics.table import table_lines
    from setcmas_tools.metrics.yaml_file import write_yaml

    bag = _bag(args.run)
    metrics, target = _of_bag(bag, args) if bag else _of_table(args)
    for line in table_lines(metrics):
        print(line)
    if metrics.task is None:
        print(f'the task is not known: --task {{{",".join(TASKS)}}} and --algo tell it')
    write_yaml(metrics, target)
    print(target)
    return 0


def _bag(run: Path) -> Path | None:
    """Return the bag that a path means; None if it means CSV files."""
    if run.is_file():
        return run if run.suffix in _BAG_ENDINGS else None
    if any((run / place).is_file() for place in ('csv/fleet.csv', 'fleet.csv')):
        return None
    is_bag = run.is_dir() and any(
        file.name == 'metadata.yaml' or file.suffix in _BAG_ENDINGS for file in run.iterdir()
    )
    if is_bag:
        return run
    return run / 'bag' if (run / 'bag').is_dir() else None


def _of_table(args: argparse.Namespace) -> tuple[Metrics, Path]:
    from setcmas_tools.metrics.compute import compute
    from setcmas_tools.metrics.yaml_file import metrics_file
    from setcmas_tools.run.files import fleet_csv

    metrics = compute(args.run, args.task, args.vnom, args.algo)
    return metrics, metrics_file(fleet_csv(args.run))


def _of_bag(bag: Path, args: argparse.Namespace) -> tuple[Metrics, Path]:
    """Measure a bag; metrics.yaml goes into the folder of its run, else beside the bag."""
    from setcmas_tools.metrics.compute import compute
    from setcmas_tools.metrics.yaml_file import FILE_NAME
    from setcmas_tools.run.files import INPUTS
    from setcmas_tools.tables.convert import convert

    resolved = bag.resolve()
    is_of_run = resolved.is_dir() and resolved.name == 'bag'
    with tempfile.TemporaryDirectory(prefix='setcmas-metrics-') as temporary:
        folder = Path(temporary)
        if is_of_run and (resolved.parent / 'run.yaml').is_file():
            shutil.copy(resolved.parent / 'run.yaml', folder)
            if (resolved.parent / INPUTS).is_dir():
                shutil.copytree(resolved.parent / INPUTS, folder / INPUTS)
        report = convert(bag, folder / 'csv')
        for notice in report.notices:
            warn(f'setcmas metrics: {notice}')
        if not report.fleet:
            raise SetcmasError(f"bag '{bag}' holds no odometry of robots (/tb3_i/odom)")
        metrics = compute(folder, args.task, args.vnom, args.algo)
    beside = FILE_NAME if is_of_run else f'{resolved.stem}_{FILE_NAME}'
    return metrics, resolved.parent / beside
