import pytest

pytest.importorskip('rclpy')

import itertools
import math
import signal
import sys
import time
from types import SimpleNamespace

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import Twist, TwistStamped
from nav_msgs.msg import Odometry
from rclpy.node import Node
from ros_peer import Peer
from std_msgs.msg import Bool
from std_srvs.srv import SetBool

from setcmas_ctrl.pause_reason import PauseCause, PauseReason
from setcmas_expe.guard.guard_decision import GuardDecision, GuardState
from setcmas_expe.guard.guard_node import CmdVelGuard
from setcmas_expe.guard.guard_watch import reported
from setcmas_simu.ros import cmd_vel_topics, messages, qos
from setcmas_simu.ros.cmd_vel_topics import NAMELESS, velocities

GUARD = [sys.executable, '-m', 'setcmas_expe.guard.guard_node']
NAMESPACE = ['--ros-args', '-r', '__ns:=/tb3_1']
COMMAND, STOP = (0.1, 0.5), (0.0, 0.0)


class Robot:
    """Base, bridge and pause node of a guarded robot; sends 20 times a second what is set here."""

    def __init__(self, peer, operator, kind=TwistStamped, odometry_from=None):
        self.peer = peer
        self.wanted = self.paused = self.stopped = None
        self.queued_since = math.inf  # when the network begins to hold its commands up
        self.motors = []
        self.wheels = Odometry()
        self.received = peer.listen(kind, '/tb3_1/cmd_vel_guarded')
        self.reports = peer.listen(DiagnosticStatus, '/tb3_1/guard_state')
        node = peer.node
        sender = odometry_from or peer
        self._odometry = sender.node.create_publisher(Odometry, '/tb3_1/odom', 1)
        node.create_service(SetBool, '/tb3_1/motor_power', self._switch)
        create = operator.node.create_publisher
        self._bool = {
            'paused': create(Bool, '/paused', qos.STATE),
            'emergency_stopped': create(Bool, '/emergency_stopped', qos.LATCHED),
        }
        self._bridge = node.create_publisher(TwistStamped, '/tb3_1/cmd_vel', qos.ROBOT_COMMAND)
        node.create_timer(0.05, self._publish)

    def _publish(self):
        self._odometry.publish(self.wheels)
        if self.paused is not None:
            self._bool['paused'].publish(Bool(data=self.paused))
        if self.stopped is not None:
            self._bool['emergency_stopped'].publish(Bool(data=self.stopped))
        if self.wanted:
            self._bridge.publish(self.message(self.wanted))

    def delay(self):
        """Return the delay of a command in s; it grows more slowly than time, so stamps go on."""
        return min(max(0.0, 0.8 * (time.time() - self.queued_since)), 1.0)

    def message(self, wanted):
        message = TwistStamped()
        stamp = divmod(time.time_ns() - round(1e9 * self.delay()), 10**9)
        message.header.stamp = Time(sec=stamp[0], nanosec=stamp[1])
        message.twist.linear.x, message.twist.angular.z = wanted
        return message

    def _switch(self, request, response):
        self.motors.append(request.data)
        response.success = True
        return response

    @property
    def report(self):
        return reported(self.reports[-1]) if self.reports else None

    def wait_for(self, state, command=None):
        self.peer.wait_for(lambda: self.report and self.report.state is state)
        if command:
            self.peer.wait_for(lambda: self.received and velocities(self.received[-1]) == command)

    def start(self, command=None):
        """Pause and let go until the robot follows."""
        self.wanted = self.wanted or COMMAND
        self.paused = True
        self.let_go_until(GuardState.FOLLOWING, command)

    def let_go_until(self, state, command=None):
        """Let go until this is its state: what a busy machine holds up stops it, too."""
        self.peer.wait_for(lambda: self._has(state, command))

    def _has(self, wanted, command):
        state = self.report and self.report.state
        if state is wanted and not self.paused:
            return command is None or (self.received and velocities(self.received[-1]) == command)
        if state is not GuardState.FOLLOWING:
            self.paused = state is not GuardState.PAUSED
        return False


@pytest.fixture
def other(domain):
    """Take part as a process of its own, as DDS sees it."""
    with Peer(domain) as other:
        yield other


@pytest.fixture
def operator(domain):
    """Take part as the process of the pause node."""
    with Peer(domain) as operator:
        yield operator


@pytest.fixture
def robot(start, peer, operator):
    """Return a robot with its guard."""
    robot = Robot(peer, operator)
    start(*GUARD, *NAMESPACE)
    return robot


