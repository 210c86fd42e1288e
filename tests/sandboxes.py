"""Runs of submissions in the sandbox, for tests; skipped where bubblewrap cannot confine them."""

import pytest

from setcmas_tools.grade.rubric import MarkedScenario
from setcmas_tools.grade.submission_run import SandboxRunner, Times
from setcmas_tools.run.scenario import Scenario
from setcmas_tools.submissions.sandbox import obstacle
from setcmas_tools.submissions.submissions import Submission
from setcmas_tools.submissions.submitted_files import Student

needs_sandbox = pytest.mark.skipif(
    bool(obstacle()), reason=f'no sandbox of bubblewrap: {obstacle()}'
)
SHORT = Scenario.of('', nb_robots=2, duration=1.0)


def run(script, scenario=SHORT, times=None, **others):
    """Return the run of a submission that is a script."""
    files = {'law.py': script if isinstance(script, bytes) else script.encode()}
    submission = Submission('law.py', Student('Ada'), 'law.py', files)
    runner = SandboxRunner(submission, times or Times(5.0, 20.0), **others)
    return runner(MarkedScenario('one', (), scenario))
