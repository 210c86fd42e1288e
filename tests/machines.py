"""A fleet over three machines of a network, of which one loses its link for a while."""

import contextlib
import math
import os
import time
from pathlib import Path

from nav_msgs.msg import Odometry
from network_namespaces import Network
from processes import CTRL, SIMU, Process
from ros_peer import Peer, position

LEFT, RIGHT = (1, 2), (3, 4)
FLEET = (*LEFT, *RIGHT)
COMMAND_TIMEOUT_S = 0.5
SPEED = 0.2  # m/s
LEASE_S = 5.0  # of config/fastdds_network.xml
LAW = f"""
import math
def control(robotNo, nbRobots, poses, t):
    return {SPEED} * math.cos(0.3 * t), {SPEED} * math.sin(0.3 * t)
"""


class ThreeMachines:
    """Robots 1 and 2 on one machine, 3 and 4 on another, their controllers on the third."""

    def __init__(self, domain: int, folder: Path, stack: contextlib.ExitStack) -> None:
        self._folder, self._stack = folder, stack
        self.network = stack.enter_context(Network('left', 'right', 'laptop'))
        os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'SUBNET'
        os.environ['ROS_STATIC_PEERS'] = ';'.join(self.network.addresses.values())
        with self.network.on('laptop'):
            self.peer = stack.enter_context(Peer(domain))
        self.odometry = {robot: self.peer.odometry(robot) for robot in FLEET}
        (folder / 'law.py').write_text(LAW)
        for machine, (first, last) in (('left', LEFT), ('right', RIGHT)):
            part = ['--nb-robots', str(len(FLEET)), '--robots', f'{first}-{last}']
            self._start(machine, *SIMU, *part, '--cmd-timeout', str(COMMAND_TIMEOUT_S))
        self._start('laptop', *CTRL, '--algo', 'law.py', '--nb-robots', str(len(FLEET)))

    def _start(self, machine: str, *command: str) -> None:
        number = len(list(self._folder.iterdir()))
        log = self._folder / f'{number}_{machine}.txt'
        on_it = self.network.command(machine, command)
        process = Process(on_it, log, self._folder, dict(os.environ))
        self._stack.callback(process.kill_group)

    def sent_since(self, moment: float, robot: int) -> list[Odometry]:
        """Return the odometry that a robot sent after a moment (s since 1970).

        By its stamps: after a stall of this process, older messages are still to be taken.
        """
        return [message for message in self.odometry[robot] if stamp(message) > moment]

    def wait_until_all_go(self) -> None:
        """Wait until every robot moves, by messages from now on."""
        now = time.time()
        self.peer.wait_for(lambda: all(moves(self.sent_since(now, robot)) for robot in FLEET))


def stamp(message) -> float:
    return message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec


def moves(odometry) -> bool:
    return len(odometry) > 1 and math.dist(position(odometry[0]), position(odometry[-1])) > 0.02


def recover_from_a_cut_link(domain: int, folder: Path) -> None:
    """Cut a machine off for longer than Fast DDS remembers it: its robots stop, and go on."""
    with contextlib.ExitStack() as stack:
        machines = ThreeMachines(domain, folder, stack)
        machines.wait_until_all_go()
        machines.network.cut('left')
        cut = time.time()
        machines.peer.spin(1.5 * LEASE_S)
        assert all(moves(machines.sent_since(cut, robot)) for robot in RIGHT)
        assert not any(machines.sent_since(cut, robot) for robot in LEFT)
        before = {robot: position(machines.odometry[robot][-1]) for robot in LEFT}

        restored = time.time()
        machines.network.restore('left')
        machines.peer.wait_for(lambda: all(machines.sent_since(restored, one) for one in LEFT))
        going = COMMAND_TIMEOUT_S + 1 + time.time() - restored  # it may be commanded before that
        for robot, place in before.items():
            rolled = math.dist(place, position(machines.sent_since(restored, robot)[0]))
            assert rolled < SPEED * going, f'tb3_{robot} rolled {rolled} m'
        machines.wait_until_all_go()
