"""Motion capture, laptop and robots on machines of their own, without multicast."""

import contextlib
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip('rclpy')

from network_namespaces import UDP_ONLY, Network
from rehearsal import Rehearsal
from ros_peer import Peer

NB_ROBOTS = 8
WAY = 0.16  # m
GOES = 0.07  # m/s
RELAY = Path(__file__).parent / 'scripts' / 'mocap_relay.py'
PORT = 11811


@pytest.fixture
def network():
    with Network('mocap', 'laptop', 'robots') as network:
        yield network


@contextlib.contextmanager
def running(command, log: Path):
    with log.open('wb') as file, subprocess.Popen(command, stdout=file, stderr=file) as process:
        try:
            yield process
        finally:
            process.terminate()


@pytest.mark.parametrize('way', ['static peers', 'discovery server'])
def test_eight_robots_over_a_network(way, network, domain, monkeypatch, tmp_path):
    for name, value in UDP_ONLY.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'SUBNET')
    laptop, addresses = network.addresses['laptop'], network.addresses
    lab = tmp_path / 'lab.yaml'
    if way == 'static peers':
        lab.write_text(f'network: {{static_peers: [{addresses["mocap"]}, {addresses["robots"]}]}}')
    else:
        lab.write_text(f"network: {{discovery_server: '{laptop}:{PORT}'}}")
        monkeypatch.setenv('ROS_DISCOVERY_SERVER', f'{laptop}:{PORT}')
    # Its motion capture is of another kind, so that robots and poses are on two machines.
    robots_command = [sys.executable, '-m', 'setcmas_expe.nodes.emulated_lab', '--mocap', 'vicon']
    robots_command += ['--nb-robots', str(NB_ROBOTS)]
    mocap_command = ['env', f'ROS_STATIC_PEERS={addresses["robots"]}']  # it sees the truth there
    mocap_command += [sys.executable, str(RELAY), str(NB_ROBOTS)]
    fastdds = str(Path(sys.executable).parent / 'fastdds')
    server_command = [fastdds, 'discovery', '--server-id', '0', '-l', laptop, '-p', str(PORT)]
    with contextlib.ExitStack() as stack:
        if way == 'discovery server':
            command = network.command('laptop', server_command)
            stack.enter_context(running(command, tmp_path / 'server.txt'))
        for machine, command in (('robots', robots_command), ('mocap', mocap_command)):
            command = network.command(machine, command)
            stack.enter_context(running(command, tmp_path / f'{machine}.txt'))
        with network.on('robots'):
            robots = stack.enter_context(Peer(domain))
        monkeypatch.delenv('ROS_DISCOVERY_SERVER', raising=False)  # the lab file has it
        experiment = stack.enter_context(
            Rehearsal(
                robots,
                tmp_path,
                *('--vnom', '0.1', '--lab', str(lab)),
                nb_robots=NB_ROBOTS,
                before=network.command('laptop', []),
                lab=(),
            )
        )
        experiment.let_go(GOES)

        fault = experiment.truth[1][-1].stamp
        network.cut('laptop')

        stops = [experiment.wait_for_stop(fault, robot) for robot in experiment.truth]
        assert max(stop.metres for stop in stops) < WAY
