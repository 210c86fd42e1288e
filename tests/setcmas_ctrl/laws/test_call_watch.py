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
    assert f'{Path(__file__).name} took' in said[0]


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


LAW, CONDITION = Path('law.py'), Path('when.py')


@pytest.fixture
def slow():
    said = []
    slow = SlowCalls(said.append)
    slow.period = 0.2
    return slow, said


def test_the_calls_of_each_script_for_all_robots_are_added_up_and_the_longest_is_named(slow):
    calls, said = slow
    for robot in (1, 2, 3):
        calls.add(LAW, robot, 0.05 * robot)
    for _ in range(2):  # conditions are evaluated twice in a control period
        calls.add(CONDITION, 1, 0.09)
    calls.end_period(0.0)

    assert said == [
        'law.py took 0.30 s for 3 robots (0.15 s for tb3_3), longer than the control period of '
        '0.20 s (1 time so far)'
    ]


def test_slow_periods_are_counted_and_reported_now_and_then(slow):
    calls, said = slow
    for step in range(20):
        calls.add(LAW, 1, 0.4)
        calls.end_period(0.4 * step)

    assert [message.partition(' s (')[2].rpartition('(')[2] for message in said] == [
        '1 time so far)',
        '14 times so far)',
    ]
