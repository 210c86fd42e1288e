import sys

import pytest
from processes import SETCMAS, SIMU

pytest.importorskip('rclpy')

from nav_msgs.msg import Odometry
from rclpy.qos import DurabilityPolicy, QoSProfile
from ros_peer import position
from std_msgs.msg import UInt16

BROADCAST = [sys.executable, '-m', 'setcmas_ctrl.controller.event_triggered_comm']
LATCHED = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)


def at(x):
    message = Odometry()
    message.pose.pose.position.x = float(x)
    message.pose.pose.orientation.w = 1.0
    return message


@pytest.fixture
def tell(peer):
    """A function that returns one that publishes a place and returns whether it was sent on."""
    events = peer.listen(UInt16, '/tb3_2/trig_event')

    def tell(topic):
        publisher = peer.publisher(Odometry, topic)

        def is_heard():
            publisher.publish(at(0))
            peer.spin(0.1)
            return len(events) > 0

        def tell_place(x):
            publisher.publish(at(x))
            return peer.wait_for_new(events)[0].data

        peer.wait_for(is_heard)
        # Answers to all that was published meanwhile have come.
        peer.wait_for(lambda: tell_place(0) == 0)
        return tell_place

    return tell


def test_states_are_sent_when_the_condition_triggers(start, peer, tell):
    start(*BROADCAST, '--robots', '2').wait_for_output('broadcasting for robot 2')
    states = peer.listen(Odometry, '/tb3_2/trig_odom', LATCHED)
    place = tell('/tb3_2/odom')

    assert [place(x) for x in (0.1, 0.2, 0.3, 0.4, 0.5, 0.6)] == [0, 0, 1, 0, 0, 1]
    peer.wait_for(lambda: len(states) == 3)
    assert [position(state)[0] for state in states] == [0.0, 0.3, 0.6]
    late = peer.listen(Odometry, '/tb3_2/trig_odom', LATCHED)
    peer.wait_for(lambda: len(late) > 3)
    assert position(late[-1]) == (0.6, 0.0)


def test_a_condition_and_a_source_of_ones_own(start, peer, tell, script):
    path = script('def ctc(pos, last_pos, t):\n    return pos[0] > 1\n', 'when.py')
    process = start(
        *BROADCAST, '--robots', '1-2', '--ctc', path, '--odometry-topic', '/mocap/{name}/odom'
    )
    process.wait_for_output('broadcasting for robots 1-2')
    place = tell('/mocap/tb3_2/odom')

    assert [place(x) for x in (0.9, 1.1, 1.2, 0)] == [0, 1, 1, 0]
    assert process.end() == 0


@pytest.mark.parametrize('command', [BROADCAST, [*SETCMAS, 'ctrl', '--algo', 'consensus']])
def test_a_script_without_a_condition_is_a_mistake(start, script, command):
    path = script('def control(a, b, c, d):\n    return 0, 0\n', 'when.py')
    process = start(*command, '--ctc', path, *['--event-triggered'][: len(command) > 3])

    assert process.wait() == 2
    told = 'no function ctc; its control is for --algo when.py; it must have ctc(pos, last_pos, t)'
    assert f'when.py has {told}' in process.output()
    assert 'Traceback' not in process.output()


def test_a_condition_that_hangs_on_its_own_is_located_and_ends_with_the_process(
    start, peer, script
):
    path = script('def ctc(pos, last_pos, t):\n    while True:\n        pass\n', 'when.py')
    process = start(*BROADCAST, '--robots', '2', '--ctc', path)
    process.wait_for_output('broadcasting for robot 2')
    publisher = peer.publisher(Odometry, '/tb3_2/odom')

    def is_stuck():
        publisher.publish(at(0))
        peer.spin(0.1)
        return 'tb3_2: ctc has not returned for' in process.output()

    peer.wait_for(is_stuck)
    assert 'it is at when.py, line ' in process.output()
    assert process.end() == 0
    assert 'Traceback' not in process.output()


def test_a_condition_that_hangs_while_it_is_loaded(start, script):
    path = script('while True:\n    pass\ndef ctc(a, b, c):\n    return True\n', 'when.py')
    start(*SIMU)
    process = start(*BROADCAST, '--ctc', path)

    process.wait_for_output('tb3_1: when.py has been loading for')
    assert process.end() == 0


def test_a_condition_with_a_thread_of_its_own_ends_too(start, script):
    path = script(
        """
        import threading, time
        threading.Thread(target=time.sleep, args=(600,)).start()
        def ctc(pos, last_pos, t):
            return True
        """
    )
    process = start(*BROADCAST, '--ctc', path)
    process.wait_for_output('broadcasting')

    assert process.end() == 0
