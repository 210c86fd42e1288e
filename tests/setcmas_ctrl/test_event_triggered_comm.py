import itertools

import pytest
from processes import CTRL, SIMU

pytest.importorskip('rclpy')

from nav_msgs.msg import Odometry
from rclpy.qos import DurabilityPolicy, QoSProfile
from ros_peer import position
from std_msgs.msg import UInt16

LATCHED = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)


def test_states_are_sent_when_the_condition_triggers(start, peer, script):
    law = script('def control(robotNo, nbRobots, poses, t):\n    return 0.5, 0.0\n')
    start(*SIMU, '--nb-robots', '1').wait_for_output('simulating')
    events = peer.listen(UInt16, '/tb3_1/trig_event')
    states = peer.listen(Odometry, '/tb3_1/trig_odom', LATCHED)
    start(*CTRL, '--algo', law, '--event-triggered', '--threshold', '0.3')

    def sent():  # each is repeated
        return sorted({position(state)[0] for state in states})

    peer.wait_for(lambda: len(sent()) > 4)

    x = sent()
    assert all(0.3 < later - earlier < 0.45 for earlier, later in itertools.pairwise(x))
    peer.wait_for(lambda: {event.data for event in events} == {0, 1})
    late = peer.listen(Odometry, '/tb3_1/trig_odom', LATCHED)
    peer.wait_for(lambda: late)
    assert position(late[0])[0] <= x[-1]  # sent before it subscribed


def test_the_last_state_sent_is_repeated_for_receivers_that_missed_it(start, peer, script):
    law = script('def control(robotNo, nbRobots, poses, t):\n    return 0.0, 0.0\n')
    start(*SIMU, '--nb-robots', '1', '--robot-rate', '50').wait_for_output('simulating')
    odometry = peer.odometry(1)
    states = peer.listen(Odometry, '/tb3_1/trig_odom')
    start(*CTRL, '--algo', law, '--event-triggered')
    peer.wait_for(lambda: len(states) > 10)

    stamps = [state.header.stamp.sec * 10**9 + state.header.stamp.nanosec for state in states]
    assert len(set(stamps)) == 1
    assert len(odometry) > 3 * len(states)  # at 10 Hz, of 50


@pytest.mark.parametrize(
    ('text', 'message'),
    [
        (
            'def ctc(pos, last_pos, t):\n    while True:\n        pass\n',
            'tb3_1: ctc has not returned for 2 s; it is at when.py, line ',
        ),
        (
            'while True:\n    pass\ndef ctc(a, b, c):\n    return True\n',
            'tb3_1: when.py has been loading for',
        ),
    ],
    ids=['call', 'loading'],
)
def test_a_condition_that_hangs_is_located_and_ends_with_the_process(start, script, text, message):
    start(*SIMU, '--nb-robots', '1').wait_for_output('simulating')
    options = ['--event-triggered', '--ctc', script(text, 'when.py')]
    process = start(*CTRL, '--algo', 'consensus', *options)
    process.wait_for_output(message)

    assert process.end() in (0, 1)
    assert 'Traceback' not in process.output()
