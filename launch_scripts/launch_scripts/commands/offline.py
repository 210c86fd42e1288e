"""Simulate robots under a control law without ROS, hundreds of times faster than real time.

Writes fleet.csv, plots, metrics and run.yaml, as `setcmas run` does. On the same kind of
processor, the same command writes the same files. Ctrl-C ends the run early and writes the
results so far.

Examples:
  setcmas offline square.yaml --set K=2
  setcmas offline --algo consensus --nb-robots 8 --duration 60 --output out
  setcmas offline --algo my_law.py --nb-robots 3 --pose 1:1.0,2.0,1.57
  setcmas offline --algo consensus --nb-robots 8 --graph ring --delay 0.2 --loss 0.3
  setcmas offline --from out                         repeat the run in out, and compare
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from typing import TYPE_CHECKING

from tqdm import tqdm

from launch_scripts.command_scenario import (
    add_from_argument,
    add_scenario_arguments,
    earlier_run,
    output_folder,
    scenario_to_simulate,
)
from launch_scripts.commands.csv_to_plot import print_evaluation
from launch_scripts.terminal import progress_output, warn
from setcmas_ctrl.laws.control_options import SCRIPT_FAILED
from setcmas_tools.plots.plot_options import PlotOptions
from setcmas_tools.run.run_folder import OfflineOptions, RunFolder, RunOptions
from setcmas_tools.run.run_info import RunState
from setcmas_tools.run.scenario import Scenario

if TYPE_CHECKING:
    from setcmas_tools.run.run import Run

_STOPPED = 130
_BAR = '{desc}: {percentage:3.0f}%|{bar}| {n:.0f}/{total:.0f} s'


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    RunOptions.add_to(parser)
    PlotOptions.add_to(parser, without=('show',))
    add_scenario_arguments(parser, without=('cmd_timeout', 'rtf'))
    add_from_argument(parser)
    OfflineOptions.add_to(parser)


def main(args: argparse.Namespace) -> int:
    """Run, and write the results; return the exit status."""
    scenario, earlier = scenario_to_simulate(args).found(), earlier_run(args)
    folder = RunFolder(output_folder(args, scenario))
    folder.check(args.overwrite)
    run, elapsed = _simulate(scenario, args.call_timeout)
    from setcmas_tools.run.run import Run  # late: help texts do not wait for it

    if not len(run.table.t):
        return _report_outcome(run)
    info = replace(run.info, command=['setcmas', *sys.argv[1:]])
    replace(run, info=info).save(folder.path, args.overwrite)
    # Measure what the files contain, so that `setcmas metrics` gives the same.
    files = print_evaluation(args, folder, Run.load(folder.path, warn), earlier)
    print(f'{_speed(run, elapsed)}{files}')
    if run.outcome.state in (RunState.COMPLETE, RunState.FAILED) and run.table.t[-1] < elapsed:
        warn(
            'setcmas offline: this law is slower than real time: over ROS and in experiments its '
            'velocities come too late'
        )
    return _report_outcome(run)


def _speed(run: Run, elapsed: float) -> str:
    """Return simulated and elapsed time as text; '' if nothing was simulated."""
    simulated = float(run.table.t[-1])
    if not simulated:
        return ''
    times = simulated / elapsed
    return f'{simulated:g} s in {elapsed:.2f} s ({times:.{int(times < 10)}f} times real time)   '


def _report_outcome(run: Run) -> int:
    """Report how a run ended, unless already reported; return the exit status."""
    if run.outcome.state is RunState.STOPPED:
        return _STOPPED
    if run.outcome.state is RunState.DIED:
        ending = _written(run.table.t[-1:].sum())
    elif run.failed_robots:
        ending = '; see the messages above the table'
    else:
        return 0
    warn(f'setcmas offline: {run.outcome}{ending}')
    return SCRIPT_FAILED


def _written(seconds: float) -> str:
    return f'\n    the first {seconds:g} s are written' if seconds else ''


def _simulate(scenario: Scenario, call_timeout: float) -> tuple[Run, float]:
    """Return the run, or what there is of it, and its time in s; scripts run elsewhere."""
    from setcmas_tools.offline.offline_run import OfflineRun

    robot_rate, duration = scenario.robots.robot_rate, scenario.time.duration
    with (
        tqdm(total=duration, desc='running', bar_format=_BAR, disable=None) as bar,
        progress_output(),
        OfflineRun(scenario) as offline_run,
    ):

        def show() -> None:
            bar.update(max(0, offline_run.progress.done - 1) / robot_rate - bar.n)

        try:
            return offline_run.result(warn, call_timeout, look=show), offline_run.elapsed
        except KeyboardInterrupt:
            message = f'setcmas offline: stopped by the user{offline_run.place()}'
            run = offline_run.stopped()
            warn(f'{message}{_written(run.table.t[-1:].sum())}')
            if not run.table.t[-1:].sum():
                raise
            return run, offline_run.elapsed
