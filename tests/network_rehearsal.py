"""Robots, motion capture and laptop on machines of their own, without multicast."""

import contextlib
import os
import subprocess
import sys
import time
from pathlib import Path

from network_namespaces import UDP_ONLY, Network
from rehearsal import Rehearsal
from ros_peer import Peer

RELAY = Path(__file__).parent / 'setcmas_expe' / 'scripts' / 'mocap_relay.py'
GOES = 0.07  # m/s


@contextlib.contextmanager
def running(command, log: Path):
    with log.open('wb') as file, subprocess.Popen(command, stdout=file, stderr=file) as process:
        try:
            yield process
        finally:
            process.terminate()


def roll_after_the_laptop_is_cut_off(nb_robots: int, domain: int, folder: Path) -> list[float]:
    """Return how far (m) each of the robots rolls."""
    os.environ.update(UDP_ONLY, ROS_AUTOMATIC_DISCOVERY_RANGE='SUBNET')
    with Network('mocap', 'laptop', 'robots') as network, contextlib.ExitStack() as stack:
        addresses = network.addresses
        lab = folder / 'lab.yaml'
        peers = f'{addresses["mocap"]}, {addresses["robots"]}'
        lab.write_text(f'network: {{static_peers: [{peers}]}}')
        # Its motion capture is of another kind, so that robots and poses are on two machines.
        robots = [sys.executable, '-m', 'setcmas_expe.emulation.emulated_lab', '--mocap', 'vicon']
        robots += ['--nb-robots', str(nb_robots)]
        mocap = ['env', f'ROS_STATIC_PEERS={addresses["robots"]}']  # it sees the truth there
        mocap += [sys.executable, str(RELAY), str(nb_robots)]
        for machine, command in (('robots', robots), ('mocap', mocap)):
            command = network.command(machine, command)
            stack.enter_context(running(command, folder / f'{machine}.txt'))
        with network.on('robots'):
            peer = stack.enter_context(Peer(domain))
        experiment = Rehearsal(
            peer,
            folder,
            *('--vnom', '0.1', '--lab', str(lab)),
            nb_robots=nb_robots,
            before=network.command('laptop', []),
            lab=(),
        )
        stack.enter_context(experiment)
        experiment.let_go(GOES)
        network.cut('laptop')
        fault = time.time()  # the newest truth may be old: a busy peer lags behind
        return [experiment.wait_for_stop(fault, robot).metres for robot in experiment.truth]
