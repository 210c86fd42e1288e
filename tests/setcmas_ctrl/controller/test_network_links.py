"""Controllers that exchange states over graphs and imperfect links, over real topics."""

import math

import numpy as np
import pytest
from processes import CTRL, SIMU

pytest.importorskip('rclpy')

from nav_msgs.msg import Odometry
from rclpy.qos import DurabilityPolicy, QoSProfile
from ros_peer import position
from std_msgs.msg import Float32MultiArray, Float64MultiArray

from setcmas_ctrl.communication.communication_settings import (
    CommunicationOptions,
    chosen_communication,
)
from setcmas_ctrl.controller.network_links import FleetCommunication
from setcmas_ctrl.driving.odometry import FleetOdometry

LATCHED = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)


def counts(message):
    """Return rows of senders with sent, received, lost, mean interval."""
    sizes = [dimension.size for dimension in message.layout.dim]
    assert message.layout.dim[0].label == 'sender'
    return np.array(message.data).reshape(sizes)


@pytest.mark.nightly
def test_a_ring_with_losses(start, peer, script):
    law = script(
        """
        import numpy as np
        from setcmas_ctrl import network
        def control(robotNo, nbRobots, poses, t):
            around = sorted({robotNo % 5 + 1, (robotNo - 2) % 5 + 1})
            assert network.neighbours() == around
            known = (np.flatnonzero(np.isfinite(poses[0])) + 1).tolist()
            assert known == sorted([*around, robotNo])
            return 0, 0
        """
    )
    start(*SIMU, '--nb-robots', '5', '--robot-rate', '50').wait_for_output('simulating')
    options = ['--nb-robots', '5', '--graph', 'ring', '--loss', '0.3']
    process = start(*CTRL, '--algo', law, *options)
    links = [peer.listen(Float64MultiArray, f'/tb3_{i}/links', LATCHED) for i in range(1, 6)]
    graph = peer.listen(Float32MultiArray, '/communication_graph', LATCHED)
    peer.wait_for(lambda: all(links) and counts(links[0][-1])[1, 0] > 200)

    assert process.end() == 0, process.output()
    peer.wait_for(lambda: process.popen.poll() is not None)
    tables = np.array([counts(messages[-1]) for messages in links])
    sent, received, lost = tables[..., 0], tables[..., 1], tables[..., 2]
    ring = np.roll(np.eye(5), 1, axis=1) + np.roll(np.eye(5), -1, axis=1)
    assert ((sent > 0) == (ring > 0)).all()
    assert (sent == received + lost).all()
    sigma = math.sqrt(0.3 * 0.7 / sent.sum())
    assert lost.sum() / sent.sum() == pytest.approx(0.3, abs=5 * sigma)
    assert sent.sum() > 1000
    assert (tables[..., 3][ring > 0] > 1 / 50).all()  # the mean interval between arrivals
    assert [dimension.label for dimension in graph[-1].layout.dim] == ['receiver', 'sender']
    assert graph[-1].data.tolist() == ring.ravel().tolist()


def test_a_fleet_over_two_processes_knows_the_others_by_their_broadcasts_only(start, peer):
    places = [
        f'--pose={i}:{x},{y}' for i, (x, y) in enumerate([(1, 1), (1, -1), (-1, -1), (-1, 1)], 1)
    ]
    start(*SIMU, '--nb-robots', '4', '--robot-rate', '20', *places).wait_for_output('simulating')
    event_triggered = [*CTRL, '--algo', 'consensus', '--event-triggered', '--nb-robots', '4']
    first = start(*event_triggered, '--robots', '1-2')
    first.wait_for_output('waiting for the states of robots 3-4 (/tb3_3/trig_odom)')
    odometry = [peer.odometry(robot) for robot in (1, 2, 3, 4)]
    states = [peer.listen(Odometry, f'/tb3_{i}/trig_odom', LATCHED) for i in (1, 2, 3, 4)]
    second = start(*event_triggered, '--robots', '3-4')
    for process, robots in ((first, '1-2'), (second, '3-4')):
        process.wait_for_output(f'controlling robots {robots} with consensus')

    def spread():
        return np.ptp([position(messages[-1]) for messages in odometry], axis=0).max()

    peer.wait_for(lambda: all(odometry) and spread() < 0.7)
    for robot in (1, 2, 3, 4):
        listeners = peer.node.get_subscriptions_info_by_topic(f'/tb3_{robot}/odom')
        assert [info.node_name for info in listeners].count('controllers') == 1
        listeners = peer.node.get_subscriptions_info_by_topic(f'/tb3_{robot}/trig_odom')
        assert [info.node_name for info in listeners].count('controllers') == 2
    assert max(map(len, states)) < 0.3 * min(map(len, odometry))
    assert peer.node.count_publishers('/communication_graph') == 0
    assert first.end() == second.end() == 0


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
    communication = FleetCommunication(
        peer.node,
        FleetOdometry(peer.node, 2),
        chosen_communication(2, CommunicationOptions(graph=graph)),
        [1, 2],
    )
    times = (0.0, 0.2003, 0.3997, 0.5997, 0.9999, 1.2004)  # as a timer of 5 Hz gives them

    assert [bool(communication.known_poses(t)[1].any()) for t in times] == [
        True,
        True,
        False,
        True,
        False,
        True,
    ]


def test_in_lockstep_messages_need_all_robots_in_one_process(peer):
    communication = FleetCommunication(
        peer.node, FleetOdometry(peer.node, 2), chosen_communication(2), [1]
    )
    communication.in_lockstep = True

    with pytest.raises(RuntimeError, match='all be controlled by one process; leave out --robots'):
        communication.begin()
    assert not communication.is_on


def test_a_process_reports_the_links_of_its_own_robots(start, peer):
    start(*SIMU, '--nb-robots', '3').wait_for_output('simulating')
    options = ['--graph', 'directed_ring', '--nb-robots', '3', '--robots', '2-3']
    start(*CTRL, '--algo', 'consensus', *options)
    graph = peer.listen(Float32MultiArray, '/communication_graph', LATCHED)
    peer.wait_for(lambda: graph)

    weights = np.array(graph[-1].data).reshape(3, 3)
    assert np.isnan(weights[0]).all()
    assert weights[1:].tolist() == [[0, 0, 1], [1, 0, 0]]


def test_failing_scripts_and_unknown_robots_are_reported(start, peer, script):
    law = script('def control(i, n, poses, t):\n    return poses[0].mean() if i == 1 else 0, 0\n')
    when = script('def ctc(pos, last_pos, t):\n    return 1 / 0\n', 'when.py')
    start(*SIMU, '--nb-robots', '3').wait_for_output('simulating')
    options = ['--nb-robots', '3', '--graph', 'path', '--delay', '0.1']
    process = start(*CTRL, '--algo', law, *options, '--event-triggered', '--ctc', when)
    states = peer.listen(Odometry, '/tb3_3/trig_odom')
    peer.wait_for_new(states, 10)

    output = process.wait_for_output('receives nothing from')
    assert 'tb3_1 receives nothing from robot 3: poses has NaN there' in output
    assert 'when.py, line 2: ZeroDivisionError' in output
    assert ' sends its state whenever the condition fails' in output
    assert process.end() == 1
    assert 'Traceback' not in process.output()
