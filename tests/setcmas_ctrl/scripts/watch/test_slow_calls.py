from pathlib import Path

import pytest

from setcmas_ctrl.scripts.watch.slow_calls import SlowCalls

LAW, CONDITION = Path('law.py'), Path('when.py')


@pytest.fixture
def slow():
    said = []
    return SlowCalls(0.2, said.append), said


def test_calls_that_fit_into_the_period_together_are_not_worth_a_word(slow):
    calls, said = slow
    for step in range(3):
        calls.add(LAW, 1, 0.09)
        calls.add(LAW, 2, 0.1)
        calls.end_period(0.2 * step)

    assert said == []


def test_the_calls_for_all_robots_are_added_up_and_the_longest_is_named(slow):
    calls, said = slow
    for robot in (1, 2, 3):
        calls.add(LAW, robot, 0.05 * robot)
    calls.end_period(0.0)

    assert said == [
        'law.py took 0.30 s for 3 robots (0.15 s for tb3_3), longer than the control period of '
        '0.20 s (1 time so far)'
    ]


def test_slow_periods_are_counted_and_told_now_and_then(slow):
    calls, said = slow
    for step in range(20):
        calls.add(LAW, 1, 0.4)
        calls.end_period(0.4 * step)

    assert [message.partition(' s (')[2].rpartition('(')[2] for message in said] == [
        '1 time so far)',
        '14 times so far)',
    ]


def test_scripts_are_told_apart(slow):
    calls, said = slow
    calls.add(LAW, 1, 0.15)
    for _ in range(2):  # conditions are evaluated twice in a control period
        calls.add(CONDITION, 1, 0.15)
    calls.end_period(0.0)

    assert [message.partition(', ')[0] for message in said] == [
        'when.py took 0.30 s for 1 robot (0.30 s for tb3_1)'
    ]
