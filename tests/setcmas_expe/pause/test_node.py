import os
import signal
import sys

import pytest

pytest.importorskip('rclpy')

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from sensor_msgs.msg import Joy
from std_msgs.msg import Bool
from std_srvs.srv import SetBool

from launch_scripts.processes.supervision.supervisor import Supervisor
from setcmas_expe.pause.console_protocol import Status, Wish, Word
from setcmas_expe.pause.start_requests import REPEATS_WITHIN_S
from setcmas_simu.reports.encoding import LineDecoder
from setcmas_simu.ros import qos

PAUSE = [sys.executable, '-m', 'setcmas_expe.pause.node']


class Bridge:
    """Says what a bridge process says, until it is silenced."""

    def __init__(self, peer):
        self.held = 'paused'  # what it says while robots are paused
        self.obeys = True
        self.silent = False
        self.topic = '/tb3_1/cmd_vel'
        self._paused = True
        self._publisher = peer.node.create_publisher(DiagnosticArray, '/diagnostics', 1)
        peer.node.create_subscription(Bool, '/paused', self._on_paused, 1)
        peer.node.create_timer(0.1, self.publish)

    def _on_paused(self, message):
        self._paused = message.data

    def publish(self):
        if self.silent:
            return
        paused = self._paused or not self.obeys
        state = 'paused' if paused else 'moving'
        values = [KeyValue(key='state', value=state), KeyValue(key='speed', value='0.1')]
        status = DiagnosticStatus(
            name='tb3_1',
            message=self.held if paused else '',
            hardware_id=self.topic,
            values=values,
        )
        self._publisher.publish(DiagnosticArray(status=[status]))


@pytest.fixture
def bridge(peer):
    return Bridge(peer)


def is_paused(paused):
    return bool(paused) and all(message.data for message in paused[-3:])


def goes(paused):
    return bool(paused) and not any(message.data for message in paused[-3:])


def test_a_service_pauses_always_and_starts_as_the_topic_does(start, peer, bridge):
    paused = peer.listen(Bool, '/paused')
    start(*PAUSE)
    refused = peer.call(SetBool, '/pause/pause', data=False)
    assert not refused.success
    assert refused.message.startswith('not started: false is repeated')
    peer.spin(REPEATS_WITHIN_S)
    assert is_paused(paused)

    assert peer.call(SetBool, '/pause/pause', data=False).success
    peer.wait_for(lambda: goes(paused))
    assert peer.call(SetBool, '/pause/pause', data=True).success
    peer.wait_for(lambda: is_paused(paused))


def test_the_ways_to_start_and_to_pause(start, peer, bridge):
    paused = peer.listen(Bool, '/paused')
    commands = peer.cmd_vel(1)
    process = start(*PAUSE)
    wish = peer.publisher(Bool, '/pause')
    joystick = peer.publisher(Joy, '/joy', qos=qos.SENSOR)
    peer.wait_for_new(paused, 5)
    assert is_paused(paused)

    bridge.held = 'paused; not seen yet'
    peer.spin(REPEATS_WITHIN_S)
    wish.publish(Bool(data=False))
    peer.wait_for(lambda: 'not started: tb3_1 is paused; not seen yet' in process.output())
    assert is_paused(paused)

    bridge.held = 'paused'
    peer.spin(REPEATS_WITHIN_S)
    wish.publish(Bool(data=False))
    peer.wait_for(lambda: goes(paused))
    wish.publish(Bool(data=True))
    peer.wait_for(lambda: is_paused(paused))

    def press(*buttons):
        for button in buttons:
            joystick.publish(Joy(buttons=[0] * 7 + [button]))
            peer.spin(0.1)

    press(1, 0, 1)  # down at first: only the second time counts
    peer.wait_for(lambda: goes(paused))
    peer.wait_for(lambda: is_paused(paused))  # the joystick has gone silent
    assert 'paused: the joystick has disappeared' in process.output()
    press(1)
    peer.spin(0.5)
    assert is_paused(paused)
    joystick.publish(Joy(buttons=[0]))
    peer.wait_for(lambda: 'the joystick has 1 buttons' in process.output())
    peer.spin(1.0)  # it disappears once more

    wish.publish(Bool(data=False))
    peer.wait_for(lambda: goes(paused))
    assert commands == []
    bridge.silent = True
    peer.wait_for(lambda: is_paused(paused) and len(commands) > 3)
    assert 'the bridge process is silent; the pause node commands zero' in process.output()
    assert all(c.twist.linear.x == c.twist.angular.z == 0.0 for c in commands)
    assert process.end() == 0


