import signal

import pytest
from processes import CTRL, SIMU
from sensor_msgs.msg import TimeReference

from setcmas_ctrl.controllers.fleet_time import FleetTime


def begun(at=100.0):
    time = FleetTime()
    time.step(at, paused=False)
    return time


def test_the_first_process_begins_at_0_and_goes_on_between_steps():
    time = FleetTime()

    assert time.at(99.0) == 0.0
    assert time.step(100.0, paused=False) == 0.0
    assert time.at(100.1) == pytest.approx(0.1)
    assert time.step(100.2, paused=False) == pytest.approx(0.2)


def test_it_stands_still_while_it_is_paused():
    time = begun()
    time.step(100.2, paused=False)
    for now in (100.4, 100.6):
        assert time.step(now, paused=True) == pytest.approx(0.2)
        assert time.at(now + 0.1) == pytest.approx(0.2)

    assert time.step(100.8, paused=False) == pytest.approx(0.4)


def test_after_a_paused_start_the_first_step_has_t_0():
    time = FleetTime()
    paused = [time.step(0.2 * step, paused=True) for step in range(3)]
    running = [time.step(0.2 * step, paused=step == 4) for step in range(3, 7)]

    assert paused == [0.0, 0.0, 0.0]
    assert running[0] == 0.0
    assert running[1:] == pytest.approx([0.0, 0.2, 0.4])


def test_processes_that_all_start_paused_begin_at_0():
    first, second = FleetTime(), FleetTime()
    first.step(100.0, paused=True)
    for step in range(3):
        second.synchronise(first.at(100.01 + 0.2 * step), 100.01 + 0.2 * step)
        second.step(100.1 + 0.2 * step, paused=True)
        first.synchronise(second.at(100.11 + 0.2 * step), 100.11 + 0.2 * step)
        first.step(100.2 + 0.2 * step, paused=step < 2)
    second.synchronise(first.at(100.61), 100.61)

    assert first.at(100.6) == pytest.approx(0.0, abs=1e-9)
    assert second.step(100.7, paused=False) == 0.0
    second.synchronise(first.step(100.8, paused=False), 100.8)
    assert second.step(100.9, paused=False) == pytest.approx(0.3)


@pytest.mark.parametrize(('sent_at', 't'), [(9.9, 57.1), (8.0, 0.0)], ids=['new', 'old'])
def test_a_process_that_comes_later_joins_a_fleet_that_has_not_ended(sent_at, t):
    time = FleetTime()
    time.synchronise(57.0, sent_at)

    assert time.step(10.0, paused=False) == pytest.approx(t)


@pytest.mark.parametrize(
    ('received', 't'), [(30.0, 30.0), (5.01, 5.0), (4.9, 5.0)], ids=['later', 'same', 'on its way']
)
def test_the_latest_received_t_is_that_of_the_fleet(received, t):
    time = begun()
    time.synchronise(received, 105.0)

    assert time.at(105.0) == pytest.approx(t)


def test_laws_that_begin_anew_join_the_others_or_begin_at_0():
    alone, beside_another = begun(), begun()
    beside_another.synchronise(0.9, 101.0)
    alone.begin_anew()
    beside_another.begin_anew()

    assert alone.step(101.1, paused=False) == 0.0
    assert beside_another.step(101.1, paused=False) == pytest.approx(1.0)


pytest.importorskip('rclpy')


STANDS = 'def control(robotNo, nbRobots, poses, t):\n    print(t)\n    return 0, 0\n'


def seconds(time):
    return time.sec + 1e-9 * time.nanosec


def test_a_controller_that_comes_later_or_again_joins_at_the_t_of_the_fleet(start, peer, script):
    law = script(STANDS)
    start(*SIMU, '--nb-robots', '2').wait_for_output('simulating')
    control = [*CTRL, '--algo', law, '--nb-robots', '2', '--robots']
    received = peer.listen(TimeReference, '/fleet_time')

    def newest(robot):
        return next(
            (one for one in received[::-1] if one.source.startswith(f'robot {robot} ')), None
        )

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
        received.clear()
        peer.wait_for(lambda: newest(1))
