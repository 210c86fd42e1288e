import math
import sys
from pathlib import Path

import numpy as np
import pytest
from processes import CTRL, SIMU

from setcmas_simu.simulator.lockstep import (
    Answer,
    Commands,
    Follower,
    Roll,
    States,
    decode,
    decode_states,
    encode,
    encode_states,
    this_process,
)

FOREIGN = Path(__file__).parents[2] / 'setcmas_expe' / 'scripts' / 'foreign_controller.py'
FIRST, SECOND = Follower(11, 1, (1, 2)), Follower(12, 2, (3,))
RECORDER = Follower(13, 3)


def roll(recorded=False):
    return Roll([1, 2, 3], recorded, window_ns=200)


def test_time_stands_until_every_robot_has_a_controller_that_has_answered():
    ours = roll()

    assert ours.missing(1000) == 'a controller of robots 1-3'
    ours.take(Answer(FIRST, 1000))
    assert ours.missing(1000) == 'a controller of robot 3'
    ours.take(Answer(SECOND, 1000))
    assert ours.missing(1000) == ''
    assert ours.late(1000) == []
    assert [answer.follower for answer in ours.late(1100)] == [FIRST, SECOND]


def test_later_those_that_are_there_are_waited_for():
    ours = roll()
    for follower in (FIRST, SECOND):
        ours.take(Answer(follower, 1000))
    assert ours.missing(1000) == ''
    ours.take(Answer(FIRST, 1000, leaves=True))

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
        ours.take(Answer(follower, 1000, leaves=True))

    assert [str(answer.follower) for answer in ours.left()] == [
        'controller of robot 3 (process 2)'
    ]
    assert ours.left() == []


def test_an_answer_is_an_array_of_numbers():
    rows = ((0.2, 0.0, 0.1, 1.0, 2.0, 0.5, 0.6, 3.0), (0.3, *[0.0] * 7))
    answer = Answer(FIRST, 1100, commands=(Commands(1000, rows), Commands(1050, rows)))

    once = [*rows[0], *rows[1]]
    assert [*encode(answer)] == [2, 11, 1, 1100, 0, 2, 1, 2, 1000, *once, 1050, *once]
    assert decode(encode(answer)) == answer
    assert decode(encode(Answer(RECORDER, 1100, leaves=True))).leaves


def test_ids_and_stamps_are_exact_after_three_months():
    stamp = 90 * 24 * 3600 * 10**9 + 1
    follower = this_process((1,))

    assert decode(encode(Answer(follower, stamp))) == Answer(follower, stamp)


def test_states_are_an_array_of_numbers():
    states = States(1100, np.arange(16.0).reshape(2, 8))

    assert [*encode_states(states)] == [2, 1100, *range(16)]
    decoded = decode_states(encode_states(states))
    assert decoded.stamp == 1100
    assert np.array_equal(decoded.table, states.table)
    with pytest.raises(ValueError, match=r'they must be 2 \(version\), stamp, and 8 numbers'):
        decode_states(encode_states(states)[:-1])


@pytest.mark.parametrize(
    ('place', 'number', 'message'),
    [
        (1, math.nan, 'its stamp is nan; it must be a time in ns'),
        (1, math.inf, 'its stamp is inf'),
        (1, 1e300, r'its stamp is 1e\+300'),
        (4, math.nan, r'row of its states is \[1.0, 1.0, nan, .*\]; it must be finite'),
        (2, -math.inf, r'\[-inf, 1.0, .*\]; it must be finite'),
    ],
)
def test_states_that_no_robot_can_have_are_refused(place, number, message):
    numbers = encode_states(States(1100, np.ones((1, 8))))
    numbers[place] = number
    with pytest.raises(ValueError, match=message):
        decode_states(numbers)


@pytest.mark.parametrize(
    ('numbers', 'message'),
    [
        ([], r'its numbers are \[\]; they must be 2 \(version\), id'),
        ([2, 11, 1, 1100, 0], r'1100, 0\]; they must be'),
        ([2, 11, math.nan, 1100, 0, 0], r'nan, 1100, 0, 0\]; they must be'),
        ([1, 11, 1, 1100, 1000, 0], r'\[1, 11'),
        ([2, 11, 1, 1100, 0, 1, 0], r'its robots are \[0\]; they must be from 1 to 2000'),
        ([2, 11, 1, 1100, 0, 1, 0.5], r'its robots are \[0.5\]; they must be from 1 to 2000'),
        ([2, 11, 1, 1100, 0, 2, 1], r'it has 1 of 2 robots'),
        ([2, 11, 1, 1100, 0, 1, 1, 1100, 0.2], r'2 numbers of commands'),
        ([2, 11, 1, 1100, 0, 1, 1, math.nan, *[0.0] * 8], r'a stamp of its commands is nan'),
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
