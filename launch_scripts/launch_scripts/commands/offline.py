"""Run a control law on simulated robots without ROS, hundreds of times faster than real time.

Writes fleet.csv, the plots, the metrics and run.yaml, as `setcmas run` does; equal commands
write equal files. Ctrl-C ends it early; what was simulated until then is written.

Examples:
  setcmas offline --algo consensus --nb-robots 8 --duration 60 --output out
  setcmas offline --algo my_law.py --nb-robots 3 --pose 1:1.0,2.0,1.57
  setcmas offline --algo consensus --nb-robots 5 --set K=1.2
  setcmas offline --algo consensus --nb-robots 8 --graph ring --delay 0.2 --loss 0.3
  setcmas offline --from out                         the run in out again, and how it compares
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from tqdm import tqdm

from launch_scripts.commands.earlier_run import with_earlier_run
from launch_scripts.commands.run_options import add_run_arguments, output_folder, parameters
from launch_scripts.terminal.terminal_output import progress_output, warn
from setcmas_ctrl.communication.communication_options import CommunicationOptions
from setcmas_ctrl.communication.communication_settings import check_communication
from setcmas_ctrl.control.control_options import SCRIPT_FAILED, LawOptions
from setcmas_ctrl.control.law_scripts import LawScripts
from setcmas_ctrl.filter.clearance import check_starts
from setcmas_ctrl.filter.filter_options import FilterOptions
from setcmas_simu.reports.reports import ScriptFailure
from setcmas_simu.simulator.simulator_options import SimulationOptions
from setcmas_tools.run.inputs import run_inputs
from setcmas_tools.run.run_folder import OfflineOptions, RunFolder
from setcmas_tools.run.run_info import Outcome, State

if TYPE_CHECKING:
    from setcmas_tools.run.run import Run

_AS_TYPED = (
    'nb_robots', 'duration', 'model', 'limits', 'vnom', 'komega', 'rate', 'robot_rate', 'seed',
)  # fmt: skip
_STOPPED = 130
_BAR = '{desc}: {percentage:3.0f}%|{bar}| {n:.0f}/{total:.0f} s'


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    add_run_arguments(parser, without=('watch', 'cmd_timeout', 'lockstep', 'rtf'))
    OfflineOptions.add_to(parser)


def main(args: argparse.Namespace) -> int:
    """Run, and write the results; returns the exit status."""
    args, earlier = with_earlier_run(args)
    law = LawOptions.of(args)
    scripts = law.scripts()
    scripts.check(args.nb_robots)
    poses = SimulationOptions.of(args).simulated().start_poses  # mistakes are told before
    safety = FilterOptions.of(args)
    check_starts(safety, poses)
    communication = CommunicationOptions.of(args).found(law.exercise)
    for note in (*scripts.notes, *communication.notes, *safety.notes):
        warn(f'setcmas offline: {note}')
    check_communication(communication, args.nb_robots)
    inputs = run_inputs(args, scripts)
    folder = RunFolder(output_folder(args, scripts), inputs)
    folder.check(args.overwrite)
    run, elapsed = _simulate(args, scripts, law.settings, communication)
    # Imported late: help texts and completion do not wait for it.
    from setcmas_tools.compare.run_distance import compared
    from setcmas_tools.evaluation import evaluate
    from setcmas_tools.plots.look import PlotLook
    from setcmas_tools.run.run import Run

    if not len(run.table.t):
        return _told(run)
    command = ['setcmas', *sys.argv[1:]]
    info = replace(run.info, command=command, parameters=parameters(args, scripts))
    replace(run, info=info, inputs=tuple(inputs)).save(folder.path, args.overwrite)
    # What is in the files is measured, so that `setcmas metrics` finds the same.
    saved = replace(Run.load(folder.path, warn), call_time=run.call_time)
    look = PlotLook(tuple(args.format))
    plots = folder.plots if args.plots else None
    evaluation = evaluate(saved, plots, look, folder.metrics, warn)
    print(evaluation)
    if earlier:
        print(compared(folder.path, earlier))
    print(f'{_speed(run, elapsed)}{folder.summary(len(evaluation.plots))}')
    return _told(run)


def _speed(run: Run, elapsed: float) -> str:
    """Return how fast it was, in words; empty if nothing was simulated."""
    simulated = float(run.table.t[-1])
    if not simulated:
        return ''
    times = simulated / elapsed
    return f'{simulated:g} s in {elapsed:.2f} s ({times:.{int(times < 10)}f} times real time)   '


def _told(run: Run) -> int:
    """Tell how a run ended, unless that was told; returns the exit status."""
    if run.outcome.state is State.STOPPED:
        return _STOPPED
    if run.outcome.state is State.DIED:
        warn(f'setcmas offline: {run.outcome}{_written(run.table.t[-1:].sum())}')
        return SCRIPT_FAILED
    if run.failed_robots:
        warn(f'setcmas offline: {run.outcome}; the messages above the table tell why')
        return SCRIPT_FAILED
    return 0


def _written(seconds: float) -> str:
    return f'\n    the first {seconds:g} s are written' if seconds else ''


def _simulate(
    args: argparse.Namespace,
    scripts: LawScripts,
    settings: Mapping[str, Any],
    communication: CommunicationOptions,
) -> tuple[Run, float]:
    """Return the run, or what is left of it, and its time in s; scripts cannot harm us."""
    from setcmas_tools.offline.history import remains
    from setcmas_tools.offline.offline_run import BrokenRun, OfflineRun

    job = {
        'algo': scripts.text,
        'poses': SimulationOptions.of(args).start_poses(args.nb_robots),
        'settings': settings,
        **{name: getattr(args, name) for name in _AS_TYPED},
        **communication.values(),
        **FilterOptions.of(args).values(),
    }
    with (
        tqdm(total=args.duration, desc='running', bar_format=_BAR, disable=None) as bar,
        progress_output(),
        OfflineRun(job, scripts) as offline_run,
    ):

        def show(states: int) -> None:
            bar.update(max(0, states - 1) / args.robot_rate - bar.n)

        begin = time.perf_counter()
        try:
            run = offline_run.result(args.call_timeout, warn, show)
            elapsed = offline_run.elapsed or time.perf_counter() - begin
        except KeyboardInterrupt:
            told = f'setcmas offline: stopped by the user{offline_run.place()}'
            states = offline_run.states()
            if len(states) < 2:
                warn(told)
                raise
            warn(f'{told}{_written((len(states) - 1) / args.robot_rate)}')
            elapsed = time.perf_counter() - begin
            return remains(states, args.robot_rate, Outcome(State.STOPPED)), elapsed
    if not isinstance(run, BrokenRun):
        return run, elapsed
    failed = {scripts.script(run.robot).name: [run.robot]} if run.robot else {}
    outcome = Outcome(State.DIED, failed, {}, str(run))
    rest = remains(run.states, args.robot_rate, outcome)
    t = max(0, len(run.states) - 1) / args.robot_rate
    ended = ScriptFailure(t, run.robot, run.function, run.file, run.line or None, run.reason)
    return replace(rest, info=replace(rest.info, failures=[ended])), elapsed
