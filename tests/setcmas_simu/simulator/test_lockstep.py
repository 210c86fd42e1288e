import sys
from pathlib import Path

import pytest
from processes import CTRL, SIMU

from setcmas_simu.ros.messages import NO_STAMP
from setcmas_simu.simulator.lockstep import Answer, Follower, Roll, decode, encode

FOREIGN = Path(__file__).parents[2] / 'setcmas_expe' / 'scripts' / 'foreign_controller.py'
FIRST, SECOND = Follower(11, 1, (1, 2)), Follower(12, 2, (3,))
RECORDER = Follower(13, 3)


def roll(recorded=False):
    return Roll([1, 2, 3], recorded, window_ns=200)


def test_time_stands_until_every_robot_has_a_controller_that_has_answered():
    ours = roll()

    assert ours.missing(1000) == 'a controller of robots 1-3'
    ours.take(Answer(FIRST, 1000, 1000))
    assert ours.missing(1000) == 'a controller of robot 3'
    ours.take(Answer(SECOND, 1000))
    assert ours.missing(1000) == ''
    assert ours.late(1000) == []
    assert ours.commanded() == {1: 1000, 2: 1000}
    assert [answer.follower for answer in ours.late(1100)] == [FIRST, SECOND]


def test_later_those_that_are_there_are_waited_for():
    ours = roll()
    for follower in (FIRST, SECOND):
        ours.take(Answer(follower, 1000))
    assert ours.missing(1000) == ''
    ours.take(Answer(FIRST, NO_STAMP, leaves=True))

    assert ours.missing(1100) == ''
    assert [answer.follower for answer in ours.late(1100)] == [SECOND]
    ours.drop(ours.late(1100))
    assert ours.missing(1100) == 'a controller'


def test_a_recorder_that_is_to_come_is_waited_for_and_may_be_behind_till_the_end():
    ours = roll(recorded=True)
    for follower in (FIRST, SECOND):
        ours.take(Answer(follower, 1000))

    assert ours.missing(1000) == 'the recorder'
    ours.take(Answer(RECORDER, 1000))
    assert ours.missing(1000) == ''
    for follower in (FIRST, SECOND):
        ours.take(Answer(follower, 1200))
    assert ours.late(1200) == []
    assert [str(answer.follower) for answer in ours.late(1200, exactly=True)] == [
        'recorder (process 3)'
    ]


def test_controllers_that_leave_are_reported_once():
    ours = roll()
    for follower in (FIRST, SECOND, RECORDER):
        ours.take(Answer(follower, 1000))
    for follower in (RECORDER, SECOND, SECOND):
        ours.take(Answer(follower, NO_STAMP, leaves=True))

    assert [str(answer.follower) for answer in ours.left()] == [
        'controller of robot 3 (process 2)'
    ]
    assert ours.left() == []


def test_an_answer_is_an_array_of_numbers():
    answer = Answer(FIRST, 1100, 1000)

    assert [*encode(answer)] == [1, 11, 1, 1100, 1000, 0, 1, 2]
    assert decode(encode(answer)) == answer
    assert decode(encode(Answer(RECORDER, NO_STAMP, leaves=True))).leaves


@pytest.mark.parametrize(
    ('numbers', 'message'),
    [
        ([], r'its numbers are \[\]; they must be 1 \(version\), id'),
        ([1, 11, 1, 1100, 1000], r'1100, 1000\]; they must be'),
        ([2, 11, 1, 1100, 1000, 0], r'\[2, 11'),
        ([1, 11, 1, 1100, 1000, 0, 0], r'its robots are \[0\]; they must be from 1 to 2000'),
    ],
)
def test_other_arrays_are_refused(numbers, message):
    with pytest.raises(ValueError, match=message):
        decode(numbers)


def test_a_controller_without_ros_takes_part_until_it_leaves(start, domain):
    pytest.importorskip('rclpy')
    pytest.importorskip('cyclonedds')
    simulator = start(*SIMU, '--nb-robots', '2', '--lockstep')
    start(*CTRL, '--algo', 'nav_wp', '--nb-robots', '2', '--robots', '1')
    simulator.wait_for_output('simulating')
    start(sys.executable, str(FOREIGN), str(domain)).wait_for_output('exact')

    simulator.wait_for_output('the controller of robot 2 (process ')
    assert 'has left; time advances without it' in simulator.output()
