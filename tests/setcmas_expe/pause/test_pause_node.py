import os
import signal
import sys
from functools import partial

import pytest

pytest.importorskip('rclpy')

from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from ros_peer import Peer
from sensor_msgs.msg import Joy
from std_msgs.msg import Bool
from std_srvs.srv import Trigger
from terminals import pressed_until

from launch_scripts.supervisor import Supervisor
from setcmas_ctrl.pause_reason import PauseCause, PauseReason
from setcmas_expe.bridge.bridge_decision import BridgeState, Cause, Decision, StopReason
from setcmas_expe.bridge.bridge_report import BridgeReport
from setcmas_expe.bridge.machine_load import OVERLOADED, time_since_boot
from setcmas_expe.pause.console import OLD_AFTER_S, Action, OperatorRequest, Status
from setcmas_expe.pause.press_judge import REACTION_S
from setcmas_simu.reports import LineDecoder
from setcmas_simu.ros import qos

PAUSE = [sys.executable, '-m', 'setcmas_expe.pause.pause_node']
UNDER_LOAD = [
    sys.executable, '-c',
    'import os, sys; os.getloadavg = lambda: (999.0, 999.0, 999.0);'
    'from setcmas_expe.pause.pause_node import main; sys.exit(main())',
]  # fmt: skip


class Bridge:
    """Says what a bridge process says, until it is silenced."""

    def __init__(self, peer):
        self.unready = ''  # what it lacks to start
        self.held = ''  # why it pauses the robots itself
        self.silent = False
        self._paused = True
        self._publisher = peer.node.create_publisher(DiagnosticStatus, '/tb3_1/bridge_state', 1)
        peer.node.create_subscription(Bool, '/paused', self._on_paused, 1)
        peer.node.create_timer(0.1, self.publish)

    def _on_paused(self, message):
        self._paused = message.data

    def publish(self):
        pause, why = None, StopReason(Cause.UNSEEN) if self.unready else None
        if self.held:
            pause = PauseReason(PauseCause.LATCHED, self.held)
        elif self._paused:
            pause = PauseReason(PauseCause.OPERATOR, 'paused')
        decision = Decision(
            0.1, 0.0, BridgeState.PAUSED if pause else BridgeState.MOVING, why, pause
        )
        pairs = BridgeReport.of(decision, name='tb3_1', level=0, speed=0.1).values.items()
        values = [KeyValue(key=key, value=value) for key, value in pairs]
        if not self.silent:
            message = DiagnosticStatus(name='tb3_1', message=decision.text, values=values)
            self._publisher.publish(message)


@pytest.fixture
def bridge(peer):
    return Bridge(peer)


@pytest.fixture
def paused(peer):
    """Return the list that the messages on /paused are appended to."""
    return peer.listen(Bool, '/paused')


def is_paused(paused):
    return bool(paused) and all(message.data for message in paused[-3:])


def stays_paused(peer, paused):
    """Check that robots are, and stay, paused."""
    peer.wait_for_new(paused, 5)
    assert is_paused(paused)


def goes(paused):
    return bool(paused) and not any(message.data for message in paused[-3:])


class Operator:
    """A terminal, as setcmas expe is for the pause node."""

    def __init__(self, peer, child):
        self._peer, self._child = peer, child
        self._decoder = LineDecoder(Status)
        self.alive = True
        self.status = None
        peer.node.create_timer(0.1, self._on_timer)

    def request(self, word, **made):
        self._child.send(OperatorRequest(Action(word), 'by key', **made))

    def _on_timer(self):
        if self.alive:
            self.request('alive')
        while data := self._child.reports.read(65536):
            self.status = [self.status, *self._decoder.feed(data)][-1]

    def warnings(self):
        """Return what the node has said since the last call."""
        return (self._child.process.stderr.read() or b'').decode()

    def press_until(self, press, condition):
        """Press until a condition holds; `press` is a word of the terminal, or a function."""
        press = press if callable(press) else partial(self.request, press)
        self._peer.wait_for(pressed_until(press, condition))

    def wait_for(self, text):
        self._peer.wait_for(lambda: self.status and text in self.status.why)


@pytest.fixture
def operate(domain, peer):
    """Return a function that starts the pause node as setcmas expe does."""
    with Supervisor(dict(os.environ)) as supervisor:

        def begin(*options, command=PAUSE):
            child = supervisor.start('pause', [*command, '--console', *options], listens=True)
            return Operator(peer, child)

        yield begin


