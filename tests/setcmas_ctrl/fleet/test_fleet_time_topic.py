import signal

import pytest
from processes import CTRL, SIMU

pytest.importorskip('rclpy')

from sensor_msgs.msg import TimeReference

STANDS = 'def control(robotNo, nbRobots, poses, t):\n    print(t)\n    return 0, 0\n'


def seconds(time):
    return time.sec + 1e-9 * time.nanosec


def test_a_controller_that_comes_later_or_again_joins_at_the_t_of_the_fleet(start, peer, script):
    law = script(STANDS)
    start(*SIMU, '--nb-robots', '2').wait_for_output('simulating')
    control = [*CTRL, '--algo', law, '--nb-robots', '2', '--robots']
    told = peer.listen(TimeReference, '/fleet_time')

    def newest(robot):
        return next((one for one in told[::-1] if one.source.startswith(f'robot {robot} ')), None)

    def begin(robot):
        """Return when t was 0."""
        return seconds(newest(robot).header.stamp) - seconds(newest(robot).time_ref)

    start(*control, '1')
    peer.wait_for(lambda: newest(1) and seconds(newest(1).time_ref) > 1)
    for signum in (signal.SIGKILL, signal.SIGINT):
        before = seconds(newest(1).time_ref)
        second = start(*control, '2')
        peer.wait_for(lambda: newest(2) and begin(2) == pytest.approx(begin(1), abs=0.05))
        first_call = second.wait_for_output('tb3_2: ').partition('tb3_2: ')[2]
        assert float(first_call.split()[0]) > before
        second.end(signum)
        told.clear()
        peer.wait_for(lambda: newest(1))
