"""Controllers that exchange states over graphs and imperfect links, over real topics."""

import math

import numpy as np
import pytest
from processes import CTRL, SIMU

pytest.importorskip('rclpy')

from nav_msgs.msg import Odometry
from ros_peer import position
from std_msgs.msg import Float32MultiArray, Float64MultiArray, String

from setcmas_ctrl.communication.communication_options import (
    CommunicationOptions,
    chosen_communication,
)
from setcmas_ctrl.communication.message_content import decoded
from setcmas_ctrl.fleet_network import FleetNetwork
from setcmas_ctrl.fleet_poses import FleetPoses
from setcmas_simu.ros import qos

LOSSY = ('--graph', 'path', '--loss', '0.3', '--delay', '0.15')
FOUR = (*CTRL, '--algo', 'leader_election', '--nb-robots', '4', '--set', 'NUMBERS=[3, 1, 2, 9]')


def messages_of(peer, robots):
    return [peer.listen(String, f'/tb3_{i}/message', qos.LATCHED_BY_MANY) for i in robots]


def test_robots_exchange_values_with_loss_and_delay(start, peer):
    start(*SIMU, '--nb-robots', '4').wait_for_output('simulating')
    for robots in ('1-2', '3-4'):
        start(*FOUR, *LOSSY, '--robots', robots)
    sent = messages_of(peer, (1, 2, 3, 4))

    peer.wait_for(lambda: all(sent) and {decoded(one[-1].data).value[0] for one in sent} == {9.0})
    for robot, own in enumerate(sent, start=1):
        contents = [decoded(message.data) for message in own]
        assert contents[0].value[:2].tolist() == [(3, 1, 2, 9)[robot - 1], robot]
        assert contents[-1].value.tolist() == pytest.approx([9, 4, -5, 5], abs=0.01)
        times = [content.t for content in contents]
        assert times == sorted(times)


def test_programs_of_others_may_send_values(start, peer, script):
    law = script(
        """
        from setcmas_ctrl import network
        def control(robotNo, nbRobots, poses, t):
            received = network.received()
            return (0.1 * received[2].value[0], 0.1) if 2 in received else (0, 0)
        """
    )
    start(*SIMU, '--nb-robots', '2').wait_for_output('simulating')
    process = start(*CTRL, '--algo', law, '--nb-robots', '2', '--robots', '1')
    wanted = peer.cmd_cart_vel(1)
    publisher = peer.publisher(String, '/tb3_2/message', qos=qos.LATCHED_BY_MANY)
    publisher.publish(String(data='5.0'))
    publisher.publish(String(data='{"t": 0, "value": [2, 7]}'))

    peer.wait_for(lambda: wanted and wanted[-1].x == pytest.approx(0.2))
    process.wait_for_output('ignored a message on /tb3_2/message: it must be a JSON object with t')


def test_laws_that_send_nothing_have_no_topic(start, peer):
    start(*SIMU, '--nb-robots', '2').wait_for_output('simulating')
    start(*CTRL, '--algo', 'consensus', '--nb-robots', '2', '--robots', '1')
    wanted = peer.cmd_cart_vel(1)
    peer.wait_for_new(wanted, 3)

    names = [name for name, _ in peer.node.get_topic_names_and_types()]
    assert not [name for name in names if name.endswith(('/message', '/links'))]


def counts(message):
    """Return rows of senders with sent, received, lost, mean interval."""
    sizes = [dimension.size for dimension in message.layout.dim]
    assert message.layout.dim[0].label == 'sender'
    return np.array(message.data).reshape(sizes)


@pytest.mark.nightly
def test_a_fleet_over_two_processes_knows_the_others_by_their_broadcasts_only(start, peer):
    start(*SIMU, '--nb-robots', '4', '--robot-rate', '20').wait_for_output('simulating')
    event_triggered = [*CTRL, '--algo', 'consensus', '--event-triggered', '--nb-robots', '4']
    first = start(*event_triggered, '--robots', '1-2')
    first.wait_for_output('waiting for the states of robots 3-4 (/tb3_3/trig_odom)')
    odometry = [peer.odometry(robot) for robot in (1, 2, 3, 4)]
    second = start(*event_triggered, '--robots', '3-4')
    for process, robots in ((first, '1-2'), (second, '3-4')):
        process.wait_for_output(f'controlling robots {robots} with consensus')

    def spread():
        return np.ptp([position(messages[-1]) for messages in odometry], axis=0).max()

    peer.wait_for(lambda: all(odometry) and spread() < 0.7)
    for robot in (1, 2, 3, 4):
        listeners = peer.node.get_subscriptions_info_by_topic(f'/tb3_{robot}/odom')
        assert [info.node_name for info in listeners].count('controller') == 1
        listeners = peer.node.get_subscriptions_info_by_topic(f'/tb3_{robot}/trig_odom')
        assert [info.node_name for info in listeners].count('controllers') == 2
    assert peer.node.count_publishers('/communication_graph') == 0
    assert first.end() == second.end() == 0


