import threading
from pathlib import Path

import pytest

from setcmas_ctrl.laws.call_watch import CallWatch, SlowCalls
from setcmas_simu.reports import connected_launcher
from setcmas_simu.script_calls import Function, ScriptCall


@pytest.fixture
def watched():
    said, spoken = [], threading.Event()

    def warn(message):
        said.append(message)
        spoken.set()

    watch = CallWatch(warn, connected_launcher({}), stuck_s=0.2)
    watch.slow.period = 0.05
    yield watch, said, spoken
    watch.close()


def test_a_call_that_does_not_return_is_reported_with_its_line(watched):
    watch, said, spoken = watched

    with watch.call(3, Path(__file__)):
        assert spoken.wait(30)  # the line that the report must name

    assert 'tb3_3: control has not returned' in said[0]
    assert 'assert spoken.wait(30)  # the line that the report must name' in said[0]


def test_a_slow_step_is_reported_with_its_calls(watched):
    watch, said, _ = watched

    with watch.call(1, Path(__file__)):  # before the first control period
        threading.Event().wait(0.1)
    watch.begin_period()
    with watch.call(1, Path(__file__), Function.LOADING):
        threading.Event().wait(0.1)
    with watch.call(1, Path(__file__)):
        assert watch.running_s >= 0
    assert watch.running_s == 0
    watch.end_period()
    assert said == []

    watch.begin_period()
    with watch.call(2, Path(__file__)):
        threading.Event().wait(0.1)
    watch.end_period()
    assert len(said) == 1
    assert f's of it {Path(__file__).name} for tb3_2), longer than' in said[0]


def test_only_functions_of_a_script_hang_not_its_loading(watched):
    watch, said, spoken = watched

    with watch.call(1, Path(__file__), Function.LOADING):
        assert spoken.wait(30)
    assert 'test_call_watch.py has been loading for' in said[0]
    assert watch.have_been_stuck == []

    spoken.clear()
    with watch.call(1, Path('when.py'), Function.CONDITION):
        assert spoken.wait(30)
    assert 'tb3_1: ctc has not returned for' in said[1]
    assert watch.have_been_stuck == [ScriptCall(1, 'when.py', Function.CONDITION)]


def test_the_calls_of_all_scripts_are_added_up_and_slow_periods_reported_now_and_then():
    said = []
    calls = SlowCalls(said.append)
    calls.period = 0.2
    for step in range(20):
        for robot in (1, 2, 3):
            calls.add(Path('law.py'), robot, 0.05 * robot)
        calls.add(Path('when.py'), 1, 0.1)
        calls.end_period(0.4 * step)

    message = (
        'scripts took 0.40 s for 3 robots (0.15 s of it law.py for tb3_3), longer than the '
        'control period of 0.20 s ({} so far)'
    )
    assert said == [message.format('1 time'), message.format('14 times')]
