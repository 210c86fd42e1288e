"""Measures how far a rogue drives a robot in an emergency stop, whose base hears anybody.

It commands the robot and asks for its motors, again and again; a guard of its own does the
opposite. Run in the environment that setcmas is installed in, on a quiet machine:

    python benchmarks/rogue.py [--repeat 3] [--seconds 5]
"""

import argparse
import contextlib
import itertools
import os
import subprocess
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / 'tests'))
os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'

from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import TwistStamped
from quick_option import parsed
from rehearsal import watch
from ros_domain import reserved_domain
from ros_peer import Peer, twist_stamped
from std_msgs.msg import Bool
from std_srvs.srv import SetBool
from tabulate import tabulate

from setcmas_simu.ros import qos

LAB = [sys.executable, '-m', 'setcmas_expe.emulation.emulated_lab', '--without-guard']
GUARD = [sys.executable, '-m', 'setcmas_expe.guard.guard_node', '--ros-args', '-r', '__ns:=/tb3_1']
RATES_HZ = ((20, 0), (20, 20), (50, 50), (100, 60), (100, 100), (200, 200))
SPEED_M_S = 0.2


def drive(domain, command_hz, motors_hz):
    """Command robot 1 and ask for its motors until the process is ended."""
    with Peer(domain) as rogue:
        commands = rogue.publisher(TwistStamped, '/tb3_1/cmd_vel')
        motors = rogue.node.create_client(SetBool, '/tb3_1/motor_power')
        rogue.wait_for(motors.service_is_ready)
        due = [(time.monotonic() + n / 1000, hz) for n, hz in enumerate((command_hz, motors_hz))]
        while True:
            for index, (at, hz) in enumerate(due):
                if hz and time.monotonic() >= at:
                    due[index] = (at + 1.0 / hz, hz)
                    if index == 0:
                        commands.publish(twist_stamped(SPEED_M_S, 0.0))
                        continue
                    with motors.handle:
                        motors.handle.send_request(SetBool.Request(data=True))
                        motors.handle.take_response(SetBool.Response)
            time.sleep(0.0005)


def way(rates, seconds):
    """Return how far (m) the robot rolls while a rogue drives it."""
    quiet = {'stdout': subprocess.DEVNULL, 'stderr': subprocess.DEVNULL}
    with reserved_domain() as domain, contextlib.ExitStack() as stack:
        os.environ['ROS_DOMAIN_ID'] = str(domain)

        def start(*command):
            process = stack.enter_context(subprocess.Popen(command, **quiet))
            stack.callback(process.terminate)

        start(*LAB)
        start(*GUARD)
        peer = stack.enter_context(Peer(domain))
        truth = watch(peer, 1)
        reports = peer.listen(DiagnosticStatus, '/tb3_1/guard_state')
        stop = peer.publisher(Bool, '/emergency_stop', qos=qos.LATCHED)
        stop.publish(Bool(data=True))
        peer.wait_for(lambda: reports and reports[-1].message == 'emergency stop')
        start(sys.executable, __file__, '--drive', str(domain), *map(str, rates))
        peer.wait_for(lambda: peer.node.count_publishers('/tb3_1/cmd_vel') > 1)
        peer.spin(1.0)
        begin = len(truth)
        peer.spin(seconds)
        return sum(
            abs(later.V) * (later.stamp - sooner.stamp)
            for sooner, later in itertools.pairwise(truth[begin:])
        )


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--repeat', type=int, default=3)
    parser.add_argument('--seconds', type=float, default=5.0)
    parser.add_argument('--drive', type=int, nargs=3, help=argparse.SUPPRESS)
    args = parsed(parser, repeat=1, seconds=1.0)
    if args.drive:
        drive(*args.drive)
    rows = []
    for rates in RATES_HZ:
        found = [way(rates, args.seconds) for _ in range(args.repeat)]
        rows.append((*rates, f'{min(found):.2f} to {max(found):.2f}'))
    columns = ('commands (1/s)', 'motor requests (1/s)', f'rolled in {args.seconds:g} s (m)')
    print(tabulate(rows, columns, tablefmt='github', disable_numparse=True))


if __name__ == '__main__':
    main()
