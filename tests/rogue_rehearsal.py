"""A foreign robot with its guard, the laptop, and a foreign rogue, on machines of their own."""

import contextlib
import os
import sys
import time
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


def ways_past_a_rogue(domain: int, folder: Path) -> tuple[float, float, float]:
    """Return how far (m) a robot goes: beside a rogue, without it, and once it is there again."""
    with Network('robot', 'laptop', 'rogue') as network, contextlib.ExitStack() as stack:
        addresses = network.addresses.values()
        peers = ''.join(f'<Peer address="{address}"/>' for address in addresses)
        os.environ.update(
            UDP_ONLY,
            ROS_DOMAIN_ID=str(domain),
            ROS_AUTOMATIC_DISCOVERY_RANGE='SUBNET',
            ROS_STATIC_PEERS=';'.join(addresses),
            CYCLONEDDS_URI=CYCLONE.format(peers=peers),
        )

        def start(machine: str, *command: str) -> Process:
            number = len(list(folder.iterdir()))
            log = folder / f'{number}_{machine}.txt'
            process = Process(network.command(machine, command), log, folder, dict(os.environ))
            stack.callback(process.kill_group)
            return process

        def foreign(machine: str, script: str, *arguments: str) -> Process:
            return start(machine, sys.executable, str(SCRIPTS / script), str(domain), *arguments)

        robot = foreign('robot', 'foreign_robot.py', 'TwistStamped', 'cmd_vel_guarded')
        start('robot', *GUARD)
        rogue = foreign('rogue', 'foreign_rogue.py')
        with network.on('robot'):
            peer = stack.enter_context(Peer(domain))
        experiment = Rehearsal(
            peer,
            folder,
            *('--mocap', 'vrpn'),
            nb_robots=1,
            before=network.command('laptop', []),
            lab=(),
        )
        stack.enter_context(experiment)
        peer.wait_for(lambda: 'several' in experiment.output())
        press_start(experiment)
        beside = way(robot)

        rogue.kill_group()
        peer.wait_for(lambda: press_start(experiment) or way(robot) > beside + 0.05)
        alone = way(robot) - beside
        rogue = foreign('rogue', 'foreign_rogue.py')
        rogue.wait_for_output('drives')
        before = way(robot)
        time.sleep(1.0)
        stopped = way(robot)
        press_start(experiment)
        return max(beside, way(robot) - stopped), alone, stopped - before


def press_start(experiment: Rehearsal) -> None:
    for _ in range(3):
        experiment.press('s')
        time.sleep(1.5)


def way(robot: Process) -> float:
    """Return how far (m) a robot has come."""
    told = [line for line in robot.output().split() if line != 'goes']
    return float(told[-1]) if told else 0.0
