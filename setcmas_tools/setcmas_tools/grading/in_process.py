"""Runner of scenarios in this process, for laws that are trusted: one's own."""

from __future__ import annotations

from typing import Any

from setcmas_simu.errors import SetcmasError
from setcmas_tools.grading.marks import Failure, LawRunner, ScenarioRun
from setcmas_tools.grading.scenarios import CONTROL, Scenario
from setcmas_tools.offline.engine import simulate


def runs_here(submission: Any, function: str = CONTROL) -> LawRunner:
    """Return what runs scenarios with a submission as `simulate` does.

    Args:
        submission: What `Scenario.job` takes.
        function: Which function it is.
    """

    def run(scenario: Scenario) -> ScenarioRun:
        messages: list[str] = []
        try:
            made = simulate(**scenario.job(submission, function), warn=messages.append)
        except SetcmasError as error:
            return ScenarioRun(None, Failure(str(error)), is_complete=False)
        return ScenarioRun(made, Failure(messages[0]) if messages else None)

    return run
