"""Scripts in the style of the ROS 1 stack run as they are, with ROS and without."""

from pathlib import Path

import numpy as np
import pytest
from processes import CTRL, SIMU

from setcmas_tools import simulate

FOLDER = Path(__file__).parent / 'ros1'
PRINTED = {
    'wander': 'tb3_{i}: robot {i} of 3\n',
    'circle_with_tabs': '',
    'with_helper': 'tb3_{i}: first call of the helper of robot {i}\n',
    'class_and_integers': 'tb3_{i}: waypoint 1\n',
    'nested_function_and_sys': 'tb3_{i}: third call\n',
}
"""Each script, and what every robot's prints once at least."""


@pytest.mark.parametrize('name', PRINTED)
def test_without_ros(name, capsys):
    said = []

    run = simulate(FOLDER / f'{name}.py', nb_robots=3, duration=30, warn=said.append)

    assert said == []
    assert np.abs(run.poses[-1, :2] - run.poses[0, :2]).max() > 0.5
    printed = capsys.readouterr().out
    for robot in (1, 2, 3):
        assert PRINTED[name].format(i=robot) in printed


def test_over_ros(start, peer):
    pytest.importorskip('rclpy')
    from ros_peer import position
    from visualization_msgs.msg import Marker, MarkerArray

    fleet = str(3 * len(PRINTED))
    laws = [f'{3 * k + 1}-{3 * k + 3}:{FOLDER / name}.py' for k, name in enumerate(PRINTED)]
    start(*SIMU, '--nb-robots', fleet, '--pose', '10:0.9,0.9').wait_for_output('simulating')
    odometry = [peer.odometry(robot + 1) for robot in range(3 * len(PRINTED))]
    markers = peer.listen(Marker, '/tb3_1/ref'), peer.listen(Marker, '/tb3_10/wp_ref')
    trails = (
        peer.listen(MarkerArray, '/tb3_4/traj_ref'),
        peer.listen(MarkerArray, '/tb3_10/history'),
    )
    peer.wait_for(lambda: all(odometry))
    begin = [position(messages[0]) for messages in odometry]
    process = start(*CTRL, '--algo', ','.join(laws), '--nb-robots', fleet)

    def moved(robot):
        here = position(odometry[robot - 1][-1])
        return np.hypot(*np.subtract(here, begin[robot - 1])) > 0.2

    peer.wait_for(lambda: all(map(moved, range(1, 3 * len(PRINTED) + 1))))
    peer.wait_for(lambda: all(markers) and all(trails))
    assert process.wait_for_output('tb3_2: robot 2 of 15\n')
    assert process.wait_for_output('tb3_8: first call of the helper of robot 8\n')
    assert process.wait_for_output('tb3_10: waypoint 1\n')
    assert process.wait_for_output('tb3_13: third call\n')
    assert process.end() == 0, process.output()
