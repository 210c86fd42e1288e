from setcmas_simu.ros.messages import NO_STAMP
from setcmas_simu.simulator.lockstep import Answer, Follower, Roll, decode, encode

FIRST, SECOND = Follower('lab', 1, (1, 2)), Follower('lab', 2, (3,))
RECORDER = Follower('lab', 3)


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
        'recorder (process 3 on lab)'
    ]


def test_what_is_no_answer_is_none():
    answer = Answer(FIRST, 1100, 1000)

    assert decode(encode(answer)) == answer
    assert decode('{"stamp": 1}') is None
