import threading
from pathlib import Path

import pytest

from setcmas_ctrl.call_watch import CallWatch


@pytest.fixture
def watched():
    said, spoken = [], threading.Event()

    def say(message):
        said.append(message)
        spoken.set()

    watch = CallWatch(Path(__file__), period=0.05, say=say, stuck_s=0.2)
    yield watch, said, spoken
    watch.close()


def test_a_call_that_does_not_return_is_reported_with_its_line(watched):
    watch, said, spoken = watched

    with watch.call(3):
        assert spoken.wait(30)  # the line that the report must name

    assert 'tb3_3: control has not returned' in said[0]
    assert 'assert spoken.wait(30)  # the line that the report must name' in said[0]


def test_slow_steps_are_reported_at_most_now_and_then_with_their_count(watched):
    watch, said, _ = watched

    for _ in range(3):
        with watch.step(2):
            for robot in (1, 2):
                with watch.call(robot):
                    threading.Event().wait(0.03 * robot)

    assert len(said) == 1
    assert 's for 2 robots' in said[0]
    assert 's for tb3_2), longer than the control period of 0.05 s (so far 1 times)' in said[0]


def test_quick_calls_are_not_worth_a_word(watched):
    watch, said, _ = watched

    with watch.step(1), watch.call(1):
        assert watch.running_s >= 0

    assert watch.running_s == 0
    assert said == []


def test_a_slow_step_is_reported_even_when_it_raises(watched):
    watch, said, _ = watched

    def fail_slowly():
        with watch.step(1), watch.call(1):
            threading.Event().wait(0.06)
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fail_slowly()

    assert len(said) == 1
