import pytest

pytest.importorskip('rclpy')

from diagnostic_msgs.msg import DiagnosticStatus

from setcmas_expe.guard.guard_decision import GuardDecision, GuardState
from setcmas_expe.guard.guard_watch import GuardWatch, report_message, reported
from setcmas_simu.ros import qos


@pytest.mark.parametrize('lidar', [True, False])
def test_a_message_says_all_that_a_report_does(lidar):
    reason = '/rogue commands it past its guard'
    report = GuardDecision(GuardState.INTRUDED, reason, lidar)

    message = report_message(report, 'tb3_1', '/tb3_1/cmd_vel')
    assert message.level == DiagnosticStatus.WARN
    assert reported(message) == report


def test_a_message_that_is_not_understood_is_one_of_a_robot_that_is_held():
    assert reported(DiagnosticStatus()).state is GuardState.HELD


def test_deaf_wheels_are_seen_though_they_stand_when_the_next_report_follows(peer):
    watch = GuardWatch(peer.node, 'tb3_1')
    received = peer.listen(DiagnosticStatus, '/tb3_1/guard_state')
    publisher = peer.publisher(DiagnosticStatus, '/tb3_1/guard_state', 2, qos.STATE)
    for state in (GuardState.DEAF, GuardState.PAUSED):
        report = GuardDecision(state)
        publisher.publish(report_message(report, 'tb3_1', '/tb3_1/cmd_vel'))
    peer.wait_for(lambda: len(received) == 2)

    watch.take(0.0)
    assert (watch.report.state, watch.found_deaf) == (GuardState.PAUSED, True)
    watch.take(0.1)
    assert not watch.found_deaf
