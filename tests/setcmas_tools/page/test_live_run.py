import math

import numpy as np
import pytest

from setcmas_tools.page.live_run import (
    FORGOTTEN_S,
    LOST_S,
    MOST_FRAMES,
    LiveRun,
    PauseStates,
    RobotDiagnosis,
    RunClock,
)


@pytest.fixture
def run():
    return LiveRun(0.0)


def by_kind(run, now):
    return {message['kind']: message for message in run.changes(now)}


def test_what_changes_is_sent_once(run):
    run.see(2, (0.5, -1.0, 0.25), 0.1, 1.0)
    first = by_kind(run, 1.0)

    assert list(first) == ['begin', 'looks', 'states', 'frame', 'status', 'now']
    assert [look['name'] for _, look in first['looks']['items']] == ['tb3_2']
    frame = first['frame']
    assert (frame['t'], frame['numbers'], frame['put']) == (1.0, [2], [2])
    assert frame['poses'] == [0.5, -1.0, 0.25, 0.1]
    assert first['states']['items'] == [(2, ('', 'moving', 'moving'))]
    assert first['status']['title'] == '1 robot'
    assert list(by_kind(run, 1.1)) == ['now']
    run.see(2, (0.51, -1.0, 0.25), 0.1, 1.1)
    assert list(by_kind(run, 1.1)) == ['frame', 'now']


def test_a_robot_that_is_put_elsewhere_does_not_drive_there(run):
    run.see(1, (0.0, 0.0, 0.0), 0.0, 0.0)
    run.changes(0.0)
    run.see(1, (0.04, 0.0, 0.0), 0.0, 0.1)
    assert by_kind(run, 0.1)['frame']['put'] == []
    run.see(1, (0.5, 0.0, 1.0), 0.0, 0.2)

    assert by_kind(run, 0.2)['frame']['put'] == [1]


def test_silent_robots_are_lost_and_later_forgotten(run):
    run.announced = [1, 3, 4]
    for robot in (1, 3):
        run.see(robot, (float(robot), 0.0, 0.0), 0.0, 0.0)
    run.changes(0.0)
    run.see(1, (1.0, 0.0, 0.0), 0.3, LOST_S)
    later = by_kind(run, LOST_S + 0.1)

    assert (3, ('failed', 'lost', 'lost')) in later['states']['items']
    assert later['status']['detail'] == '1 lost; robot 4 is announced, but not seen'
    assert later['frame']['curves'][:2] == [None, None]  # of one robot
    run.changes(FORGOTTEN_S + 0.1)
    assert run.robots == [1]


def test_each_frame_has_the_numbers_of_the_charts(run):
    for robot, x in ((1, 0.0), (2, 2.0)):
        run.see(robot, (x, 0.0, 0.0), 0.2, 0.0)

    assert by_kind(run, 0.0)['frame']['curves'] == [None] * 3  # nothing commands them
    run.command(0.0)
    run.see(1, (0.0, 0.0, 0.0), 0.2, 0.0)
    assert by_kind(run, 0.0)['frame']['curves'] == [1.0, 2.0, 0.2]
    run.task = 'formation'  # robots that need not meet have no disagreement
    run.see(1, (0.0, 0.0, 0.0), 0.2, 0.1)
    assert by_kind(run, 0.1)['frame']['curves'] == [None, 2.0, 0.2]


def test_links_are_sent_as_changes(run):
    run.changes(0.0)
    run.connect(np.array([[9, 1, 0], [0.5, 0, 0], [math.nan, 0, 0]], float))
    assert sorted(by_kind(run, 1.0)['links']['items']) == [('1 2', 1.0), ('2 1', 0.5)]
    run.connect(np.array([[math.nan, math.nan], [0, 0]]))  # of the process of robot 2
    assert by_kind(run, 2.0)['links']['items'] == [('2 1', None)]
    run.connect(np.empty((0, 0)))

    assert by_kind(run, 3.0)['links']['items'] == [('1 2', None)]


