"""Experiments whose robots, laptop and rogue are on machines of their own, without multicast."""

import contextlib
import itertools
import os
import re
import subprocess
import sys
import time
from pathlib import Path

from network_namespaces import UDP_ONLY, Network
from rehearsal import POSES, Rehearsal
from ros_peer import Peer

TESTS = Path(__file__).parent
LAB = [sys.executable, '-m', 'setcmas_expe.emulation.emulated_lab', '--nb-robots', '2', *POSES]
ROGUE = [sys.executable, str(TESTS / 'setcmas_expe' / 'scripts' / 'rogue.py')]
SLOW = ('--vnom', '0.1')  # so that a busy machine has twice the time for the same way
UNPROVED = (*SLOW, '--without-motion-check')
GOES = 0.07  # m/s


@contextlib.contextmanager
def running(command, log: Path):
    with log.open('wb') as file, subprocess.Popen(command, stdout=file, stderr=file) as process:
        try:
            yield process
        finally:
            process.terminate()


@contextlib.contextmanager
def over_a_network(domain: int, folder: Path, *options: str):
    """Yield an experiment on the machine 'laptop', whose robots are on 'robots'."""
    os.environ.update(UDP_ONLY, ROS_AUTOMATIC_DISCOVERY_RANGE='SUBNET')
    with Network('robots', 'laptop', 'rogue') as network, contextlib.ExitStack() as stack:
        lab = folder / 'lab.yaml'
        lab.write_text(f'network: {{static_peers: [{network.addresses["robots"]}]}}')
        robots = network.command('robots', LAB)
        stack.enter_context(running(robots, folder / 'robots.txt'))
        with network.on('robots'):
            peer = stack.enter_context(Peer(domain))
        laptop = network.command('laptop', [])
        experiment = Rehearsal(peer, folder, '--lab', str(lab), *options, before=laptop, lab=())
        experiment.network = network
        yield stack.enter_context(experiment)


def roll_after_the_laptop_is_cut_off(domain: int, folder: Path) -> list[float]:
    """Return how far (m) each of the robots rolls."""
    with over_a_network(domain, folder, *SLOW) as experiment:
        experiment.let_go(GOES)
        experiment.network.cut('laptop')
        fault = time.time()  # the newest truth may be old: a busy peer lags behind
        return [experiment.wait_for_stop(fault, robot).metres for robot in experiment.truth]


@contextlib.contextmanager
def rogue_running(experiment: Rehearsal, folder: Path, *arguments: str):
    """Yield the process of a rogue that is on the network, from a machine of its own."""
    peers = 'ROS_STATIC_PEERS=' + ';'.join(experiment.network.addresses.values())
    command = experiment.network.command('rogue', ['env', peers, *ROGUE, *arguments])
    log = folder / 'rogue.txt'
    with running(command, log) as rogue:
        experiment.peer.wait_for(lambda: 'drives' in log.read_text())
        yield rogue


def way_while_starts_are_pressed(experiment: Rehearsal) -> float:
    """Return how far (m) robot 1 goes while a person tries to start it."""
    begin = experiment.way()
    for _ in range(3):
        experiment.press('s')
        experiment.peer.spin(1.5)
    return experiment.way() - begin


def wait_until_it_goes(experiment: Rehearsal) -> None:
    """Release stops, and start robots, until robot 1 has gone on."""
    begin = experiment.way()
    for key in itertools.cycle('RRs'):
        if experiment.way() > begin + 0.05:
            return
        experiment.press(key)
        experiment.peer.spin(1.5)


def ways_past_a_rogue(domain: int, folder: Path) -> tuple[float, float]:
    """Return how far (m) a robot goes: when a rogue comes, and while it is there."""
    with over_a_network(domain, folder, *UNPROVED) as experiment:
        with rogue_running(experiment, folder) as rogue:
            experiment.peer.wait_for(lambda: 'several' in experiment.output())
            pressed = way_while_starts_are_pressed(experiment)
            rogue.kill()
        wait_until_it_goes(experiment)
        begin = experiment.way()
        with rogue_running(experiment, folder):
            experiment.wait_for_stop(time.time())
            rolled = experiment.way() - begin
            return rolled, pressed + way_while_starts_are_pressed(experiment)


def way_behind_a_firewall(domain: int, folder: Path) -> tuple[float, str]:
    """Switch on the firewall of the docs while a rogue drives a robot past its guard.

    Returns:
        How far (m) the robot then goes while it is paused, and what the experiment said before.
        It has obeyed the experiment in between.
    """
    page = (TESTS.parent / 'docs' / 'lab_setup.md').read_text()
    rules = re.search(r'```nft\n(.*?)```', page, re.DOTALL)[1]
    with (
        over_a_network(domain, folder, *UNPROVED) as experiment,
        rogue_running(experiment, folder, 'guarded') as rogue,
    ):
        wait_for, output, network = experiment.peer.wait_for, experiment.output, experiment.network
        wait_for(lambda: 'past its guard)' in output() and 'SWITCH THE ROBOT OFF' in output())
        experiment.press('\x1b')
        wait_for(lambda: 'STOP by Esc' in output())
        said = output()
        ours = ', '.join(network.addresses[name] for name in ('robots', 'laptop'))
        rules = re.sub(r'saddr {.*?}', f'saddr {{ {ours} }}', rules)
        for machine in ('robots', 'laptop'):
            command = network.command(machine, ['nft', '-f', '-'])
            subprocess.run(command, input=rules, text=True, check=True)
        wait_until_it_goes(experiment)  # once the rogue counts as gone
        experiment.press(' ')
        wait_for(lambda: 'paused: by space bar' in output())
        experiment.peer.spin(1.0)
        begin = experiment.way()
        experiment.peer.spin(2.0)
        assert rogue.poll() is None
        return experiment.way() - begin, said
