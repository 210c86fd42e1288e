from dataclasses import replace

import pytest

from setcmas_expe.doctor.findings import NOTE, PROBLEM
from setcmas_expe.doctor.lab_checks import (
    COLUMNS,
    ArrivalStatistics,
    RobotCheck,
    arrival_statistics,
    other_presets,
)
from setcmas_expe.guard.guard_decision import State
from setcmas_expe.guard.guard_watch import GuardReport, Power
from setcmas_expe.lab.lab import LabRobot
from setcmas_expe.lab.lab_file import DEFAULT_FILE, load_lab


def test_regular_messages():
    arrivals = [10.0 + 0.02 * i for i in range(101)]
    statistics = arrival_statistics(arrivals, [t - 0.005 for t in arrivals], 10.0, 12.0)

    assert statistics.rate == pytest.approx(50.0)
    assert statistics.jitter == pytest.approx(0.0, abs=1e-9)
    assert statistics.largest_gap == pytest.approx(0.02)
    assert statistics.age == pytest.approx(0.005)


def test_jitter_and_a_gap():
    statistics = arrival_statistics([0.0, 0.1, 0.4, 0.5], [0.0] * 4, 0.0, 0.5)

    assert statistics.rate == pytest.approx(6.0)
    assert statistics.largest_gap == pytest.approx(0.3)
    assert statistics.jitter == pytest.approx(0.0943, abs=1e-3)


def test_a_silent_source_has_a_gap_up_to_the_end():
    statistics = arrival_statistics([], [], 0.0, 3.0)

    assert (statistics.rate, statistics.age, statistics.largest_gap) == (0.0, None, 3.0)
    assert arrival_statistics([0.0, 0.1], [0.0, 0.0], 0.0, 3.0).largest_gap == pytest.approx(2.9)


@pytest.mark.parametrize('difference', [-60.0, 60.0])
def test_clocks_that_differ_give_no_age(difference):
    arrivals = [1000.0, 1000.1]

    assert arrival_statistics(arrivals, [t - difference for t in arrivals], 999, 1001).age is None


POSE = ['geometry_msgs/msg/PoseStamped']
ODOMETRY = ['nav_msgs/msg/Odometry']


def found(preset, *graph):
    return [finding.found for finding in other_presets(graph, preset)]


def test_bodies_that_another_preset_would_receive_are_named():
    other = found(
        'qualisys',
        ('/vrpn_mocap/Red/pose', POSE),
        ('/vrpn_mocap/Blue/pose', POSE),
        ('/vicon/Red/Blue', POSE),
        ('/tb3_1/odom', ODOMETRY),
        ('/tf', ['tf2_msgs/msg/TFMessage']),
    )

    assert other == ['tf would receive /tf, with all bodies', 'vrpn would receive Blue, Red']
    same = found('vicon', ('/Red/pose', POSE), ('/tb3_1/pose', POSE))
    assert same == ['natnet or nokov or optitrack would receive Red, tb3_1']


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
)
SILENT = ArrivalStatistics(0.0, 0.0, 3.0, None)


def test_a_robot_that_is_well():
    assert GOOD.findings(LAB, ['tb3_1']) == []
    assert len(GOOD.row()) == len(COLUMNS)
    assert '100 Hz' in GOOD.row()


@pytest.mark.parametrize(
    ('changes', 'level', 'text'),
    [
        ({'mocap': SILENT, 'pose': None}, PROBLEM, 'body_7'),
        ({'mocap': replace(GOOD.mocap, largest_gap=0.7)}, PROBLEM, 'silent for 0.7 s'),
        ({'mocap': replace(GOOD.mocap, rate=5.0)}, NOTE, 'only 5.0 Hz'),
        ({'fault': 'exactly zero'}, PROBLEM, 'exactly zero'),
        ({'pose': (3.5, 0.0, 0.0)}, PROBLEM, 'outside the arena'),
        ({'kinds': []}, PROBLEM, 'nothing listens to /tb3_1/cmd_vel'),
        ({'kinds': ['std_msgs/msg/String']}, PROBLEM, 'std_msgs/msg/String'),
        ({'rival': '/joy also commands it'}, PROBLEM, '/joy also commands it'),
        ({'guard': None}, PROBLEM, 'cmd_vel_guard'),
        ({'guard': replace(GUARDED, private=False)}, NOTE, 'cmd_vel_guarded'),
        ({'guard': replace(GUARDED, state=State.EMERGENCY)}, NOTE, 'R twice'),
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


def test_a_type_that_the_lab_file_forbids():
    (finding,) = GOOD.findings(replace(LAB, cmd_vel_type='twist'), [])

    assert finding.level == PROBLEM
    assert 'auto' in finding.advice
