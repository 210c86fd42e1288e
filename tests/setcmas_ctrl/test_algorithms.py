import numpy as np
import pytest
from ros1_recordings import CONSENSUS, WP_NAV

from setcmas_ctrl.communication.graph import PRESETS
from setcmas_ctrl.control_law import ControlLaw
from setcmas_ctrl.laws.script_loader import ALGORITHMS
from setcmas_ctrl.laws.script_search import find_script
from setcmas_simu.fleet.fleet import start_poses
from setcmas_tools import simulate
from setcmas_tools.run.run_tables import read_fleet


def distance(run, table, largest_shift=0.5):
    """Return how far (m, RMS per robot) recorded robots are from a simulated run.

    That is after the shift in time, up to the largest (s), at which they are nearest.
    """
    tracks = [table.of(robot) for robot in table.robots]

    def rms(shift):
        t = run.t[(run.t + shift >= table.t[0]) & (run.t + shift <= table.t[-1])]
        paths = [(np.interp(t + shift, p.t, p.x), np.interp(t + shift, p.t, p.y)) for p in tracks]
        apart = np.array(paths) - run.poses[np.isin(run.t, t), :2].transpose(2, 1, 0)
        return np.sqrt(np.mean(np.sum(apart**2, axis=1)))

    return min(rms(shift) for shift in np.linspace(-largest_shift, largest_shift, 101))


LAWS = sorted({ALGORITHMS.file(name) for name in ALGORITHMS.plugins()})


def poses_of(algo, poses, duration):
    """Run a law; returns poses over time at 10 Hz, shape (3, N, steps)."""
    run = simulate(algo, poses.shape[1], duration, poses=poses)
    return run.poses.transpose(1, 2, 0)


def test_nav_wp_follows_the_recording_of_the_ros_1_stack():
    run = simulate('nav_wp', duration=61, poses=[[5], [5], [0]])

    assert distance(run, read_fleet(WP_NAV)) < 0.05


def test_consensus_follows_the_recording_of_the_ros_1_stack():
    # Its eight controllers started one after the other, so the robots set off apart.
    table = read_fleet(CONSENSUS)
    moving = table.rows(table.v > 0)
    starts = np.array([moving.of(robot).t[0] for robot in range(1, 9)])
    laws = [ControlLaw(find_script('consensus'), robot, 8) for robot in range(1, 9)]

    def late(robotNo, nbRobots, poses, t):
        begins = starts[robotNo - 1] - starts.min()
        return laws[robotNo - 1](poses, t - begins) if t >= begins else (0.0, 0.0)

    assert distance(simulate(late, 8, 42), table) < 0.05


def test_traj_tracking_counts_time_from_its_own_first_call():
    law = ControlLaw(find_script('traj_tracking'), 1, 1)

    vx, vy = law(np.array([[2.0], [0.0], [0.0]]), 123.0)

    assert (vx, vy) == pytest.approx((0.0, 0.4))


def test_followers_keep_their_places_around_the_leader():
    history = poses_of('leader_follower_formation', start_poses(7), 60)[:2]
    places = history[:, 1:, -100:] - history[:, :1, -100:]
    wanted = [(-1.5, 0.866), (-1.5, -0.866), (1.5, -0.866), (1.5, 0.866)]
    wanted += [(0.0, -1.732), (0.0, 1.732)]

    np.testing.assert_allclose(places.mean(axis=-1).T, wanted, atol=0.35)


def test_further_followers_get_places_of_their_own():
    law = ControlLaw(find_script('leader_follower_formation'), 2, 30)
    module = law.names
    places = np.array(module['places_of'](29))
    gaps = np.hypot(*(places[:, None] - places[None]).transpose(2, 0, 1))
    np.fill_diagonal(gaps, np.inf)

    assert len(places) == 29
    assert gaps.min() > 1.7
    assert np.hypot(*places.T).min() > 1.7


def test_distance_formation_comes_to_the_wanted_distances():
    start = np.array([[0.0, 3.0, 1.0], [0.0, 1.0, 4.0], [0.0, 0.0, 0.0]])
    positions = poses_of('leader_follower_distance_formation', start, 40)[:2, :, -50:]
    gaps = [
        np.hypot(*(positions[:, i] - positions[:, j])).mean() for i, j in ((0, 1), (0, 2), (1, 2))
    ]

    np.testing.assert_allclose(gaps, 3.0, atol=0.35)


@pytest.mark.parametrize('rates', [{}, {'rate': 25, 'robot_rate': 25}], ids=['usual', 'theory'])
@pytest.mark.parametrize('graph', ['path', 'ring', 'directed_ring', 'star', 'complete'])
def test_leader_election_agrees_one_call_after_as_many_as_the_diameter(graph, rates):
    numbers = [3, 1, 9, 4, 5, 2]
    run = simulate('leader_election', 6, 4.0, graph=graph, set={'NUMBERS': numbers}, **rates)
    links = (PRESETS[graph](6) > 0) + np.eye(6)
    diameter = next(k for k in range(6) if np.linalg.matrix_power(links, k).all())
    largest = np.array([one.value[0] for one in run.messages]).reshape(-1, 6)

    assert np.flatnonzero((largest == 9).all(axis=1))[0] <= diameter
    if graph in ('directed_ring', 'complete'):
        assert not (largest[diameter - 1] == 9).all()
    assert (largest[diameter:] == 9).all()
    assert {tuple(one.value[1:]) for one in run.messages[-6:]} == {(3.0, -5.0, -5.0)}


def test_robots_gather_where_the_elected_leader_starts():
    run = simulate('leader_election', 4, 60.0, graph='path', loss=0.3, delay=0.2, seed=5)
    leader = int(run.messages[-1].value[1])

    assert np.abs(run.poses[-1, :2] - run.poses[0, :2, leader - 1, None]).max() < 0.05


def test_leader_election_with_too_few_numbers_goes_on():
    run = simulate('leader_election', 4, 2.0, set={'NUMBERS': [5, 7]})

    assert run.failed_robots == []
    assert {one.value[0] for one in run.messages[-4:]} == {7}


@pytest.mark.parametrize('path', LAWS, ids=lambda p: p.stem)
def test_velocities_below_a_centimetre_per_second_become_zero(path):
    law = ControlLaw(path, 1, 1)
    target = law.names.get('WPL', [[2, 0]])[0]
    resting = np.array([[target[0] + 0.001], [target[1]], [0.0]])
    if path.stem == 'traj_tracking':
        law.names['W'] = 0.0
    if path.stem == 'coverage':
        law.names['BOX'] = [[1, -1], [3, 1]]
    if path.stem == 'resilient_consensus':
        law.names['REBELS'] = []

    assert law(resting, 0.0) == (0.0, 0.0)
