"""Runner of scenarios with a submission that is held in a box."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace

from setcmas_ctrl.scripts.loader import SEED
from setcmas_tools.grade.marks import Failure, ScenarioRun
from setcmas_tools.grade.rubric_scenarios import CONTROL, CTC, Scenario
from setcmas_tools.grade.sandbox.box import Box
from setcmas_tools.grade.sandbox.held import Held, LostError, Times
from setcmas_tools.grade.sandbox.job import Job
from setcmas_tools.offline.engine import simulate

_PLACE = re.compile(r'(\S+\.py), line (\d+)')


@dataclass(frozen=True)
class BoxRunner:
    """Runs scenarios with a submission; the engine is here, the submission in a box.

    Attributes:
        box: Holds the submission.
        script: Name of its script.
        files: Its files by their names, the script among them.
        times: How long it may take.
        function: CONTROL or CTC.
    """

    box: Box
    script: str
    files: Mapping[str, bytes]
    times: Times
    function: str = CONTROL

    def __call__(self, scenario: Scenario) -> ScenarioRun:
        """Return the run of a scenario with the submission."""
        arguments = dict(scenario.arguments)
        nb_robots = arguments.get('nb_robots', 1)
        job = Job(
            self.script,
            self.function == CTC,
            nb_robots,
            arguments.get('seed', SEED),
            {} if self.function == CTC else arguments.pop('settings', {}),
            math.ceil(self.times.run),
        )
        held = Held(self.box, self.files, job, self.times)
        fleet = replace(scenario, arguments=arguments)
        try:
            run = simulate(**held.job(fleet), warn=_ignore)
        except LostError:
            return ScenarioRun(None, self._failure(held.trouble), is_complete=False)
        finally:
            self.box.drop()
        return ScenarioRun(run, self._failure(held.trouble))

    def _failure(self, trouble: Failure | None) -> Failure | None:
        """Return what went wrong, with the lines around it."""
        if not trouble:
            return None
        file, line = trouble.script, trouble.line
        if not line and (found := _PLACE.search(trouble.message)):
            file, line = found[1], int(found[2])
        source = self.files.get(file, b'').decode(errors='replace')
        if not source or not line:
            return replace(trouble, script='', line=0)
        return trouble.at(file, line, source)


def _ignore(_: str) -> None:
    """Tell nobody: what fails first is in the marks."""
