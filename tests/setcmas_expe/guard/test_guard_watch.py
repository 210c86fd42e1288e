from dataclasses import replace

import pytest

pytest.importorskip('rclpy')

from diagnostic_msgs.msg import DiagnosticStatus

from setcmas_expe.guard.guard_decision import State
from setcmas_expe.guard.guard_watch import GuardReport, Power, TwiceSeen


def test_a_message_says_all_that_a_report_does():
    report = GuardReport(State.RIVAL, 'rogue also commands it', True, Power.OFF, '01ab')

    message = report.message('tb3_1', '/tb3_1/cmd_vel')
    assert message.level == DiagnosticStatus.WARN
    assert GuardReport.of(message) == report


def test_a_message_that_is_not_understood_is_one_of_a_robot_that_is_held():
    assert GuardReport.of(DiagnosticStatus()).stops


def test_what_a_single_look_finds_is_no_alarm():
    alarm = TwiceSeen()
    looks = ['', 'rogue', '', 'rogue', 'other', 'other', 'other', '', '', 'other', 'other']

    alarms = [alarm.new(found) for found in looks]
    assert [look for look, found in enumerate(alarms) if found] == [5, 10]


def test_motors_that_go_off_without_an_emergency_mean_a_robot_that_does_not_obey():
    on = GuardReport(State.PAUSED, '', True, Power.ON, '')
    off = replace(on, power=Power.OFF)

    assert off.has_cut(on)
    assert not off.has_cut(off)
    assert not off.has_cut(None)  # of an earlier experiment
    assert not on.has_cut(off)
    for state in (State.EMERGENCY, State.RIVAL):
        assert not replace(off, state=state).has_cut(on)