def test_every_node_may_pause_and_only_the_operator_start(operate, peer, bridge, paused):
    bridge.unready = 'not seen yet'  # before the node can have heard anything else
    operator = operate()
    wishes = [peer.publisher(Bool, topic) for topic in ('/pause', '/tb3_1/pause')]
    operator.wait_for('')
    for wish in wishes:
        wish.publish(Bool(data=False))
    operator.request('start')
    stays_paused(peer, paused)

    bridge.unready = ''
    for wish in wishes:
        operator.press_until('start', lambda: goes(paused))
        wish.publish(Bool(data=True))
        operator.wait_for(f'by {wish.topic_name}')
        wish.publish(Bool(data=False))
        stays_paused(peer, paused)
    operator.press_until('start', lambda: goes(paused))
    operator.request('pause')
    operator.wait_for('by key')
    operator.request('pause')
    stays_paused(peer, paused)


def test_a_start_that_crosses_a_pause_by_another_program_does_not_count(operate, peer, bridge):
    operator = operate()
    wish = peer.publisher(Bool, '/pause')
    paused, said = peer.listen(Bool, '/paused'), []
    operator.press_until('start', lambda: goes(paused))

    def cross():
        wish.publish(Bool(data=True))
        operator.request('start')

    def is_too_soon():
        said.append(operator.warnings())
        return 'not started: too soon' in ''.join(said)

    peer.spin(1.5 * REACTION_S)  # else it is the second press that is too soon
    operator.press_until(cross, is_too_soon)  # again where the start came first


def test_an_emergency_stop_stays_until_it_is_released_and_pauses_then(
    operate, peer, bridge, paused
):
    stopped = peer.listen(Bool, '/emergency_stopped', qos.LATCHED)
    operator = operate()
    joystick = peer.publisher(Joy, '/joy', qos=qos.SENSOR)
    for profile in qos.FROM_ANYBODY:
        stop = peer.publisher(Bool, '/emergency_stop', qos=profile)
        operator.press_until('start', lambda: goes(paused))

        def is_heard(stop=stop):  # again: best effort may lose a message
            stop.publish(Bool(data=True))
            return 'stop by /emergency_stop' in operator.status.why

        peer.wait_for(is_heard)
        peer.wait_for(lambda: is_paused(paused) and is_paused(stopped))
        for word in ('start', 'go', 'release', 'pause'):
            operator.request(word)
        stop.publish(Bool(data=False))
        peer.wait_for_new(stopped, 5)
        assert operator.status.emergency
        assert is_paused(paused)
        operator.press_until('release', lambda: goes(stopped))
        operator.wait_for('the stop is released')
        assert is_paused(paused)
        peer.node.destroy_publisher(stop)

    for button in (0, 1):  # of a person on the network: it may stop, but not start
        joystick.publish(Joy(buttons=[0] * 7 + [button]))
        peer.spin(0.1)
    stays_paused(peer, paused)

    def stops():  # again: best effort may lose a message
        for button in (0, 1):
            joystick.publish(Joy(buttons=[button] + [0] * 7))
            peer.spin(0.1)
        return 'stop by joystick' in operator.status.why

    peer.wait_for(stops)
    assert peer.call(Trigger, '/pause/emergency_stop').success


def test_a_new_pause_node_takes_over_what_a_guard_holds(start, peer, bridge):
    guard = peer.node.create_publisher(DiagnosticStatus, '/tb3_1/guard_state', 1)
    state = DiagnosticStatus(values=[KeyValue(key='state', value='stop')])
    peer.node.create_timer(0.2, lambda: guard.publish(state))
    stopped = peer.listen(Bool, '/emergency_stopped', qos.LATCHED)
    process = start(*PAUSE)

    peer.wait_for(lambda: is_paused(stopped))
    assert 'STOP held by the guard of robot 1' in process.output()


def test_robots_move_only_while_a_button_is_held(operate, peer, bridge, paused):
    operator = operate('--hold', '--joystick')
    joystick = peer.publisher(Joy, '/joy', qos=qos.SENSOR)
    buttons = [0] * 8
    peer.node.create_timer(0.05, lambda: joystick.publish(Joy(buttons=buttons)))
    operator.request('start')  # once is not held
    stays_paused(peer, paused)

    def hold():
        for buttons[7] in (0, 1):
            peer.spin(0.2)

    operator.press_until(hold, lambda: goes(paused))
    buttons[7] = 0
    operator.wait_for('key or button released')
    operator.press_until(hold, lambda: goes(paused))
    bridge.held = 'robot 1: no command for 0.5 s'
    peer.wait_for(lambda: is_paused(paused))
    bridge.held = ''
    stays_paused(peer, paused)


