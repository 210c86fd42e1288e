"""The nodes of a run, stepped one after another over real topics, go exactly as the offline run.

The last bit is promised where both have the same arithmetic; 1e-6 m, single precision of
velocities, is what differing conversions would show at once.
"""

import math

import numpy as np
import pytest

pytest.importorskip('rclpy')

from stepped_nodes import stepped_nodes

from setcmas_ctrl import si_to_uni
from setcmas_ctrl.laws.script_loader import ALGORITHMS
from setcmas_simu.robots import unicycle
from setcmas_tools import Scenario, simulate

WITHIN_M = 1e-6

EVENTS = {'event_triggered': True, 'threshold': 0.1}
RING = {'graph': 'ring', 'loss': 0.2, 'delay': 0.25, 'noise': 0.02, 'seed': 3}
CLOSE = {'random_poses': 'box=2x2,distance=0.6', 'filter': 'barrier', 'min_separation': 0.3}
ROOM = {'arena': (-2.0, 2.0, -2.0, 2.0), 'obstacles': 'disc 0.2 0.1 0.2'}
MIXED = {'model': '1:burger,2:car,3:omnidirectional', 'vnom': 0.2}


def backwards(velocity, pose, komega):
    vx, vy = velocity
    heading = pose[2] + math.pi
    error = math.remainder(math.atan2(vy, vx) - heading, 2 * math.pi)
    return -math.hypot(vx, vy), komega * error


SCENARIOS = {
    'events': EVENTS,
    'events of a law with messages': {'algo': 'velocity_alignment', **EVENTS},
    'events with the own state exact': {**EVENTS, 'own_state': 'exact'},
    'events at 20 Hz': {**EVENTS, 'robot_rate': 20.0, 'rate': 20.0, 'delay': 0.07},
    'events by what is received': {
        'algo': 'laplacian_consensus', 'set': {'K': 1.0}, 'event_triggered': True,
        'ctc': 'garcia_2013', 'graph': 'path', 'delay': 0.2, 'vnom': 5.0,
    },
    'events by what is measured': {
        'event_triggered': True, 'ctc': 'dimarogonas_2012', 'graph': 'ring', 'noise': 0.01,
    },
    'ring at 3/7 Hz': {**RING, 'rate': 3 / 7, 'duration': 8.0},
    'robots at 3/7 Hz': {'robot_rate': 3 / 7, 'rate': 3 / 7, 'duration': 14.0},
    'ring at 20 Hz': {**RING, 'rate': 20.0, 'robot_rate': 20.0},
    'range': {'range': 11.0, 'delay': 0.1},
    'filter in an arena': {**CLOSE, **ROOM},
    'filter with limits': {**CLOSE, **ROOM, 'accel': 0.5, 'limits': 'burger', 'rate': 10.0},
    'filter of events over a ring': {**CLOSE, **EVENTS, **RING},
    'si_to_uni of one\'s own': {'si_to_uni': backwards},
    'models': MIXED,
    'models with filter': {**CLOSE, 'model': '1:burger,2:omnidirectional', 'vnom': 0.2},
    'messages of rates that do not divide': {
        'algo': 'velocity_alignment', 'graph': 'path', 'rate': 7.0, 'robot_rate': 11.0,
    },
    'robots that are commanded rarely': {'rate': 0.5, 'cmd_timeout': 0.5, 'duration': 6.0},
}  # fmt: skip


def stepped(scenario, domain):
    with stepped_nodes(scenario, domain) as nodes:
        return nodes.run()


def sent_at(run):
    """Return at which steps each robot has sent its state in an offline run, shape (K + 1, N)."""
    rows = run.record.triggers
    return rows[np.lexsort((rows[:, 1], rows[:, 0])), 2].reshape(len(run.t), -1) == 1


@pytest.mark.parametrize('law', sorted(ALGORITHMS.plugins()))
def test_each_law_moves_its_robots_as_offline(law, domain):
    scenario = Scenario.of(law, nb_robots=4, duration=3.0)
    offline = simulate(scenario).poses

    assert np.ptp(offline, axis=0)[:2].max() > 0.01  # they move
    np.testing.assert_allclose(stepped(scenario, domain).poses, offline, atol=WITHIN_M, rtol=0)


@pytest.mark.parametrize('name', SCENARIOS)
def test_each_scenario_goes_as_offline(name, domain):
    given = {'algo': 'consensus', 'duration': 4.0, **SCENARIOS[name]}
    scenario = Scenario.of(given.pop('algo'), nb_robots=4, **given)
    offline, nodes = simulate(scenario), stepped(scenario, domain)

    assert np.ptp(offline.poses, axis=0)[:2].max() > 0.01
    np.testing.assert_allclose(nodes.poses, offline.poses, atol=WITHIN_M, rtol=0)
    if 'event_triggered' in given:
        sent = sent_at(offline)
        assert 0 < sent[1:].sum() < sent[1:].size
        np.testing.assert_array_equal(nodes.sent, sent)


def test_a_fleet_over_a_bad_network_goes_exactly_the_same_way_as_offline(domain):
    links = {'graph': 'ring', 'loss': 0.3, 'delay': 0.1, 'noise': 0.02}
    scenario = Scenario.of('consensus', nb_robots=20, duration=10.0, **links)

    assert np.array_equal(stepped(scenario, domain).poses, simulate(scenario).poses)


@pytest.mark.parametrize(
    ('module', 'name'), [(unicycle, 'step'), (si_to_uni, 'si_to_uni')], ids=['step', 'si_to_uni']
)
def test_an_edit_is_seen_offline_and_in_the_nodes(module, name, domain, monkeypatch):
    scenario = Scenario.of('consensus', nb_robots=2, duration=2.0)
    before = simulate(scenario).poses
    original = getattr(module, name)

    def half_as_fast(first, *others):
        if module is unicycle:  # first are the states, then V
            return original(first, 0.5 * others[0], *others[1:])
        return original(0.5 * np.asarray(first), *others)

    monkeypatch.setattr(module, name, half_as_fast)
    after = simulate(scenario).poses

    assert np.abs(after[-1, :2] - before[-1, :2]).max() > 0.1
    np.testing.assert_allclose(stepped(scenario, domain).poses, after, atol=WITHIN_M, rtol=0)