def test_a_page_that_is_opened_later_gets_what_it_missed(run):
    for k in range(MOST_FRAMES + 10):
        run.see(2, (0.001 * k, -1.0, 0.25), 0.1, 0.1 * k)
        run.connect(np.array([[0, 0.5], [0.5 * (k < 5), 0]]))
        run.changes(0.1 * k)
    whole = run.whole(0.1 * k)
    found = {message['kind']: message for message in whole}

    assert [message['kind'] for message in whole][:2] == ['status', 'begin']
    assert [look['name'] for _, look in found['looks']['items']] == ['tb3_2']
    assert found['links']['items'] == [('1 2', 0.5)]
    frames = [message for message in whole if message['kind'] == 'frame']
    assert (len(frames), frames[-1]['poses'][0]) == (MOST_FRAMES, pytest.approx(0.001 * k))
    run.begin()
    assert 'frame' not in {message['kind'] for message in run.whole(0.1 * k)}


DISC, LINE = {'kind': 'discs'}, {'kind': 'lines'}


def test_shapes_are_replaced_go_with_their_topic_and_outlive_the_begin_of_a_run(run):
    run.draw('/a', '1', DISC)
    run.draw('/b', '1', DISC)
    assert by_kind(run, 1.0)['shapes']['items'] == [('/a\0001', DISC), ('/b\0001', DISC)]

    run.draw('/a', '1', DISC)
    assert 'shapes' not in by_kind(run, 2.0)
    run.draw('/a', '1', LINE)
    run.erase('/a')
    assert by_kind(run, 3.0)['shapes']['items'] == [('/a\0001', None)]
    run.begin()  # obstacles may be there before the robots
    assert by_kind(run, 4.0)['shapes']['items'] == [('/b\0001', DISC)]


def test_an_ended_run_stays_until_another_one_begins(run):
    run.see(1, (0.0, 0.0, 0.0), 0.0, 0.0)
    run.ended = True
    end = by_kind(run, 100.0)

    assert end['status']['state'] == 'run ended'
    assert end['states']['items'] == [(1, ('', 'at the end', 'at the end'))]
    run.begin()
    assert next(iter(by_kind(run, 101.0))) == 'begin'
    assert run.robots == []


def test_in_an_experiment_the_pause_node_counts_and_its_silence_means_paused():
    states = PauseStates()
    states.requested = True
    states.announce(False, 10.0)

    assert not states.paused(10.4)
    assert states.paused(10.6)


def test_diagnostics_say_why_a_robot_is_stopped():
    states = PauseStates()
    states.diagnoses[1] = RobotDiagnosis('stopped', 'stopped', 'pose 0.4 s old', 10.0)

    assert states.describe(1, 0.3, 10.5) == ('stopped', 'stopped: pose 0.4 s old')
    assert states.describe(1, 0.3, 20.0) == ('', 'moving')
    states.diagnoses[1] = RobotDiagnosis('stopped', 'paused', 'paused', 10.0)
    assert states.describe(1, 0.0, 10.5) == ('stopped', 'paused')


def command(clock, first, last, paused=False):
    for k in range(round(5 * first), round(5 * last) + 1):
        clock.command(k / 5, paused)


def test_the_clock_counts_from_the_first_command_and_holds_after_the_last():
    clock = RunClock()
    assert clock.seconds(3.0) is None
    assert clock.describe(3.0) == 'not controlled yet'
    command(clock, 10.0, 14.0)

    assert clock.seconds(14.1) == pytest.approx(4.1)
    assert clock.describe(14.1) == 'running'
    assert clock.seconds(20.0) == pytest.approx(4.0)
    assert clock.describe(20.0) == 'control has ended'
    command(clock, 30.0, 31.0)  # another run
    assert clock.seconds(31.0) == pytest.approx(1.0)


def test_the_clock_stops_while_an_experiment_is_paused():
    clock = RunClock()
    command(clock, 0.0, 5.0, paused=True)
    assert clock.seconds(5.1) == 0.0
    command(clock, 5.2, 8.2)
    command(clock, 8.4, 20.0, paused=True)

    assert clock.seconds(20.1) == pytest.approx(3.2)