def test_the_joystick_starts_robots_and_is_missed(operate, peer, bridge, paused):
    operator = operate('--joystick')
    joystick = peer.publisher(Joy, '/joy', qos=qos.SENSOR)
    buttons = [0] * 7 + [1]  # down at first: only the second time counts
    timer = peer.node.create_timer(0.05, lambda: joystick.publish(Joy(buttons=buttons)))
    operator.wait_for('')
    stays_paused(peer, paused)

    def press():
        for buttons[7] in (0, 1):
            peer.spin(0.2)

    operator.press_until(press, lambda: goes(paused))
    press()  # the start button only starts
    peer.wait_for_new(paused, 3)
    assert goes(paused)
    timer.cancel()
    operator.wait_for('the joystick has disappeared')
    joystick.publish(Joy(buttons=buttons))
    stays_paused(peer, paused)

    other, said = peer.publisher(Joy, '/joy', qos=qos.SENSOR), []

    def contradict():
        joystick.publish(Joy(buttons=[0] * 8))
        other.publish(Joy(buttons=[0] * 7 + [1]))
        peer.spin(0.05)
        said.append(operator.warnings())
        return 'not started: several nodes publish /joy' in ''.join(said)

    peer.wait_for(contradict)
    stays_paused(peer, paused)


def test_robots_that_the_bridge_holds_stay_paused_and_a_silent_bridge_is_replaced(
    operate, peer, bridge, paused
):
    commands = peer.cmd_vel(1)
    operator = operate(command=UNDER_LOAD)
    operator.press_until('start', lambda: goes(paused))
    held = 'robot 1: pose rejected: it was lifted'
    bridge.held = held
    # Again, if a busy machine has held the node up: that is a pause, too.
    operator.press_until('start', lambda: operator.status and held in operator.status.why)
    peer.wait_for(lambda: is_paused(paused))
    assert OVERLOADED not in operator.warnings().rpartition(held)[2]

    bridge.held = ''
    operator.press_until('start', lambda: goes(paused))
    assert commands == []
    bridge.silent = True
    operator.wait_for('the bridge process is silent; the pause node commands zero')
    peer.wait_for(lambda: is_paused(paused) and len(commands) > 3)
    assert all(c.twist.linear.x == c.twist.angular.z == 0.0 for c in commands)
    assert OVERLOADED in operator.warnings()


def test_a_press_that_waited_while_the_pause_node_hung_starts_nothing(start, peer, bridge, paused):
    process = start(*PAUSE, '--joystick')
    joystick = peer.publisher(Joy, '/joy', qos=qos.SENSOR)
    peer.wait_for_new(paused, 1)
    joystick.publish(Joy(buttons=[0] * 8))
    peer.spin(0.3)
    process.popen.send_signal(signal.SIGSTOP)
    peer.spin(1.0)
    for button in (0, 1):  # best effort: it may be lost, but it must not start anything
        joystick.publish(Joy(buttons=[0] * 7 + [button]))
        peer.spin(0.1)
    process.popen.send_signal(signal.SIGCONT)
    peer.wait_for_new(paused, 10)

    assert all(message.data for message in paused)


def test_who_plays_the_bridge_pauses_all_robots(operate, peer, bridge, paused, domain):
    operator = operate()
    operator.press_until('start', lambda: goes(paused))
    with Peer(domain) as other:  # a process of its own, as DDS sees it
        other.publisher(DiagnosticStatus, '/tb3_1/bridge_state', qos=1)
        operator.wait_for('2 nodes send /tb3_1/bridge_state')
        peer.wait_for(lambda: is_paused(paused))


def test_a_terminal_that_hangs_is_missed_and_what_it_sends_late_starts_nothing(
    operate, peer, bridge, paused
):
    commands = peer.cmd_vel(1)
    operator = operate()
    operator.press_until('start', lambda: goes(paused))
    peer.wait_for(lambda: operator.status)
    assert (operator.status.robots[0].name, operator.status.robots[0].speed) == ('tb3_1', 0.1)
    operator.alive = False
    peer.wait_for(lambda: is_paused(paused))
    peer.spin(REACTION_S)
    operator.request('start')  # pressed some time ago
    operator.alive = True
    late = 'not started: the key press arrived too late'
    peer.wait_for(lambda: late in operator.warnings())
    stays_paused(peer, paused)

    def refused():
        peer.spin(2 * REACTION_S)  # it says the same again after 1.5 s only
        operator.request('start', pressed_at=time_since_boot() - 2 * OLD_AFTER_S)
        peer.spin(REACTION_S)
        return late in operator.warnings()

    peer.wait_for(refused)
    assert is_paused(paused)

    peer.spin(REACTION_S)

    operator.press_until('go', lambda: goes(paused))
    operator.request('halt')
    peer.wait_for(lambda: is_paused(paused) and len(commands) > 3)
    operator.request('go')
    peer.wait_for(lambda: 'not started: the experiment ends' in operator.warnings())
    child = operator._child
    operator.alive = False
    child.process.stdin.close()
    peer.wait_for(lambda: not child.running())
    assert child.process.returncode == 0
