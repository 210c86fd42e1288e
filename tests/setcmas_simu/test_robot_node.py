"""Nodes of robots: their names and parameters, what they hear, and the order of their steps."""

from types import SimpleNamespace

import pytest

pytest.importorskip('rclpy')

from rclpy.parameter import Parameter
from std_msgs.msg import Bool, UInt16

from setcmas_simu.errors import SetcmasError
from setcmas_simu.robot_node import RobotNode, StepTime, run_steps, with_services
from setcmas_simu.ros import fleet_node, qos
from setcmas_simu.ros.fleet_node import FleetNode
from setcmas_simu.ros.polling import UNREADABLE


@pytest.fixture
def node_of(peer):
    """Return a function that creates a node with arguments of ROS; kwargs are its own."""

    def create(*given, kind=RobotNode, name='follower', **kwargs):
        arguments = ['--ros-args', *given]
        return peer.add(kind(name, context=peer.context, cli_args=arguments, **kwargs))

    return create


@pytest.mark.parametrize(
    ('given', 'robot', 'fleet_namespace'),
    [
        ((), 1, ''),
        (('-r', '__ns:=/tb3_3'), 3, ''),
        (('-r', '__ns:=/lab/tb3_12'), 12, '/lab'),
        (('-r', '__ns:=/lab'), 1, '/lab'),
        (('-r', '__ns:=/charlie', '-p', 'robot_no:=3', '-p', 'fleet_namespace:=/'), 3, ''),
        (('-r', '__ns:=/tb3_3', '-p', 'fleet_namespace:=/lab/'), 3, '/lab'),
    ],
)
def test_a_node_alone_is_of_the_robot_that_its_names_or_parameters_say(
    node_of, given, robot, fleet_namespace
):
    node = node_of(*given)

    assert (node.robot, node.fleet_namespace) == (robot, fleet_namespace)
    assert node.full_name('/pause') == f'{fleet_namespace}/pause'
    own = node.create_publisher(Bool, 'pause', qos.STATE).topic_name
    assert own == f'{node.get_namespace().rstrip("/")}/pause'


@pytest.mark.parametrize('number', ['0', '-1', '1.5', 'first'])
def test_a_number_that_no_robot_has_is_refused(node_of, number):
    with pytest.raises(SetcmasError, match=r'robot_no is .*; it must be a number from 1'):
        node_of('-p', f'robot_no:={number}')


def test_nodes_of_a_process_stand_below_the_namespace_of_its_fleet(node_of, monkeypatch):
    rules = ['-r', '__ns:=/lab', '-r', '__node:=laws']
    monkeypatch.setattr(fleet_node, '_arguments', ['--ros-args', *rules, '-p', 'gain:=2.0'])
    fleet = node_of(*rules, kind=FleetNode)
    node = node_of(robot=2, fleet=fleet)

    assert fleet.get_fully_qualified_name() == '/lab/laws'
    assert node.get_fully_qualified_name() == '/lab/tb3_2/follower'
    assert (node.robot, node.fleet_namespace) == (2, '/lab')
    assert node.create_publisher(Bool, '/pause', qos.STATE).topic_name == '/lab/pause'
    assert node.create_publisher(Bool, 'pause', qos.STATE).topic_name == '/lab/tb3_2/pause'
    assert fleet_node.of_other_nodes()['cli_args'] == ['--ros-args', '-p', 'gain:=2.0']


def test_without_rules_of_names_further_nodes_take_all_arguments(monkeypatch):
    monkeypatch.setattr(fleet_node, '_arguments', ['--ros-args', '-r', 'odom:=pose', '-p', 'a:=1'])

    assert fleet_node.of_other_nodes() == {}


def test_which_robot_it_is_stays_with_nodes_of_a_process(node_of):
    fleet = node_of(kind=FleetNode)
    given = [Parameter('robot_no', value=7), Parameter('fleet_namespace', value='/a')]
    nodes = [node_of(robot=i, fleet=fleet, parameter_overrides=given) for i in (1, 2)]

    assert [node.robot for node in nodes] == [1, 2]
    assert [node.fleet_namespace for node in nodes] == ['', '']


def test_the_newest_message_is_returned_once(node_of, peer):
    node = node_of('-r', '__ns:=/tb3_3')
    count = node.newest(UInt16, 'count')
    publisher = peer.publisher(UInt16, '/tb3_3/count')
    assert count() is None
    for number in (1, 2, 3):
        publisher.publish(UInt16(data=number))

    assert count().data == 3
    assert count() is None


