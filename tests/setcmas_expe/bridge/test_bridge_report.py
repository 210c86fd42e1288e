import pytest

from setcmas_expe.bridge.bridge_decision import BridgeState
from setcmas_expe.bridge.bridge_report import BridgeReport

MOVING = BridgeReport(
    name='tb3_1', level=0, reason='', state=BridgeState.MOVING, ready=True, speed=0.004
)


def test_the_values_say_all_that_the_report_does():
    assert MOVING.values['speed'] == '0.004'
    assert MOVING.values['battery'] == ''
    assert BridgeReport.read('tb3_1', 0, '', MOVING.values) == MOVING


@pytest.mark.parametrize(('key', 'value'), [('state', 'flying'), ('pose_age', 'old')])
def test_a_report_that_is_not_understood_is_one_of_a_robot_that_is_stopped(key, value):
    report = BridgeReport.read('tb3_1', 0, '', MOVING.values | {key: value})

    assert report == BridgeReport(name='tb3_1', level=0, reason='')
