from setcmas_tools.view.model.robot_states import ERROR, OK, WARN, Diagnosis, RobotStates
from setcmas_tools.view.model.run_clock import RunClock


def test_in_a_simulation_the_last_wish_counts():
    states = RobotStates()
    assert states.describe(1, False, 0.2, 0.0) == (OK, 'moving')
    assert states.describe(1, False, 0.0, 0.0) == (OK, 'standing')
    states.wish(True)

    assert states.paused(100.0)
    assert states.describe(1, False, 0.0, 100.0) == (WARN, 'paused')
    assert states.describe(1, True, 0.0, 100.0) == (ERROR, 'lost')


def test_in_an_experiment_the_pause_node_counts_and_its_silence_means_paused():
    states = RobotStates()
    states.wish(True)
    states.announce(False, 10.0)

    assert not states.paused(10.4)
    assert states.paused(10.6)


def test_diagnostics_tell_why_a_robot_is_stopped():
    states = RobotStates()
    states.diagnose(1, Diagnosis(WARN, 'stopped', 'pose 0.4 s old', 10.0))

    assert states.describe(1, False, 0.3, 10.5) == (WARN, 'stopped: pose 0.4 s old')
    assert states.describe(1, False, 0.3, 20.0) == (OK, 'moving')
    states.diagnose(1, Diagnosis(WARN, 'paused', 'paused', 10.0))
    assert states.describe(1, False, 0.0, 10.5) == (WARN, 'paused')


def test_the_clock_begins_with_the_first_command_and_holds_when_they_end():
    clock = RunClock()
    assert clock.seconds(5.0) is None
    for now in (5.0, 6.0, 7.0):
        clock.heard(now)

    assert clock.seconds(7.5) == 2.5
    assert clock.seconds(20.0) == 2.0
    clock.heard(30.0)
    assert clock.seconds(30.5) == 0.5