def test_a_go_that_somebody_keeps_sending_starts_nothing(start, peer, bridge):
    """As `ros2 topic pub /pause std_msgs/Bool '{data: false}'` does, without --once."""
    paused = peer.listen(Bool, '/paused')
    wish = peer.publisher(Bool, '/pause', listeners=0)
    peer.node.create_timer(1.0, lambda: wish.publish(Bool(data=False)))
    process = start(*PAUSE)
    peer.wait_for(lambda: 'not started: false is repeated on /pause' in process.output())
    peer.spin(2.5)

    assert paused
    assert all(message.data for message in paused)


def test_a_wish_that_waited_while_the_pause_node_hung_starts_nothing(start, peer, bridge):
    paused = peer.listen(Bool, '/paused')
    process = start(*PAUSE)
    wish = peer.publisher(Bool, '/pause')
    joystick = peer.publisher(Joy, '/joy', qos=qos.SENSOR)
    peer.wait_for_new(paused, 1)
    peer.spin(REPEATS_WITHIN_S)
    process.popen.send_signal(signal.SIGSTOP)
    peer.spin(1.0)
    wish.publish(Bool(data=False))
    for button in (0, 1):  # best effort: it may be lost, but it must not start anything
        joystick.publish(Joy(buttons=[0] * 7 + [button]))
        peer.spin(0.1)
    process.popen.send_signal(signal.SIGCONT)
    peer.wait_for(lambda: 'not started: the pause node was held up' in process.output())
    peer.spin(0.5)

    assert all(message.data for message in paused)


def test_robots_that_the_bridge_holds_do_not_go_on_by_themselves(start, peer, bridge):
    paused = peer.listen(Bool, '/paused')
    process = start(*PAUSE)
    wish = peer.publisher(Bool, '/pause')
    peer.wait_for_new(paused, 1)
    peer.spin(REPEATS_WITHIN_S)
    wish.publish(Bool(data=False))
    peer.wait_for(lambda: goes(paused))
    bridge.held = 'paused: nothing is heard of the pause node'
    bridge.obeys = False
    peer.wait_for(lambda: is_paused(paused))

    assert 'paused: nothing is heard of the pause node' in process.output()


def test_diagnostics_of_others_are_not_those_of_the_bridge(start, peer, bridge):
    bridge.topic = ''
    process = start(*PAUSE)
    wish = peer.publisher(Bool, '/pause')
    peer.spin(REPEATS_WITHIN_S)
    wish.publish(Bool(data=False))

    peer.wait_for(lambda: 'nothing is heard of the bridge process' in process.output())


def test_two_joysticks_that_contradict_each_other_can_only_pause(start, peer, bridge):
    paused = peer.listen(Bool, '/paused')
    process = start(*PAUSE)
    joysticks = [peer.publisher(Joy, '/joy', qos=qos.SENSOR) for _ in range(2)]
    peer.wait_for_new(paused, 1)
    peer.spin(0.5)
    for _ in range(5):
        for button, joystick in enumerate(joysticks):
            joystick.publish(Joy(buttons=[0] * 7 + [button]))
            peer.spin(0.05)
    peer.wait_for(lambda: 'not started: several nodes publish /joy' in process.output())

    assert all(message.data for message in paused)


@pytest.fixture
def terminal(domain):
    """Start the pause node as setcmas expe does."""
    with Supervisor(dict(os.environ)) as supervisor:
        yield supervisor.start('pause', [*PAUSE, '--console'], listens=True)


def test_the_terminal_starts_pauses_and_is_missed(terminal, peer, bridge):
    paused = peer.listen(Bool, '/paused')
    commands = peer.cmd_vel(1)

    def tell(word):
        terminal.tell(Wish(Word(word)))

    peer.wait_for_new(paused, 1)
    peer.spin(0.5)
    (status, *_) = LineDecoder(Status).feed(terminal.reports.read(65536))
    assert status.paused
    assert (status.robots[0].name, status.robots[0].speed) == ('tb3_1', '0.1')
    tell('alive')
    peer.spin(0.3)
    tell('toggle')
    peer.wait_for(lambda: goes(paused))
    peer.wait_for(lambda: is_paused(paused))  # nobody says that the terminal is alive
    wish = peer.publisher(Bool, '/pause')
    peer.spin(REPEATS_WITHIN_S)
    wish.publish(Bool(data=False))  # nor does it start robots that the terminal could not stop
    peer.spin(0.5)
    assert is_paused(paused)
    tell('toggle')  # by somebody who wanted to pause, and was late
    peer.spin(0.5)
    assert is_paused(paused)
    for _ in range(40):  # a key that is held down, read now one by one and now in pairs
        tell('pause')
        tell('alive')
        peer.spin(0.05)
    tell('toggle')
    peer.spin(0.3)
    assert is_paused(paused)
    tell('go')
    peer.wait_for(lambda: goes(paused))
    tell('halt')
    peer.wait_for(lambda: is_paused(paused) and len(commands) > 3)
    terminal.process.stdin.close()
    peer.wait_for(lambda: not terminal.running())
    assert terminal.process.returncode == 0