@pytest.mark.parametrize('kind', [TwistStamped, pytest.param(Twist, marks=pytest.mark.nightly)])
def test_a_base_gets_what_the_bridge_commands_after_a_start_and_zero_otherwise(
    start, peer, operator, kind
):
    robot = Robot(peer, operator, kind=kind)
    robot.wanted, robot.paused = COMMAND, False
    process = start(*GUARD, *NAMESPACE)
    robot.wait_for(GuardState.HELD, STOP)  # as after a guard was restarted while others moved

    robot.start(COMMAND)
    robot.wanted = (math.nan, 0.0)  # as silence
    robot.wait_for(GuardState.SILENT, STOP)
    process.wait_for_output('tb3_1 is stopped: its commands have ended')
    robot.wanted = COMMAND
    peer.wait_for_new(robot.received, 5)
    assert velocities(robot.received[-1]) == STOP  # it waits for a start

    robot.start(COMMAND)
    process.popen.send_signal(signal.SIGTERM)
    peer.wait_for(lambda: velocities(robot.received[-1]) == STOP)
    assert process.wait() == 0


def test_a_command_that_is_no_number_stops_the_robot_though_good_ones_come_too(peer, robot):
    robot.start(COMMAND)
    good_and_bad = itertools.cycle([COMMAND, (math.nan, 0.0), (0.0, math.inf)])

    def mix():
        robot.wanted = next(good_and_bad)

    peer.node.create_timer(0.05, mix)
    peer.wait_for(lambda: robot.report.state.stops)
    peer.wait_for_new(robot.received, 20)
    assert {velocities(message) for message in robot.received[-15:]} == {STOP}


def test_a_guard_that_stalls_does_not_follow_the_command_that_came_before(start, peer, operator):
    robot = Robot(peer, operator)
    guard = start(*GUARD, *NAMESPACE).popen
    robot.start(COMMAND)

    guard.send_signal(signal.SIGSTOP)
    begin = time.monotonic()
    peer.wait_for(lambda: time.monotonic() > begin + 0.3)  # a command waits in its queue
    robot.wanted = None
    peer.wait_for(lambda: time.monotonic() > begin + 1.0)
    known = len(robot.received)
    guard.send_signal(signal.SIGCONT)
    peer.wait_for_new(robot.received, 10)

    assert {velocities(message) for message in robot.received[known:]} == {STOP}


def test_commands_that_queue_in_the_network_stop_the_robot_until_a_start(peer, robot):
    robot.start(COMMAND)

    robot.queued_since = time.time()
    robot.let_go_until(GuardState.SILENT, STOP)
    peer.wait_for(lambda: robot.delay() == 1.0)
    robot.paused = True  # a start alone does not help
    robot.wait_for(GuardState.PAUSED)
    known, robot.paused = len(robot.reports), False
    robot.let_go_until(GuardState.SILENT)
    states = {reported(message).state for message in robot.reports[known:]}
    assert GuardState.FOLLOWING not in states

    robot.queued_since = math.inf
    robot.start(COMMAND)


def test_no_node_that_joins_moves_the_robot_whatever_its_name(peer, robot, other):
    robot.start()
    rogue = Node('cmd_vel_guard', namespace='/tb3_1', context=other.context)
    command = rogue.create_publisher(TwistStamped, '/tb3_1/cmd_vel', 1)
    robot.wait_for(GuardState.CONTESTED, STOP)
    command.publish(robot.message((0.2, 0.0)))
    peer.wait_for_new(robot.received, 5)
    assert velocities(robot.received[-1]) == STOP
    assert not robot.motors.count(False)

    rogue.destroy_publisher(command)
    robot.start()
    rogue.create_publisher(TwistStamped, '/tb3_1/cmd_vel_guarded', 1)
    robot.wait_for(GuardState.INTRUDED, STOP)
    peer.wait_for(lambda: robot.motors[-1] is False)
    rogue.destroy_node()
    robot.start()
    peer.wait_for(lambda: robot.motors[-1] is True)


