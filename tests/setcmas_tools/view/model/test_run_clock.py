import pytest

from setcmas_tools.view.model.run_clock import RunClock


def hear(clock, first, last, paused=False):
    for k in range(round(5 * first), round(5 * last) + 1):
        clock.heard(k / 5, paused)


def test_counts_from_the_first_command_and_holds_after_the_last():
    clock = RunClock()
    assert clock.seconds(3.0) is None
    assert clock.describe(3.0) == 'not controlled yet'
    hear(clock, 10.0, 14.0)

    assert clock.seconds(14.1) == pytest.approx(4.1)
    assert clock.describe(14.1) == 'running'
    assert clock.seconds(20.0) == pytest.approx(4.0)
    assert clock.describe(20.0) == 'control has ended'


def test_commands_after_a_silence_are_a_new_run():
    clock = RunClock()
    hear(clock, 0.0, 5.0)
    hear(clock, 10.0, 11.0)

    assert clock.seconds(11.0) == pytest.approx(1.0)


def test_stands_still_while_an_experiment_is_paused():
    clock = RunClock()
    hear(clock, 0.0, 5.0, paused=True)
    assert clock.seconds(5.1) == 0.0
    hear(clock, 5.2, 8.2)
    hear(clock, 8.4, 20.0, paused=True)

    assert clock.seconds(20.1) == pytest.approx(3.2)


def test_the_time_of_a_simulation_goes_before():
    clock = RunClock()
    clock.follow(1.0)
    assert clock.seconds(0.0) is None
    hear(clock, 0.0, 0.2)
    clock.follow(61.0)

    assert clock.seconds(0.3) == 60.0