def network_of(peer, options, robots):
    """Return the links of some robots of a fleet of two, on the peer's node."""
    return FleetNetwork(peer.node, FleetPoses({}, 2), chosen_communication(2, options), robots)


def test_a_graph_switches_at_the_step_at_which_it_does_offline(peer, script):
    graph = script(
        """
        segments:
          - {duration: 0.4, graph: ring}
          - {duration: 0.2, edges: [1 <- 2: 0]}
        repeat: true
        """,
        'switching.yaml',
    )
    links = network_of(peer, CommunicationOptions(graph=graph), [1, 2])

    def is_connected(t):
        links.begin_step(t)
        return bool(links.known_by(1)[1].any())

    times = (0.0, 0.2003, 0.3997, 0.5997, 0.9999, 1.2004)  # as a timer of 5 Hz gives them
    assert [is_connected(t) for t in times] == [True, True, False, True, False, True]


def test_a_repeated_state_is_received_once(peer):
    network = network_of(peer, CommunicationOptions(event_triggered=True), [1])
    links = peer.listen(Float64MultiArray, '/tb3_1/links', qos.LATCHED_BY_MANY)
    states = peer.listen(Odometry, '/tb3_2/trig_odom')
    publishers = [
        peer.publisher(Odometry, f'/tb3_{i}/trig_odom', i, qos=qos.LATCHED_BY_MANY) for i in (1, 2)
    ]

    def publish(publisher, x, second):
        state = Odometry()
        state.header.stamp.sec = second
        state.pose.pose.position.x, state.pose.pose.orientation.w = x, 1.0
        publisher.publish(state)

    def taken():
        network.take()
        return network.missing() == []

    for publisher in publishers:
        publish(publisher, 0.0, 0)
    peer.wait_for(taken)
    network.begin_step(0.0)
    publish(publishers[1], math.nan, 7)  # no state
    # Repeated, of a robot that stands still, and of one whose odometry has no stamps.
    for count, (x, second) in enumerate([(0.0, 0), (0.0, 1), (0.0, 1), (1.0, 1), (1.0, 1)], 3):
        publish(publishers[1], x, second)
        peer.wait_for(lambda count=count: taken() and len(states) == count)
    network.stop()
    peer.wait_for(lambda: links and counts(links[-1])[1, 0])
    network.begin_step(0.2)

    assert network.known_by(1)[0][0].tolist() == [0.0, 1.0]
    assert counts(links[-1])[1, :2].tolist() == [2, 2]


@pytest.mark.nightly
def test_a_process_reports_the_links_of_its_own_robots(start, peer):
    start(*SIMU, '--nb-robots', '3', '--robot-rate', '50').wait_for_output('simulating')
    options = ['--graph', 'directed_ring', '--loss', '0.3', '--nb-robots', '3', '--robots', '2-3']
    start(*CTRL, '--algo', 'consensus', *options)
    graph = peer.listen(Float32MultiArray, '/communication_graph', qos.LATCHED_BY_MANY)
    links = peer.listen(Float64MultiArray, '/tb3_2/links', qos.LATCHED_BY_MANY)
    peer.wait_for(lambda: graph and links and counts(links[-1])[2, 0] > 200)

    weights = np.array(graph[-1].data).reshape(3, 3)
    assert np.isnan(weights[0]).all()
    assert weights[1:].tolist() == [[0, 0, 1], [1, 0, 0]]
    assert [dimension.label for dimension in graph[-1].layout.dim] == ['receiver', 'sender']
    sent, received, lost, interval = counts(links[-1]).T
    assert (sent > 0).tolist() == [False, False, True]
    assert (sent == received + lost).all()
    assert lost[2] / sent[2] == pytest.approx(0.3, abs=5 * math.sqrt(0.3 * 0.7 / sent[2]))
    assert interval[2] > 1 / 50