def test_a_robot_is_held_at_once_and_who_else_commands_it_said_once_that_may_have_a_name(
    peer, monkeypatch
):
    commanders, paused = ['/tb3_1/cmd_vel_bridge'], [PauseReason(PauseCause.OPERATOR, 'by test')]

    def rivals(node, topic, *allowed):
        return list(commanders) if topic == '/tb3_1/cmd_vel' else []

    monkeypatch.setattr(cmd_vel_topics, 'rivals', rivals)
    guard = CmdVelGuard(namespace='/tb3_1', context=peer.context)
    monkeypatch.setattr(guard, '_trouble_of_base', lambda: None)
    monkeypatch.setattr(guard.pause, 'reason', lambda: next(iter(paused), None))
    command = TwistStamped()
    command.twist.linear.x, command.twist.angular.z = COMMAND
    guard.cmd_vel = lambda: command
    clock = SimpleNamespace(t=guard.time.now, now=lambda: clock.t, stamp=messages.stamp)
    guard.time.clock = clock

    def step(seconds=0.05, stall=0.0):
        guard.time.begin_step(clock.t + seconds)
        clock.t += seconds + stall  # between the begin of the step and the command
        command.header.stamp = messages.stamp_of(round(1e9 * clock.t))
        guard.step()
        return guard.report.state

    assert step() is GuardState.PAUSED
    paused.clear()
    assert step() is GuardState.FOLLOWING
    assert guard.sent == COMMAND
    assert {step(stall=stall) for stall in (0.23, *[0.0] * 9)} == {GuardState.FOLLOWING}

    commanders.append(NAMELESS)
    reports = []
    for seconds in (0.05, 0.1, 0.3):
        reports.append(step(seconds))
        assert guard.sent == STOP
    assert reports == [GuardState.FOLLOWING, GuardState.FOLLOWING, GuardState.CONTESTED]
    assert NAMELESS in guard.report.reason

    commanders[:] = ['/tb3_1/cmd_vel_bridge', '/other']
    step()
    assert '/other' in guard.report.reason
    commanders[:] = ['/tb3_1/cmd_vel_bridge', NAMELESS]  # another one has its time, too
    guard.report = GuardDecision(GuardState.IDLE)
    assert step() is GuardState.IDLE
    assert step(0.9) is GuardState.IDLE  # and more of it while the robot stands
    assert step(0.2) is GuardState.CONTESTED
    guard.destroy_node()


def test_an_emergency_stop_of_any_node_is_released_by_the_node_that_held_it_and_then_still_paused(
    peer, robot, other
):
    robot.start()
    another = other.publisher(Bool, '/emergency_stop')  # volatile, as `ros2 topic pub` is
    another.publish(Bool(data=True))
    robot.wait_for(GuardState.EMERGENCY, STOP)
    peer.wait_for(lambda: robot.motors[-1:] == [False])
    known = len(robot.motors)
    another.publish(Bool(data=False))
    robot.stopped = False  # of a node that has not held it
    peer.wait_for_new(robot.received, 5)
    assert robot.report.state is GuardState.EMERGENCY

    robot.stopped = True
    peer.wait_for_new(robot.received, 5)
    robot.stopped = False
    robot.wait_for(GuardState.HELD, STOP)
    peer.wait_for_new(robot.motors)  # the guard asks again every second
    assert True not in robot.motors[known:]  # and not to switch them on before the next start
    robot.start()
    peer.wait_for(lambda: robot.motors[-1] is True)


@pytest.mark.parametrize('was_remapped', [True, False])
def test_a_base_that_listens_to_cmd_vel_is_stopped(start, peer, operator, was_remapped):
    robot = Robot(peer, operator)
    if not was_remapped:
        peer.cmd_vel(1)
    start(*GUARD, *NAMESPACE)
    if was_remapped:
        robot.start(COMMAND)
        peer.cmd_vel(1)
    robot.wanted, robot.paused = COMMAND, False
    robot.wait_for(GuardState.OPEN, STOP)
    robot.wheels.twist.twist.linear.x = 0.1  # the guard did not command that
    peer.wait_for_new(robot.reports, 10)
    assert robot.report.state is GuardState.OPEN
    assert False not in robot.motors


@pytest.mark.parametrize(
    ('topic', 'state'),
    [('cmd_vel', GuardState.OPEN), ('cmd_vel_guarded', GuardState.UNCONNECTED)],
)
def test_without_odometry_of_its_own_a_base_must_be_the_only_listener(
    start, peer, operator, other, topic, state
):
    robot = Robot(peer, operator, odometry_from=other)
    start(*GUARD, *NAMESPACE)
    robot.start(COMMAND)

    operator.listen(TwistStamped, f'/tb3_1/{topic}')  # it may be the base
    robot.wait_for(state, STOP)
