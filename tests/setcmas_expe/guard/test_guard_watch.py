import pytest

pytest.importorskip('rclpy')

from diagnostic_msgs.msg import DiagnosticStatus

from setcmas_expe.guard.guard_decision import GuardDecision, GuardState
from setcmas_expe.guard.guard_watch import GuardReport


@pytest.mark.parametrize('private', [True, False])
def test_a_message_says_all_that_a_report_does(private):
    decision = GuardDecision(GuardState.INTRUDED, '/rogue commands it past its guard')
    report = GuardReport(decision, private, lidar=not private)

    message = report.message('tb3_1', '/tb3_1/cmd_vel')
    assert message.level == DiagnosticStatus.WARN
    assert GuardReport.read(message) == report


def test_a_message_that_is_not_understood_is_one_of_a_robot_that_is_held():
    assert GuardReport.read(DiagnosticStatus()).state is GuardState.HELD
