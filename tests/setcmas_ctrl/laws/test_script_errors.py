from pathlib import Path

from setcmas_ctrl.laws.script_errors import MOST_FAILURES, ControlError, ErrorReports
from setcmas_simu.script_calls import Function, ScriptFailure

DIVIDED = ControlError('law.py, line 3: ZeroDivisionError', 'a', place=(Path('law.py'), 3))
NOTHING = ControlError('law.py: control returned None', 'b', place=(Path('law.py'), None))


def failure(t, robot, error, until=None):
    line = error.place[1]
    return ScriptFailure(t, robot, Function.CONTROL, 'law.py', line, str(error), until)


def test_a_failure_lasts_until_it_works_or_fails_in_another_way():
    reports = ErrorReports(lambda _: None)
    for t in (1.0, 1.2, 1.4):
        reports.failed(2, t, DIVIDED)
    reports.failed(1, 1.4, DIVIDED)
    reports.failed(2, 1.6, NOTHING)
    reports.succeeded(2, 2.0)
    reports.failed(2, 3.0, DIVIDED)

    assert reports.failures == [
        failure(1.0, 2, DIVIDED, until=1.6),
        failure(1.4, 1, DIVIDED),
        failure(1.6, 2, NOTHING, until=2.0),
        failure(3.0, 2, DIVIDED),
    ]


def test_a_law_that_fails_at_each_other_call_fills_no_memory():
    reports = ErrorReports(lambda _: None)
    for step in range(2 * MOST_FAILURES):
        reports.failed(1, 2.0 * step, DIVIDED)
        reports.succeeded(1, 2.0 * step + 1.0)

    assert len(reports.failures) == MOST_FAILURES
    assert reports.failures[-1].until == 2.0 * MOST_FAILURES - 1.0
