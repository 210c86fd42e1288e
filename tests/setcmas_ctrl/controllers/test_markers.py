import pytest
from processes import CTRL, SIMU

pytest.importorskip('rclpy')

from rclpy.qos import DurabilityPolicy, QoSProfile
from visualization_msgs.msg import Marker, MarkerArray


def test_drawings_are_seen_even_by_a_display_that_comes_late(start, peer):
    start(*SIMU, '--nb-robots', '1', '--pose', '1:2,0')
    process = start(*CTRL, '--algo', 'traj_tracking')
    process.wait_for_output('controlling')
    wanted = peer.cmd_cart_vel(1)
    peer.wait_for(lambda: len(wanted) > 10)
    late = QoSProfile(depth=500, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    trail = peer.listen(MarkerArray, '/tb3_1/traj_ref', late)
    peer.wait_for(lambda: len(trail) > 8)

    markers = [message.markers for message in trail]
    assert {len(m) for m in markers} == {1}
    assert len({m[0].id for m in markers}) == len(markers)
    assert markers[0][0].scale.x == pytest.approx(0.1)
    assert markers[0][0].color.b == 0.0


def test_one_name_may_serve_a_marker_and_a_trail(start, peer, script):
    law = script(
        """
        import rviz_marker, rviz_marker_array
        def control(robotNo, nbRobots, poses, t):
            rviz_marker.publish_marker(1, 2, 0, robotNo)
            rviz_marker_array.publish_marker(3, 4, 0, robotNo)
            return 0, 0
        """
    )
    start(*SIMU, '--nb-robots', '1')
    start(*CTRL, '--algo', law)
    marker = peer.listen(Marker, '/tb3_1/ref')
    trail = peer.listen(MarkerArray, '/tb3_1/ref_markerarray')

    peer.wait_for(lambda: marker and trail)
