import itertools
import math

import pytest
from driven_robot import DrivenRobot, back_and_forth, to_points, turns

SOON_S, NEAR_M = 0.7, 0.16  # with the robot's own delay and lag


def straight(_):
    return 0.21, 0.0


def circle(_):
    return 0.2, 0.5


def fallen(robot):
    place, heading = robot.place, robot.heading
    robot.spoil = lambda *_: (place, heading)


def drifting(speed):
    def spoil(robot):
        since = robot.now
        robot.spoil = lambda place, heading: (place + 1j * speed * (robot.now - since), heading)

    return spoil


def turned(degrees):
    def spoil(robot):
        robot.spoil = lambda place, heading: (place, heading + math.radians(degrees))

    return spoil


def mirrored(robot):
    robot.spoil = lambda place, heading: (place.conjugate(), -heading)


def held(robot):
    robot.blocked = 'slip'


def stalled(robot):
    robot.blocked = 'stand'


ACROSS, BACKWARDS = turned(90), turned(180)
FROM_THE_START = (ACROSS, BACKWARDS, mirrored)
FAULTS = [
    (straight, fallen, 'have its markers fallen off'),
    (circle, fallen, 'does not move as commanded'),
    (straight, held, 'lifted, blocked'),
    (straight, stalled, 'blocked or switched off'),
    (circle, drifting(0.3), 'does motion capture drift'),
    (straight, drifting(2.0), 'does motion capture drift'),
    (straight, ACROSS, 'deg off its heading: is its body turned'),
    (circle, BACKWARDS, 'is its body turned'),
    (straight, BACKWARDS, 'is its body turned'),
    (circle, mirrored, 'are its axes mirrored'),
]


@pytest.mark.parametrize(('law', 'fault', 'line'), FAULTS)
def test_poses_that_are_plausible_and_wrong_are_found_within_the_bounds(law, fault, line):
    robot = DrivenRobot(seed=3)
    if fault in FROM_THE_START:
        fault(robot)
    else:
        assert robot.run(3.0, law) is None
        fault(robot)
    begin, before = robot.now, robot.path
    assert robot.run(2.0, law)
    text = robot.found.text(proved='drift' in line or 'mirrored' in line)
    seconds = robot.now - begin

    robot.found, robot.check = None, DrivenRobot().check
    robot.run(0.6, lambda _: (0.0, 0.0))
    assert line in text
    assert seconds <= SOON_S
    assert robot.path - before < NEAR_M


def test_a_robot_that_stands_and_glides_away_is_found():
    robot = DrivenRobot()
    robot.run(1.0)
    drifting(0.3)(robot)

    assert robot.run(0.5)
    assert 'commanded 0.00' in robot.found.text(proved=True)


@pytest.mark.parametrize('law', [lambda _: (0.05, 0.0), lambda _: (0.0, 0.3)])
def test_a_robot_twice_as_fast_as_commanded_may_be_another_model(law):
    robot = DrivenRobot()
    robot.gain, robot.crawls = (2.0, 2.0), True
    assert robot.run(3.0, law)

    line = 'is it another model, are its wheels of another size, '
    assert line in robot.found.text(proved=False)


LAWS = {'points': to_points, 'signs': lambda: back_and_forth, 'turns': lambda: turns}


def alarms(law, rate, seconds, seeds):
    return [
        (law, rate, seed, robot.found.text(proved=False))
        for seed in seeds
        for robot in [DrivenRobot(seed, rate)]
        if robot.run(seconds, LAWS[law]())
    ]


@pytest.mark.parametrize('law', LAWS)
def test_robots_that_move_as_commanded_are_believed(law):
    assert alarms(law, 50.0, 10.0, (1, 2)) == []


@pytest.mark.nightly
def test_half_an_hour_and_more_goes_by_without_a_false_alarm():
    cases = itertools.product(LAWS, (100.0, 50.0, 20.0, 10.0))

    assert [found for case in cases for found in alarms(*case, 60.0, range(10, 13))] == []


@pytest.mark.parametrize('proved', [False, True])
def test_a_crawling_robot_whose_body_is_turned_by_180_degrees_is_reported_as_that(proved):
    robot = DrivenRobot()
    robot.crawls = True
    turned(180)(robot)
    assert robot.run(2.0, lambda _: (0.05, 0.0))

    assert 'is its body turned' in robot.found.text(proved)


def test_a_robot_under_a_y_up_system_that_is_said_to_be_z_up_cannot_prove_its_turning():
    robot = DrivenRobot()
    robot.spoil = lambda place, _: (place, 0.0)  # until it has turned by 90 degrees
    assert robot.run(3.0, lambda _: (0.0, 0.3))

    assert 'is y_up wrong in the lab file' in robot.found.text(proved=False)