def test_a_message_that_cannot_be_read_is_left_out(node_of, monkeypatch):
    def take(*_):
        raise UNREADABLE('cut short')  # by other middleware than Fast DDS, which skips it itself

    node, topic = node_of(), SimpleNamespace(handle=SimpleNamespace(take_message=take))
    monkeypatch.setattr(node, 'create_subscription', lambda *_, **__: topic)
    assert node.newest(UInt16, 'count')() is None


def test_fixed_parameters_come_from_the_start(node_of):
    node = node_of('-p', 'height:=2', '-p', 'odom_topic:=pose')

    assert node.fixed('odom_topic', 'odom', 'poses') == 'pose'
    assert node.fixed('model', 'unicycle', 'a model') == 'unicycle'
    assert node.number('height', 1.0, 'in m') == 2.0
    (answer,) = node.set_parameters([Parameter('model', value='car')])
    assert 'read-only' in answer.reason


@pytest.mark.parametrize('given', ['.nan', '.inf', '1e7', 'high', 'true'])
def test_numbers_are_finite(node_of, given):
    with pytest.raises(SetcmasError, match=r'parameter height is .*; it must be'):
        node_of('-p', f'height:={given}').number('height', 1.0, 'in m')


def test_a_warning_with_a_key_is_shown_once(node_of, capfd):
    node = node_of()
    for key in ('a', 'b', 'a'):
        node.warn_once(key, f'said of {key}')

    said = capfd.readouterr().err
    assert (said.count('said of a'), said.count('said of b')) == (1, 1)


class Clock:
    """A clock that goes on only when it is waited for, or set."""

    rtf = 1.0

    def __init__(self) -> None:
        self.t = 100.0

    def now(self) -> float:
        return self.t

    def stamp(self) -> None:
        pass

    def wait_until(self, t: float, _) -> None:
        self.t = max(self.t, t)


class Steps:
    """Notes its steps, which may take their time; asks to stop after the last.

    In place of a process it notes also for how long services may start after each step.
    """

    def __init__(self, clock: Clock, durations: list[float]) -> None:
        self.stopping, self.requests = False, self
        self.times: list[float] = []
        self.started: list[tuple[int, float]] = []
        self._clock = clock
        self._durations = iter(durations)

    def start_services(self, within_s: float) -> None:
        self.started.append((len(self.times), within_s))

    def step(self) -> None:
        self.times.append(round(self._clock.t - 100.0, 6))
        duration = next(self._durations, None)
        self.stopping = duration is None
        self._clock.t += duration or 0.0


@pytest.mark.parametrize(
    ('durations', 'times'),
    [
        ([0.0, 0.0, 0.19], [0.0, 0.2, 0.4, 0.6]),
        ([0.25, 0.0, 0.0], [0.0, 0.25, 0.4, 0.6]),  # late by less than a period
        ([0.9, 0.0, 0.0], [0.0, 0.9, 1.0, 1.2]),  # those of 0.2, 0.4 and 0.6 are left out
        ([0.25, 0.25, 0.0], [0.0, 0.25, 0.5, 0.6]),
    ],
)
def test_steps_keep_their_grid_and_are_not_made_up_for(durations, times):
    clock = Clock()
    steps = Steps(clock, durations)

    run_steps(steps, StepTime(0.2, clock), steps.step)
    assert steps.times == pytest.approx(times)


def test_services_start_after_2_s_for_a_tenth_of_each_period_of_real_time():
    clock = Clock()
    clock.rtf = 4.0
    steps = Steps(clock, [0.0] * 18)

    run_steps(steps, StepTime(0.5, clock), steps.step)
    assert [within_s for _, within_s in steps.started] == pytest.approx([0.0125] * 3)
    assert [nb_steps for nb_steps, _ in steps.started] == [17, 18, 19]


def test_nodes_of_up_to_20_robots_get_services():
    nodes = [SimpleNamespace(robot=robot) for robot in range(1, 22) for _ in range(3)]

    assert with_services(nodes[:60]) == nodes[:60]
    assert with_services(nodes) == ()


def test_the_period_may_change_on_the_way():
    clock = Clock()
    steps, time = Steps(clock, [0.0] * 3), StepTime(0.2, clock)

    def step():
        steps.step()
        time.period = 0.5

    run_steps(steps, time, step)
    assert steps.times == pytest.approx([0.0, 0.5, 1.0, 1.5])


def test_between_steps_it_polls_and_right_before_the_next_one_too():
    clock = Clock()
    steps, time = Steps(clock, [0.005]), StepTime(0.05, clock)
    time.is_polled = True
    polls = []

    run_steps(steps, time, steps.step, lambda: polls.append(round(clock.t - 100.0, 6)))
    assert polls == pytest.approx([0.01, 0.02, 0.03, 0.04])
