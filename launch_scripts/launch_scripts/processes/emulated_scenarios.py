"""Runner of the scenarios of a rubric in the emulated lab, one after the other, in real time."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from launch_scripts.processes.environment import require_ros
from launch_scripts.processes.node_commands import node_command
from launch_scripts.terminal.output_lines import teller
from setcmas_simu.errors import SetcmasError
from setcmas_simu.options.group import spelled
from setcmas_tools.grading.marks import Failure, LawRunner, ScenarioRun
from setcmas_tools.grading.rubric import Rubric
from setcmas_tools.grading.scenarios import CONTROL, Scenario
from setcmas_tools.offline.given import pose_options
from setcmas_tools.run.outcome import State
from setcmas_tools.run.run import Run
from setcmas_tools.studies.cases.names import OPTIONS

_RUN = ('run', '--emulate', '--no-plots')
_MISTAKEN = 2
_TO_THE_END = (State.COMPLETE, State.FAILED)


def runners_in_lab(rubric: Rubric, verb: str) -> Callable[[Path], LawRunner]:
    """Return what returns the runner of a script in the emulated lab; the solution is run at once.

    Args:
        rubric: Whose scenarios are run.
        verb: The command that tells what is run now, for it takes its time.

    Raises:
        SetcmasError: There is no ROS, or the solution does not come to its end.
    """
    require_ros('without --emulate no ROS is needed; ')
    tell = teller(verb)
    _run_solution(rubric, tell)
    return lambda script: _runs_emulated(script, rubric, tell)


def _runs_emulated(script: Path | None, rubric: Rubric, tell: Callable[[str], None]) -> LawRunner:
    """Return what runs scenarios with a script as `setcmas run --emulate` does, in no sandbox.

    No script is the condition by default.
    """

    def run(scenario: Scenario) -> ScenarioRun:
        name = script.name if script else 'the solution'
        tell(f'{name}, {scenario.name}: {scenario.seconds:g} s in the emulated lab')
        job = scenario.job(str(script) if script else None, rubric.function)
        done = _in_lab(job, script)
        if done.failure and done.run and done.run.outcome.state is State.COMPLETE:
            # Something else than the script has stopped the robots, such as a machine too busy.
            tell(f'{done.failure.message}; once more')
            done = _in_lab(job, script)
        return done

    return run


def _in_lab(job: Mapping[str, Any], script: Path | None) -> ScenarioRun:
    with TemporaryDirectory(prefix='setcmas_') as folder:
        place = Path(folder, 'run')
        options = [*command_line(job), '--output', str(place)]
        command = node_command('launch_scripts.cli', [*_RUN, *options])
        done = subprocess.run(command, capture_output=True, text=True, errors='replace')
        if done.returncode == _MISTAKEN or not (place / 'csv').is_dir():
            return _not_run(done.stderr, script)
        made = Run.load(place, lambda _: None)
    is_whole = made.outcome.state in _TO_THE_END
    is_well = made.outcome.state is State.COMPLETE and not made.outcome.detail
    return ScenarioRun(made, None if is_well else Failure(str(made.outcome)), is_whole)


def _run_solution(rubric: Rubric, tell: Callable[[str], None]) -> None:
    """Run the model solution of a rubric in the emulated lab; its paths are the wanted ones."""
    if rubric.solution is None and rubric.function == CONTROL:
        return
    run = _runs_emulated(rubric.solution, rubric, tell)
    for scenario in rubric.scenarios:
        made = run(scenario)
        if not made.run or made.failure:
            reason = made.failure.message if made.failure else 'it did not start'
            raise SetcmasError(
                f"the solution fails in scenario '{scenario.name}' of {rubric.file}: {reason}"
            )
        rubric.keep_solution(scenario, made.run)


def command_line(job: Mapping[str, Any]) -> Iterator[str]:
    """Yield the options of `setcmas run` that are some arguments of `simulate`.

    Raises:
        SetcmasError: An argument has no option, as a matrix has none.
    """
    for name, value in job.items():
        if name == 'poses':
            yield from (f'--pose={text}' for text in pose_options(value))
        elif name == 'settings':
            yield from (f'--set={name}={json.dumps(one)}' for name, one in value.items())
        elif name == 'graph' and not isinstance(value, str):
            raise SetcmasError('graph is a matrix; in the emulated lab it must be a file')
        elif value is not None:
            yield from OPTIONS[name].typed(spelled(name), value)


def _not_run(messages: str, script: Path | None) -> ScenarioRun:
    """Return that there was no run, if it is the script that has a mistake.

    Raises:
        SetcmasError: It is not.
    """
    told = [line for line in messages.splitlines() if line.strip()] or ['it did not start']
    message = told[-1].removeprefix('setcmas run: ')
    if script is None or script.name not in messages:
        raise SetcmasError(f'the emulated lab: {message}')
    return ScenarioRun(None, Failure(message), is_complete=False)
