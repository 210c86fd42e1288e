"""Runner of the scenarios of a rubric, each in an offline process of its own."""

from __future__ import annotations

import io
import re
from contextlib import redirect_stderr
from itertools import dropwhile, takewhile
from pathlib import Path

from launch_scripts.processes.offline_process import BrokenRun, OfflineProcess
from setcmas_ctrl.control.law_scripts import LawScripts
from setcmas_simu.robots.unicycle import RATE_HZ
from setcmas_tools.grade.marks import Failure, LawRunner, ScenarioRun
from setcmas_tools.grade.rubric import Rubric
from setcmas_tools.grade.rubric_scenarios import Scenario
from setcmas_tools.offline.history import remains
from setcmas_tools.run.run_info import Outcome, State

_OF_SCRIPT = re.compile(r'tb3_\d+: ')  # what it prints, and warnings such as numpy's


def runs_apart(script: Path, rubric: Rubric, call_timeout: float) -> LawRunner:
    """Return what runs scenarios with a script; it can hang or die without harm.

    Args:
        script: The script.
        rubric: Whose scenarios are run.
        call_timeout: Time in s after which a call that does not return ends a run.

    Returns:
        A runner that raises SetcmasError if the script cannot be loaded.
    """

    def run(scenario: Scenario) -> ScenarioRun:
        job = scenario.job(str(script), rubric.function)
        told = io.StringIO()
        with redirect_stderr(told), OfflineProcess(job, LawScripts(str(job['algo']))) as process:
            made = process.run(call_timeout, lambda _: None, lambda _: None)
        if isinstance(made, BrokenRun):
            outcome = Outcome(State.DIED, {}, {}, str(made))
            rest = remains(made.states, job.get('robot_rate', RATE_HZ), outcome)
            return ScenarioRun(rest, Failure(str(made)), is_complete=False)
        message = _first_message(told.getvalue())
        return ScenarioRun(made, Failure(message) if message else None)

    return run


def _first_message(text: str) -> str:
    """Return the first message that is not the script's own, with the lines that belong to it."""
    told = (line for line in text.splitlines() if not _OF_SCRIPT.match(line))
    first, *others = [*dropwhile(lambda line: line.startswith(' '), told), '']
    return '\n'.join([first, *takewhile(lambda line: line.startswith(' '), others)])
