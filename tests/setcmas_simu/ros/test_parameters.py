import math
from dataclasses import dataclass

import pytest

pytest.importorskip('rclpy')

from rclpy.parameter import Parameter

from setcmas_simu.errors import SetcmasError
from setcmas_simu.option_groups import Options, option
from setcmas_simu.option_kinds import Number, OneOf
from setcmas_simu.ros.fleet_node import FleetNode
from setcmas_simu.ros.parameters import NodeParameters, warn_of_unknown


@dataclass(frozen=True, kw_only=True)
class Gains(Options):
    gain: float = option(Number(above=0, most=9, unit='1/s'), 'a gain', default=1.0)
    longest: float = option(Number(least=0, unit='s'), 'a time', default=math.inf)
    mode: str = option(OneOf(('slow', 'fast')), 'a mode', default='slow')
    other: float = option(Number(), 'unknown parameter', default=1.0)


@pytest.fixture
def node_with(peer):
    def node_with(*given):
        arguments = [word for one in given for word in ('-p', one)]
        arguments.insert(0, '--ros-args')
        return peer.add(FleetNode('gains', context=peer.context, cli_args=arguments))

    return node_with


@pytest.fixture
def gains(node_with):
    """A node with parameters of which one is fixed, and their options."""
    node = node_with()
    names = {'K': 'gain', 'longest': 'longest', 'mode': 'mode'}
    return node, NodeParameters(node, Gains(), names, fixed=['longest'])


def change(node, **values):
    results = node.set_parameters([Parameter(name, value=v) for name, v in values.items()])
    return [result.reason for result in results if not result.successful]


def test_ros_arguments_take_the_place_of_options(node_with):
    node = node_with('K:=2', 'mode:=fast')

    parameters = NodeParameters(node, Gains(gain=3.0, other=5.0), {'K': 'gain', 'mode': 'mode'})
    assert parameters.options == Gains(gain=2.0, mode='fast', other=5.0)
    assert node.get_parameter('K').value == 2.0


@pytest.mark.parametrize('given', ['K:=10', 'K:=fast', 'mode:=1'])
def test_ros_arguments_that_make_no_sense(node_with, given):
    with pytest.raises(SetcmasError, match=r'parameter .* must be'):
        NodeParameters(node_with(given), Gains(), {'K': 'gain', 'mode': 'mode'})


def test_a_parameter_that_no_node_of_a_process_has_is_reported(node_with, capfd):
    given = ('gian:=2', 'mode:=fast', 'use_sim_time:=false', 'qos_overrides./odom:=1')
    nodes = [node_with(*given), node_with(*given)]
    NodeParameters(nodes[0], Gains(), {'gain': 'gain'})
    NodeParameters(nodes[1], Gains(), {'mode': 'mode'})
    warn_of_unknown(nodes)

    message = capfd.readouterr().err
    assert "unknown parameter 'gian'; did you mean gain?" in message
    assert message.count('unknown parameter') == 1


def test_a_set_parameter_counts_and_is_reported_once(gains):
    node, parameters = gains

    assert change(node, K=4) == []
    assert parameters.options == Gains(gain=4.0)
    assert change(node, K=4.0) == []
    assert change(node, mode='fast') == []
    assert parameters.options == Gains(gain=4.0, mode='fast')


@pytest.mark.parametrize(
    ('name', 'value', 'reason'),
    [
        ('K', 0.0, 'parameter K is 0; it must be above 0 and at most 9 1/s'),
        ('K', 'much', "parameter K is 'much'; it must be a number above 0"),
        ('K', 9.5, 'out of range'),
        ('longest', 1.0, 'read-only'),
        ('mode', 'odd', "parameter mode is 'odd'; it must be slow or fast"),
        ('mode', None, 'parameter mode is None; it must be slow or fast'),
    ],
)
def test_what_makes_no_sense_is_refused_with_a_reason(gains, name, value, reason):
    node, parameters = gains

    (message,) = change(node, **{name: value})
    assert reason in message
    assert parameters.options == Gains()


def test_what_cannot_be_now_is_refused(node_with):
    def check(options):
        raise SetcmasError(f'not now: {options.gain}')

    node = node_with()
    parameters = NodeParameters(node, Gains(), {'K': 'gain'}, check=check)
    assert change(node, K=2.0) == ['not now: 2.0']
    assert parameters.options == Gains()


def test_clients_see_types_and_ranges(gains):
    described = gains[0].describe_parameter('K')

    (bounds,) = described.floating_point_range
    assert (bounds.from_value, bounds.to_value) == (0.0, 9.0)
    assert described.type == Parameter.Type.DOUBLE.value
    assert described.description == 'a gain'
    assert described.additional_constraints == 'above 0 and at most 9 1/s'


def test_a_robot_follows_what_changes_in_the_fleet_and_keeps_its_own_values(node_with):
    node = node_with('K:=2')
    parameters = NodeParameters(node, Gains(), {'K': 'gain', 'mode': 'mode'})

    parameters.follow(Gains(mode='fast'))
    assert parameters.options == Gains(gain=2.0, mode='fast')
    parameters.follow(Gains(gain=3.0, mode='fast'))
    assert parameters.options == Gains(gain=3.0, mode='fast')
