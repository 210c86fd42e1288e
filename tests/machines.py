"""A fleet over three machines of a network: its simulators, its controllers, and their faults."""

import contextlib
import math
import os
import signal
import time
from pathlib import Path

from nav_msgs.msg import Odometry
from network_namespaces import Network
from processes import CTRL, SIMU, Process
from ros_peer import Peer, position
from sensor_msgs.msg import TimeReference

from setcmas_simu.fleet import topics
from setcmas_simu.fleet.fleet import start_poses

LEFT, RIGHT = range(1, 5), range(5, 9)
FLEET = [*LEFT, *RIGHT]
COMMAND_TIMEOUT_S = 0.5
SPEED = 0.2  # m/s
SAME_T_S = 0.05
LEASE_S = 5.0  # of config/fastdds_network.xml
LAW = f"""
import math
def control(robotNo, nbRobots, poses, t):
    return {SPEED} * math.cos(0.3 * t), {SPEED} * math.sin(0.3 * t)
"""


def seconds(time_message) -> float:
    return time_message.sec + 1e-9 * time_message.nanosec


def stamp(message) -> float:
    return seconds(message.header.stamp)


class ThreeMachines:
    """Robots 1 to 4 on one machine, 5 to 8 on another, controllers on the third."""

    def __init__(self, domain: int, folder: Path) -> None:
        self._folder = folder
        self._processes: list[Process] = []
        self._stack = contextlib.ExitStack()
        (folder / 'law.py').write_text(LAW)
        self.network = self._stack.enter_context(Network('left', 'right', 'laptop'))
        self._stack.callback(self._end)
        os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'SUBNET'
        os.environ['ROS_STATIC_PEERS'] = ';'.join(self.network.addresses.values())
        with self.network.on('laptop'):
            self.peer = self._stack.enter_context(Peer(domain))
        self.odometry = {robot: self.peer.odometry(robot) for robot in FLEET}
        self.commands = {robot: self.peer.cmd_vel(robot) for robot in FLEET}
        self.times = self.peer.listen(TimeReference, topics.FLEET_TIME)

    def _end(self) -> None:
        for process in self._processes:
            process.kill_group()

    def start(self, machine: str, *command: str) -> Process:
        log = self._folder / f'{len(self._processes)}.txt'
        command = self.network.command(machine, command)
        process = Process(command, log, self._folder, dict(os.environ))
        self._processes.append(process)
        return process

    def simulate(self, machine: str, robots) -> Process:
        options = ['--cmd-timeout', str(COMMAND_TIMEOUT_S)]
        return self.start(machine, *SIMU, *part(robots), *options)

    def control(self, robots) -> Process:
        return self.start('laptop', *CTRL, '--algo', 'law.py', *part(robots))

    def t(self, robots) -> float:
        """Return t of a controller, by its newest message; as of now."""
        sent = (one for one in self.times[::-1] if one.source.startswith(name(robots)))
        newest = next(sent, None)
        if newest is None:
            return math.nan
        return time.time() - stamp(newest) + seconds(newest.time_ref)

    def state(self) -> str:
        """Return for each robot its number of messages and whether it moves, and all outputs."""
        robots = {robot: (len(got), moves(got)) for robot, got in self.odometry.items()}
        return '\n--\n'.join([str(robots), *(one.output() for one in self._processes)])

    def sent_since(self, moment: float, robot: int) -> list[Odometry]:
        """Return the odometry that a robot sent after a moment (s since 1970).

        By its stamps: after a stall of this process, older messages are still to be taken.
        """
        return [message for message in self.odometry[robot] if stamp(message) > moment]

    def wait_until_all_go(self) -> None:
        """Wait until every robot moves, by messages from now on, and t is the same everywhere."""
        now = time.time()
        self.peer.wait_for(lambda: all(moves(self.sent_since(now, robot)) for robot in FLEET))
        self.peer.wait_for(lambda: abs(self.t(LEFT) - self.t(RIGHT)) < SAME_T_S)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._stack.close()


def part(robots) -> list[str]:
    return ['--nb-robots', str(len(FLEET)), '--robots', name(robots).split()[1]]


def name(robots) -> str:
    return f'robots {robots[0]}-{robots[-1]}'


def moves(odometry) -> bool:
    return len(odometry) > 1 and math.dist(position(odometry[0]), position(odometry[-1])) > 0.02


def begin(machines: ThreeMachines):
    simulators = machines.simulate('left', LEFT), machines.simulate('right', RIGHT)
    controllers = machines.control(LEFT), machines.control(RIGHT)
    try:
        machines.wait_until_all_go()
    except AssertionError:
        raise AssertionError(machines.state()) from None
    return simulators, controllers


def recover(domain: int, folder: Path) -> None:
    """Start the fleet, and check that it recovers from each fault by itself."""
    with ThreeMachines(domain, folder) as machines:
        (_, right), (controller, _) = begin(machines)
        recover_from_a_cut_link(machines)
        recover_from_a_killed_simulator(machines, right)
        recover_from_a_killed_controller(machines, controller)


def recover_from_a_cut_link(machines: ThreeMachines) -> None:
    t = machines.t(LEFT)
    machines.network.cut('left')
    cut = time.time()
    machines.peer.spin(1.5 * LEASE_S)
    assert all(moves(machines.sent_since(cut, robot)) for robot in RIGHT)
    assert not any(machines.sent_since(cut, robot) for robot in LEFT)
    before = {robot: position(machines.odometry[robot][-1]) for robot in LEFT}
    restored = time.time()
    machines.network.restore('left')
    machines.peer.wait_for(lambda: all(machines.sent_since(restored, robot) for robot in LEFT))
    going = COMMAND_TIMEOUT_S + 1 + time.time() - restored  # it may be commanded before that
    for robot, place in before.items():
        rolled = math.dist(place, position(machines.sent_since(restored, robot)[0]))
        assert rolled < SPEED * going, f'tb3_{robot} rolled {rolled} m'
    machines.wait_until_all_go()
    assert machines.t(LEFT) > t + LEASE_S


def recover_from_a_killed_simulator(machines: ThreeMachines, simulator: Process) -> None:
    simulator.end(signal.SIGKILL)
    t = machines.t(RIGHT)
    begin = time.time()
    machines.simulate('right', RIGHT)
    machines.peer.wait_for(lambda: all(machines.sent_since(begin, robot) for robot in RIGHT))
    farthest = SPEED * (time.time() - begin) + 0.1
    for robot, start in zip(RIGHT, start_poses(len(FLEET)).T[4:], strict=True):
        way = math.dist(start[:2], position(machines.sent_since(begin, robot)[0]))
        assert way < farthest, f'tb3_{robot} is {way} m from its start'
    machines.wait_until_all_go()
    assert machines.t(RIGHT) > t


def recover_from_a_killed_controller(machines: ThreeMachines, controller: Process) -> None:
    controller.end(signal.SIGKILL)
    t = machines.t(RIGHT)
    machines.peer.wait_for(
        lambda: (
            all(is_at_rest(machines.odometry[robot][-1]) for robot in LEFT)
            and not any(is_at_rest(machines.odometry[robot][-1]) for robot in RIGHT)
        )
    )
    machines.control(LEFT)
    machines.wait_until_all_go()
    assert machines.t(LEFT) > t


def is_at_rest(odometry) -> bool:
    return odometry.twist.twist.linear.x == odometry.twist.twist.angular.z == 0
