import math

import numpy as np
import pytest

from setcmas_tools import simulate
from setcmas_tools.compare.latency import (
    BRIDGE,
    CAMERA,
    LAW,
    WAY,
    Latency,
    Offset,
    Part,
    RobotTimes,
    bearable_delay,
    clock_offsets,
    fleet_latency,
    parts_of,
)

START = 1_800_000_000.0
AGES = {CAMERA: 0.030, BRIDGE: 0.040, LAW: 0.025, WAY: 0.060}
NETWORK_S = 0.002
AHEAD_S = 3.0


@pytest.fixture
def times():
    """A minute on two machines: that of the robot and the cameras is 3 s ahead."""
    found = RobotTimes(clocks={'camera': 'robot', 'robot': 'robot'})
    chance = np.random.default_rng(1)
    for i in range(300):
        pose = START + i / 5
        called = pose + AGES[BRIDGE]
        wanted = called + AGES[LAW]
        guarded = wanted + AGES[WAY] + AHEAD_S
        command = tuple(chance.uniform(0.1, 0.2, 2).tolist())
        back = guarded - AHEAD_S + NETWORK_S * chance.uniform(1.0, 2.0)
        way = AHEAD_S + NETWORK_S * chance.uniform(1.0, 2.0)
        age = AGES[CAMERA] - AHEAD_S
        found.cameras.append((pose, age, age + 0.005))
        found.laws.append((called, pose))
        found.wanted.append((wanted, *command))
        found.guarded.append((back, guarded, *command))
        found.ways.append((back, way))
    return found


def test_each_part_is_found_although_the_clocks_are_3_s_apart(times):
    parts = parts_of(times)

    for name, age in AGES.items():
        assert parts[name].median_s == pytest.approx(age, abs=0.002)
    assert parts[CAMERA].worst_s == pytest.approx(AGES[CAMERA] + 0.005, abs=0.002)
    ahead, doubt = clock_offsets(times)(START + 30)
    assert abs(ahead - AHEAD_S) <= doubt < 1.1 * NETWORK_S


@pytest.mark.parametrize(
    ('change', 'unknown'),
    [
        pytest.param({'ways': []}, {CAMERA, WAY}, id='guard without a report'),
        pytest.param({'clocks': {'robot': 'robot'}}, {CAMERA}, id='cameras on a third machine'),
        pytest.param({'clocks': {}, 'ways': []}, {CAMERA, WAY}, id='machines unknown'),
        pytest.param({'guarded': []}, {CAMERA, WAY}, id='no guard'),
        pytest.param({'laws': []}, {BRIDGE, LAW}, id='laws of another program'),
        pytest.param({'cameras': []}, {CAMERA}, id='samples without a stamp'),
        # The clocks are not on one machine, whatever the addresses say.
        pytest.param(
            {'clocks': {'camera': 'bridge', 'robot': 'robot'}}, {CAMERA}, id='false machine'
        ),
    ],
)
def test_what_cannot_be_known_is_unknown(times, change, unknown):
    for name, value in change.items():
        setattr(times, name, value)

    assert {name for name, part in parts_of(times).items() if part is None} == unknown


def test_a_base_that_gets_no_stamps_leaves_its_clock_unknown(times):
    times.guarded = [(at, 0.0, *command) for at, _, *command in times.guarded]

    assert {name for name, part in parts_of(times).items() if part is None} == {CAMERA, WAY}


def test_slow_messages_leave_clocks_unknown(times):
    times.ways = [(at, way + 0.05) for at, way in times.ways]

    assert clock_offsets(times)(START + 30) is None
    assert parts_of(times)[WAY] is None


def test_on_one_machine_no_clock_is_aligned(times):
    times.clocks = {'camera': 'bridge', 'robot': 'bridge'}
    times.guarded = [(at, stamp - AHEAD_S, *command) for at, stamp, *command in times.guarded]
    times.cameras = [(at, *(age + AHEAD_S for age in ages)) for at, *ages in times.cameras]

    parts = parts_of(times)
    for name, age in AGES.items():
        assert parts[name].median_s == pytest.approx(age, abs=1e-5)


def test_lines_name_what_is_unknown():
    clocks = {1: Offset(-3.00004, 0.0002)}
    found = Latency({1: {LAW: Part(0.002, 0.0274), WAY: None}}, clocks, 0.5)

    assert found.lines() == [
        'latency in ms, median (worst):',
        '  tb3_1: camera to bridge unknown, bridge to law unknown, law 2 (27), '
        'law to base unknown, base to motion unknown',
        '  the clock of tb3_1 is 3.0000 s behind, ± 0.2 ms',
        '  delay margin of the law: 500 ms (single integrators on a complete graph: pi / (2 K))',
    ]


task = 'consensus'


def halted(robotNo, nbRobots, poses, t):
    vx, vy = -np.tanh(5.0 * (poses[:2, robotNo - 1] - poses[:2].mean(axis=1)))
    return (vx, vy) if t < 10.0 else (0.0, 0.0)


def test_delay_that_consensus_bears():
    run = simulate('consensus', 4, 30.0, filter='barrier', limits='burger')  # its rate is 0.15

    assert bearable_delay(run) == pytest.approx(math.pi / (2 * 0.5), rel=0.01)
    other = simulate(halted, 4, 30.0)
    assert other.references.task == 'consensus'
    assert bearable_delay(other) is None  # it is not linear
    assert bearable_delay(simulate('nav_wp', 2, 5.0)) is None
    assert fleet_latency(run) is None  # a simulation
