"""A foreign robot with its guard, the laptop, and a foreign rogue, on machines of their own."""

import contextlib
import os
import re
import subprocess
import sys
import time
from functools import partial
from pathlib import Path

from network_namespaces import UDP_ONLY, Network
from processes import Process
from rehearsal import Rehearsal
from ros_peer import Peer

SCRIPTS = Path(__file__).parent / 'setcmas_expe' / 'scripts'
GUARD = [sys.executable, '-m', 'setcmas_expe.guard.guard_node', '--ros-args', '-r', '__ns:=/tb3_1']
CYCLONE = """
<CycloneDDS><Domain>
  <General>
    <AllowMulticast>false</AllowMulticast>
    <Interfaces><NetworkInterface name="eth0"/></Interfaces>
  </General>
  <Discovery>
    <ParticipantIndex>auto</ParticipantIndex>
    <MaxAutoParticipantIndex>16</MaxAutoParticipantIndex>
    <Peers>{peers}</Peers>
  </Discovery>
</Domain></CycloneDDS>"""
STANDS_M = 0.005


class RogueRehearsal:
    """A foreign robot with its guard, an experiment on the laptop, and a rogue.

    Attributes:
        network: The machines 'robot', 'laptop' and 'rogue'.
        robot: The robot's base and its motion capture.
        experiment: The experiment.
    """

    def __init__(self, domain: int, folder: Path, stack: contextlib.ExitStack, *rogue: str):
        """Start everything; `rogue` are further arguments of the rogue."""
        self._domain, self._folder, self._stack = domain, folder, stack
        self._arguments = rogue
        self.network = network = stack.enter_context(Network('robot', 'laptop', 'rogue'))
        addresses = network.addresses.values()
        peers = ''.join(f'<Peer address="{address}"/>' for address in addresses)
        os.environ.update(
            UDP_ONLY,
            ROS_DOMAIN_ID=str(domain),
            ROS_AUTOMATIC_DISCOVERY_RANGE='SUBNET',
            ROS_STATIC_PEERS=';'.join(addresses),
            CYCLONEDDS_URI=CYCLONE.format(peers=peers),
        )
        self.robot = self._foreign('robot', 'foreign_robot.py', 'TwistStamped', 'cmd_vel_guarded')
        self._start('robot', *GUARD)
        self.rogue = self.start_rogue()
        with network.on('robot'):
            self.peer = stack.enter_context(Peer(domain))
        before = network.command('laptop', [])
        lab = ('--mocap', 'vrpn')
        self.experiment = stack.enter_context(
            Rehearsal(self.peer, folder, *lab, nb_robots=1, before=before, lab=())
        )

    def start_rogue(self) -> Process:
        return self._foreign('rogue', 'foreign_rogue.py', *self._arguments)

    def wait_until_it_drives(self, metres: float) -> float:
        """Press start until the robot has gone on by a distance; returns how far it went."""
        begin = way(self.robot)
        self.peer.wait_for(
            lambda: press_start(self.experiment) or way(self.robot) > begin + metres
        )
        return way(self.robot) - begin

    def _start(self, machine: str, *command: str) -> Process:
        number = len(list(self._folder.iterdir()))
        log = self._folder / f'{number}_{machine}.txt'
        on_it = self.network.command(machine, command)
        process = Process(on_it, log, self._folder, dict(os.environ))
        self._stack.callback(process.kill_group)
        return process

    def _foreign(self, machine: str, script: str, *arguments: str) -> Process:
        path = str(SCRIPTS / script)
        return self._start(machine, sys.executable, path, str(self._domain), *arguments)


def ways_past_a_rogue(domain: int, folder: Path) -> tuple[float, float, float]:
    """Return how far (m) a robot goes: beside a rogue, without it, and once it is there again."""
    with contextlib.ExitStack() as stack:
        lab = RogueRehearsal(domain, folder, stack)
        lab.peer.wait_for(lambda: 'several' in lab.experiment.output())
        press_start(lab.experiment)
        beside = way(lab.robot)

        lab.rogue.kill_group()
        alone = lab.wait_until_it_drives(0.05)
        rogue = lab.start_rogue()
        rogue.wait_for_output('drives')
        before = way(lab.robot)
        time.sleep(1.0)
        stopped = way(lab.robot)
        press_start(lab.experiment)
        return max(beside, way(lab.robot) - stopped), alone, stopped - before


def ways_behind_a_firewall(domain: int, folder: Path) -> tuple[float, float, str]:
    """Switch the firewall of the docs on beside a rogue that drives a robot past its guard.

    Returns:
        How far (m) the rogue drove the robot before, how far the robot then goes while it is
        paused, and what the experiment said before. It has obeyed the experiment in between.
    """
    page = (Path(__file__).parents[1] / 'docs' / 'lab_setup.md').read_text()
    rules = re.search(r'```nft\n(.*?)```', page, re.DOTALL)[1]
    with contextlib.ExitStack() as stack:
        lab = RogueRehearsal(domain, folder, stack, 'guarded')
        lab.peer.wait_for(lambda: way(lab.robot) > 0.1)
        for text in ('past its guard)', 'SWITCH THE ROBOT OFF'):  # the terminal, and the bridge
            lab.peer.wait_for(partial(shows, lab.experiment, text))
        lab.experiment.press('\x1b')
        lab.peer.wait_for(partial(shows, lab.experiment, 'STOP by Esc'))
        driven, said = way(lab.robot), lab.experiment.output()
        ours = [lab.network.addresses[name] for name in ('robot', 'laptop')]
        rules = re.sub(r'saddr {.*?}', f'saddr {{ {", ".join(ours)} }}', rules)
        for machine in ('robot', 'laptop'):
            command = lab.network.command(machine, ['nft', '-f', '-'])
            subprocess.run(command, input=rules, text=True, check=True)
        lab.peer.wait_for(lambda: stands(lab.robot))  # until the rogue counts as gone
        begin = way(lab.robot)
        lab.peer.wait_for(
            lambda: (
                release(lab.experiment)
                or press_start(lab.experiment)
                or way(lab.robot) > begin + 0.05
            )
        )
        lab.experiment.press(' ')
        lab.peer.wait_for(lambda: 'paused: by space bar' in lab.experiment.output())
        time.sleep(1.0)
        begin = way(lab.robot)
        time.sleep(2.0)
        assert lab.rogue.popen.poll() is None
        return driven, way(lab.robot) - begin, said


def shows(experiment: Rehearsal, text: str) -> bool:
    return text in experiment.output()


def release(experiment: Rehearsal) -> None:
    """Release the stop; the rogue holds it until it counts as gone."""
    for _ in range(2):
        experiment.press('R')
        time.sleep(1.5)


def stands(robot: Process) -> bool:
    begin = way(robot)
    time.sleep(1.0)
    return way(robot) == begin


def press_start(experiment: Rehearsal) -> None:
    for _ in range(3):
        experiment.press('s')
        time.sleep(1.5)


def way(robot: Process) -> float:
    """Return how far (m) a robot has come."""
    told = [line for line in robot.output().split() if line != 'goes']
    return float(told[-1]) if told else 0.0
