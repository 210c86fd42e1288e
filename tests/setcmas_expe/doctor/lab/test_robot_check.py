from dataclasses import replace

import pytest

from setcmas_expe.doctor.findings import NOTE, PROBLEM
from setcmas_expe.doctor.lab.arrival_statistics import ArrivalStatistics
from setcmas_expe.doctor.lab.robot_check import COLUMNS, RobotCheck
from setcmas_expe.guard.report import GuardReport, Power, State
from setcmas_expe.lab.file import DEFAULT_FILE, load_lab
from setcmas_expe.lab.model import LabRobot

GUARDED = GuardReport(State.IDLE, '', True, Power.UNKNOWN, '')
LAB = load_lab(DEFAULT_FILE, 1)
GOOD = RobotCheck(
    robot=LabRobot.numbered(1),
    mocap=ArrivalStatistics(100.0, 0.001, 0.02, 0.008),
    pose=(1.0, -1.0, 0.5),
    fault=None,
    kinds=['twist_stamped'],
    rival='',
    guard=GUARDED,
    battery=80.0,
    round_trip=0.004,
)
SILENT = ArrivalStatistics(0.0, 0.0, 3.0, None)


def test_a_robot_that_is_well():
    assert GOOD.findings(LAB, ['tb3_1']) == []
    assert len(GOOD.row()) == len(COLUMNS)
    assert '100 Hz' in GOOD.row()


@pytest.mark.parametrize(
    ('changes', 'level', 'told'),
    [
        ({'mocap': SILENT, 'pose': None}, PROBLEM, 'body_7'),
        ({'mocap': replace(GOOD.mocap, largest_gap=0.7)}, PROBLEM, 'silent for 0.7 s'),
        ({'mocap': replace(GOOD.mocap, rate=5.0)}, NOTE, 'only 5.0 Hz'),
        ({'fault': 'exactly zero'}, PROBLEM, 'exactly zero'),
        ({'pose': (3.5, 0.0, 0.0)}, PROBLEM, 'outside the arena'),
        ({'kinds': []}, PROBLEM, 'nothing listens to /tb3_1/cmd_vel'),
        ({'kinds': ['std_msgs/msg/String']}, PROBLEM, 'std_msgs/msg/String'),
        ({'rival': '/joy commands it too'}, PROBLEM, '/joy commands it too'),
        ({'guard': None}, PROBLEM, 'cmd_vel_guard'),
        ({'guard': replace(GUARDED, private=False)}, NOTE, 'cmd_vel_guarded'),
        ({'guard': replace(GUARDED, state=State.EMERGENCY)}, NOTE, 'R twice'),
        ({'battery': 20.0}, NOTE, '20 %'),
        ({'battery': 5.0}, PROBLEM, '5 %'),
        ({'round_trip': 0.3}, NOTE, '300 ms'),
    ],
)
def test_what_is_wrong_is_told(changes, level, told):
    check = replace(GOOD, **changes)
    (finding,) = check.findings(LAB, ['body_7'])

    assert finding.level == level
    assert told in f'{finding.found} {finding.advice}'
    assert len(check.row()) == len(COLUMNS)


def test_a_type_that_the_lab_file_forbids():
    (finding,) = GOOD.findings(replace(LAB, cmd_vel_type='twist'), [])

    assert finding.level == PROBLEM
    assert 'auto' in finding.advice
