"""Laws that send values to each other, over real topics and links."""

import numpy as np
import pytest
from processes import CTRL, SIMU

pytest.importorskip('rclpy')

from lab_peer import LabPeer
from nav_msgs.msg import Odometry
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import Float64MultiArray

from setcmas_ctrl.communication.message_content import Content, checked_value
from setcmas_ctrl.controller.message_topics import encoded

LATCHED = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)
LOSSY = ('--graph', 'path', '--loss', '0.3', '--delay', '0.15')
FOUR = (*CTRL, '--algo', 'leader_election', '--nb-robots', '4', '--set', 'NUMBERS=[3, 1, 2, 9]')


def messages_of(peer, robots):
    return [peer.listen(Float64MultiArray, f'/tb3_{i}/message', LATCHED) for i in robots]


@pytest.mark.parametrize(
    'parts',
    [
        pytest.param((), id='one process', marks=pytest.mark.nightly),
        pytest.param(('1-2', '3-4'), id='two processes'),
    ],
)
def test_robots_exchange_values_with_loss_and_delay(parts, start, peer):
    start(*SIMU, '--nb-robots', '4').wait_for_output('simulating')
    for robots in parts:
        start(*FOUR, *LOSSY, '--robots', robots)
    if not parts:
        start(*FOUR, *LOSSY)
    sent = messages_of(peer, (1, 2, 3, 4))

    peer.wait_for(lambda: all(sent) and {one[-1].data[1] for one in sent} == {9.0})
    for robot, own in enumerate(sent, start=1):
        assert own[0].data.tolist()[1:3] == [(3, 1, 2, 9)[robot - 1], robot]
        assert own[-1].data.tolist()[1:] == pytest.approx([9, 4, -5, 5], abs=0.01)
        times = [message.data[0] for message in own]
        assert times == sorted(times)


def test_a_value_has_a_published_layout(start, peer, script):
    law = script(
        """
        import numpy as np
        from setcmas_ctrl import network
        def control(robotNo, nbRobots, poses, t):
            network.send({'x': 1.5, 'v': [1, 2, 3], 'A': np.eye(2)})
            return 0, 0
        """
    )
    start(*SIMU, '--nb-robots', '1').wait_for_output('simulating')
    (sent,) = messages_of(peer, [1])
    start(*CTRL, '--algo', law, '--nb-robots', '1')
    peer.wait_for(lambda: sent)
    layout = sent[0].layout

    assert layout.data_offset == 1
    assert [(one.label, one.size, one.stride) for one in layout.dim] == [
        ('x', 1, 0), ('v', 3, 3), ('A', 2, 4), ('A', 2, 2),
    ]  # fmt: skip
    assert sent[0].data.tolist() == pytest.approx([0, 1.5, 1, 2, 3, 1, 0, 0, 1], abs=0.01)


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
    publisher = peer.publisher(Float64MultiArray, '/tb3_2/message', qos=LATCHED)
    publisher.publish(Float64MultiArray(data=[0.0, 5.0]))  # without a layout
    publisher.publish(encoded(Content(0.0, checked_value([2.0, 7.0]))))

    peer.wait_for(lambda: wanted and wanted[-1].x == pytest.approx(0.2))
    process.wait_for_output('ignored a message on /tb3_2/message: it must begin with a time in s')


def test_laws_that_send_nothing_have_no_topic(start, peer):
    start(*SIMU, '--nb-robots', '2').wait_for_output('simulating')
    start(*CTRL, '--algo', 'consensus', '--nb-robots', '2', '--robots', '1')
    wanted = peer.cmd_cart_vel(1)
    peer.wait_for_new(wanted, 3)

    names = [name for name, _ in peer.node.get_topic_names_and_types()]
    assert not [name for name in names if name.endswith(('/message', '/links'))]


def test_each_value_that_a_condition_sends_is_received_in_another_process(start, peer, script):
    law = script(
        """
        from setcmas_ctrl import network
        def control(robotNo, nbRobots, poses, t):
            received = network.received()
            network.send({'count': min(t // 0.3, 3)})
            return 0.01 * max([0, *(1 + one.value['count'] for one in received.values())]), 0
        """
    )
    when = script(
        """
        def ctc(pos, last_pos, t, *, value, last_value):
            return value is not None and value != last_value
        """,
        'when.py',
    )
    start(*SIMU, '--nb-robots', '2').wait_for_output('simulating')
    states = peer.listen(Odometry, '/tb3_2/trig_odom', LATCHED)
    sent = messages_of(peer, [2])[0]
    wanted = peer.cmd_cart_vel(1)
    for robot in ('1', '2'):
        options = ['--robots', robot, '--event-triggered', '--ctc', when]
        start(*CTRL, '--algo', law, '--nb-robots', '2', *options)

    # The last value triggers one state only.
    peer.wait_for(lambda: wanted and wanted[-1].x == pytest.approx(0.04))
    assert len(states) <= 1 + len({message.data[1] for message in sent})


def test_experiments_have_messages(start, peer, script):
    law = script(
        """
        from setcmas_ctrl import network
        def control(robotNo, nbRobots, poses, t):
            network.send(poses[0, robotNo - 1])
            return sum(message.value for message in network.received().values()), 0
        """
    )
    for robot in (1, 2):
        odometry = Odometry()
        odometry.pose.pose.position.x, odometry.pose.pose.orientation.w = 0.1 * robot, 1.0
        publisher = peer.node.create_publisher(Odometry, f'/mocap/tb3_{robot}/odom', 1)
        peer.node.create_timer(0.05, lambda p=publisher, o=odometry: p.publish(o))
    lab = LabPeer(peer, ('tb3_1', 'tb3_2'))
    lab.paused = False
    wanted = [peer.cmd_cart_vel(robot) for robot in (1, 2)]
    start(*CTRL, '--algo', law, '--nb-robots', '2', '--experiment')

    peer.wait_for(lambda: all(wanted) and wanted[0][-1].x and wanted[1][-1].x)
    np.testing.assert_allclose([one[-1].x for one in wanted], [0.2, 0.1], atol=1e-6)
