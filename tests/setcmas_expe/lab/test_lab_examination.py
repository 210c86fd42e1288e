from dataclasses import replace

import pytest

pytest.importorskip('rclpy')

from setcmas_expe.guard.guard_decision import GuardDecision, GuardState, stopped
from setcmas_expe.lab.findings import NOTE, PROBLEM
from setcmas_expe.lab.lab import LabRobot
from setcmas_expe.lab.lab_examination import COLUMNS, RobotCheck, rate_and_gap
from setcmas_expe.lab.lab_file import DEFAULT_FILE, load_lab

REGULAR = [1000.0 + 0.02 * i for i in range(101)]
JITTERY = [1000.0, 1000.1, 1000.4, 1000.5]


@pytest.mark.parametrize(
    ('arrivals', 'end', 'expected'),
    [
        (REGULAR, 1002.0, (50.0, 0.02)),
        (JITTERY, 1000.5, (6.0, 0.3)),
        ([], 1003.0, (0.0, 3.0)),
        (JITTERY[:2], 1003.0, (10.0, 2.9)),
    ],
)
def test_rate_and_gap_of_messages(arrivals, end, expected):
    assert rate_and_gap(arrivals, 1000.0, end) == pytest.approx(expected, abs=1e-4)


GUARDED = GuardDecision(GuardState.IDLE)
LAB = load_lab(DEFAULT_FILE, 1)
GOOD = RobotCheck(
    robot=LabRobot.numbered(1),
    rate=100.0,
    largest_gap=0.02,
    pose=(1.0, -1.0, 0.5),
    fault=None,
    kinds=['twist_stamped'],
    rival='',
    guard=GUARDED,
    battery=80.0,
)
SILENT = {'rate': 0.0, 'largest_gap': 3.0}


def test_a_robot_that_is_well():
    assert GOOD.findings(LAB, ['tb3_1']) == []
    assert len(GOOD.row()) == len(COLUMNS)
    assert '100 Hz' in GOOD.row()


@pytest.mark.parametrize(
    ('changes', 'level', 'text'),
    [
        ({**SILENT, 'pose': None}, PROBLEM, 'body_7'),
        ({'largest_gap': 0.7}, PROBLEM, 'silent for 0.7 s'),
        ({'rate': 5.0}, NOTE, 'only 5.0 Hz'),
        ({'fault': 'exactly zero'}, PROBLEM, 'exactly zero'),
        ({'pose': (3.5, 0.0, 0.0)}, PROBLEM, 'outside the arena'),
        ({'kinds': []}, PROBLEM, 'nothing listens to /tb3_1/cmd_vel'),
        ({'kinds': ['std_msgs/msg/String']}, PROBLEM, 'std_msgs/msg/String'),
        ({'rival': '/joy also commands it'}, PROBLEM, '/joy also commands it'),
        ({'guard': None}, PROBLEM, 'cmd_vel_guard'),
        ({'guard': stopped(GuardState.EMERGENCY)}, NOTE, 'R twice'),
        ({'battery': 20.0}, NOTE, '20 %'),
        ({'battery': 5.0}, PROBLEM, '5 %'),
    ],
)
def test_problems_are_reported(changes, level, text):
    check = replace(GOOD, **changes)
    (finding,) = check.findings(LAB, ['body_7'])

    assert finding.level == level
    assert text in f'{finding.found} {finding.advice}'
    assert len(check.row()) == len(COLUMNS)


def test_a_guard_that_does_not_watch_the_lidar_that_the_lab_asks_for():
    lab = replace(LAB, lidar_stop=True)
    (finding,) = GOOD.findings(lab, [])

    assert finding.level == PROBLEM
    assert '--lidar' in finding.advice
    assert replace(GOOD, guard=replace(GUARDED, lidar=True)).findings(lab, []) == []
