import threading
from pathlib import Path

import pytest

from setcmas_ctrl.scripts.watch.call_watch import CallWatch
from setcmas_simu.reports.launcher import connected_launcher
from setcmas_simu.reports.reports import Function, ScriptCall


@pytest.fixture
def watched():
    said, spoken = [], threading.Event()

    def warn(message):
        said.append(message)
        spoken.set()

    watch = CallWatch(0.05, warn, connected_launcher({}), stuck_s=0.2)
    yield watch, said, spoken
    watch.close()


def test_a_call_that_does_not_return_is_reported_with_its_line(watched):
    watch, said, spoken = watched

    with watch.call(3, Path(__file__)):
        assert spoken.wait(30)  # the line that the report must name

    assert 'tb3_3: control has not returned' in said[0]
    assert 'assert spoken.wait(30)  # the line that the report must name' in said[0]


def test_a_slow_step_is_told_by_what_was_called_in_it(watched):
    watch, said, _ = watched

    with watch.call(1, Path(__file__)):  # before the first control period
        threading.Event().wait(0.1)
    with watch.loading(1, Path(__file__)):
        threading.Event().wait(0.1)
    with watch.step(), watch.call(1, Path(__file__)):
        assert watch.running_s >= 0
    assert watch.running_s == 0
    assert said == []

    with watch.step(), watch.call(2, Path(__file__)):
        threading.Event().wait(0.1)
    assert len(said) == 1
    assert f'{Path(__file__).name} took' in said[0]


def test_only_functions_of_a_script_hang_not_its_loading(watched):
    watch, said, spoken = watched

    with watch.loading(1, Path(__file__)):
        assert spoken.wait(30)
    assert 'test_call_watch.py has been loading for' in said[0]
    assert watch.have_been_stuck == []

    spoken.clear()
    with watch.call(1, Path('when.py'), Function.CONDITION):
        assert spoken.wait(30)
    assert 'tb3_1: ctc has not returned for' in said[1]
    assert watch.have_been_stuck == [ScriptCall(1, 'when.py', Function.CONDITION)]
