"""A control law that shares no code with this project, nor its DDS."""

import sys
import time
from pathlib import Path

import pytest
from processes import CTRL, SIMU

pytest.importorskip('rclpy')
pytest.importorskip('cyclonedds')

from rehearsal import Rehearsal
from ros_peer import position

LAW = Path(__file__).parent / 'scripts' / 'foreign_controller.py'
WAY_M = 0.16


def test_a_control_law_of_another_maker_drives_a_robot_while_it_speaks(start, peer, domain):
    start(*SIMU, '--nb-robots', '2')
    start(*CTRL, '--algo', 'external').wait_for_output('controlling robots 1-2')
    law = start(sys.executable, str(LAW), str(domain), '2')
    still, driven = peer.odometry(1), peer.odometry(2)

    peer.wait_for(lambda: driven and driven[-1].twist.twist.linear.x == pytest.approx(0.2))
    law.kill_group()
    peer.wait_for(lambda: driven[-1].twist.twist.linear.x == 0.0)
    assert position(still[-1]) == position(still[0])


@pytest.mark.nightly
def test_a_law_of_another_maker_drives_a_robot_of_the_lab_with_every_stop(
    start, peer, domain, tmp_path
):
    law = start(sys.executable, str(LAW), str(domain), '1')
    lab = ('--emulate', '--pose', '1:-2.5,0,0', '--without-motion-check')
    with Rehearsal(peer, tmp_path, '--algo', 'external', nb_robots=1, lab=lab) as experiment:
        experiment.let_go()
        assert experiment.wait_for_stop(experiment.fault('dropout 1 1')).metres < WAY_M
        experiment.let_go()

        killed = time.time()
        law.kill_group()
        assert experiment.wait_for_stop(killed).metres < WAY_M
        start(sys.executable, str(LAW), str(domain), '1')
        peer.wait_for(lambda: peer.node.count_publishers('/tb3_1/cmd_cart_vel') == 1)
        stands = len(experiment.truth[1])
        peer.spin(2.0)
        assert {truth.rolls for truth in experiment.truth[1][stands:]} == {0.0}
        experiment.let_go()
