import numpy as np
import pytest
from ros1_recordings import CONSENSUS, WP_NAV

from setcmas_ctrl.control.control_law import ControlLaw
from setcmas_ctrl.control.saturation import saturate
from setcmas_ctrl.scripts.loader import ALGORITHMS, find_script
from setcmas_simu.fleet.fleet import start_poses
from setcmas_simu.robots import unicycle
from setcmas_simu.robots.model import si_to_uni

TS = 0.1
LAWS = sorted({ALGORITHMS.file(name) for name in ALGORITHMS.offers()})


def simulate(name, poses, duration, starts=None):
    """Step laws at 5 Hz and unicycles at 10 Hz; returns poses over time, shape (3, N, steps)."""
    nb_robots = poses.shape[1]
    laws = [ControlLaw(find_script(name), i + 1, nb_robots) for i in range(nb_robots)]
    starts = np.zeros(nb_robots) if starts is None else np.asarray(starts)
    V, omega = np.zeros((2, nb_robots))
    history = [poses]
    for k in range(round(duration / TS)):
        if k % 2 == 0:
            wanted = [
                law(poses, k * TS - start) if k * TS >= start else (0.0, 0.0)
                for law, start in zip(laws, starts, strict=True)
            ]
            V, omega = si_to_uni(saturate(np.transpose(wanted)), poses[2])
        poses = unicycle.step(poses, V, omega, TS)
        history.append(poses)
    return np.stack(history, axis=-1)


def reference(path):
    """Return times and positions, shape (2, N, times), of a recording of the ROS 1 stack."""
    table = np.loadtxt(path, delimiter=',', skiprows=1)
    grid = np.arange(0.0, table[-1, 0] - 1, TS)
    tracks = [table[table[:, 1] == robot] for robot in np.unique(table[:, 1])]
    positions = [[np.interp(grid, track[:, 0], track[:, k]) for track in tracks] for k in (2, 3)]
    return grid, np.array(positions)


def rms_after_shift(history, grid, positions, max_shift=0.5):
    times = np.arange(history.shape[-1]) * TS
    best = np.inf
    for shift in np.arange(-max_shift, max_shift + 1e-9, 0.02):
        inside = (grid + shift >= 0) & (grid + shift <= times[-1])
        ours = np.array(
            [[np.interp(grid + shift, times, track) for track in axis] for axis in history[:2]]
        )
        error = (ours - positions)[..., inside]
        best = min(best, float(np.sqrt(np.mean(np.sum(error**2, axis=0)))))
    return best


def test_nav_wp_follows_the_recording_of_the_ros_1_stack():
    history = simulate('nav_wp', np.array([[5.0], [5.0], [0.0]]), 61)

    assert rms_after_shift(history, *reference(WP_NAV)) < 0.05


def test_consensus_follows_the_recording_of_the_ros_1_stack():
    # Its eight controllers started one after the other, so the robots set off apart.
    table = np.loadtxt(CONSENSUS, delimiter=',', skiprows=1)
    moving = table[table[:, 5] > 0]
    starts = np.array([moving[moving[:, 1] == robot][0, 0] for robot in range(1, 9)]) - TS
    history = simulate('consensus', start_poses(8), 42, starts - starts.min())

    assert rms_after_shift(history, *reference(CONSENSUS)) < 0.05


def test_robots_in_consensus_meet():
    start = np.array([[4.0, -1.0, 0.0], [0.0, 2.0, 1.0], [0.0, 1.0, -2.0]])
    end = simulate('consensus', start, 60)[:2, :, -1]

    assert np.ptp(end, axis=1).max() < 0.1


def test_consensus_leaves_the_average_in_place():
    poses = start_poses(7)
    laws = [ControlLaw(find_script('consensus'), robot, 7) for robot in range(1, 8)]

    velocities = np.array([law(poses, 0.0) for law in laws])

    np.testing.assert_allclose(velocities.sum(axis=0), 0.0, atol=1e-12)


def test_two_robots_in_consensus_approach_at_the_rate_of_theory():
    # Facing each other and slower than vnom, d' = -K d; held over periods T = 0.2 s that is
    # d(k + 1) = (1 - K T) d(k), with K = 0.5.
    start = np.array([[-0.4, 0.4], [0.0, 0.0], [0.0, np.pi]])
    x = simulate('consensus', start, 2)[0]
    distance = x[1] - x[0]

    assert distance[20] / distance[0] == pytest.approx((1 - 0.5 * 0.2) ** 10)


def test_traj_tracking_stays_on_its_circle():
    history = simulate('traj_tracking', np.array([[2.0], [0.0], [np.pi / 2]]), 40)
    times = np.arange(history.shape[-1]) * TS
    error = np.hypot(
        history[0, 0] - 2 * np.cos(0.2 * times), history[1, 0] - 2 * np.sin(0.2 * times)
    )

    assert error[100:].max() < 0.15


def test_traj_tracking_counts_time_from_its_own_first_call():
    law = ControlLaw(find_script('traj_tracking'), 1, 1)

    vx, vy = law(np.array([[2.0], [0.0], [0.0]]), 123.0)

    assert (vx, vy) == pytest.approx((0.0, 0.4))


def test_followers_keep_their_places_beside_the_leader():
    history = simulate('leader_follower_formation', start_poses(7), 60)[:2]
    places = history[:, 1:, -100:] - history[:, :1, -100:]
    wanted = [(-1.5, 0.866), (-1.5, -0.866), (1.5, -0.866), (1.5, 0.866)]
    wanted += [(0.0, -1.732), (0.0, 1.732)]

    np.testing.assert_allclose(places.mean(axis=-1).T, wanted, atol=0.35)


def test_further_followers_get_places_of_their_own():
    law = ControlLaw(find_script('leader_follower_formation'), 2, 30)
    module = law._control.__globals__
    places = np.array(module['places_of'](29))
    gaps = np.hypot(*(places[:, None] - places[None]).transpose(2, 0, 1))
    np.fill_diagonal(gaps, np.inf)

    assert len(places) == 29
    assert gaps.min() > 1.7
    assert np.hypot(*places.T).min() > 1.7


def test_distance_formation_comes_to_the_wanted_distances():
    start = np.array([[0.0, 3.0, 1.0], [0.0, 1.0, 4.0], [0.0, 0.0, 0.0]])
    positions = simulate('leader_follower_distance_formation', start, 40)[:2, :, -50:]
    gaps = [
        np.hypot(*(positions[:, i] - positions[:, j])).mean() for i, j in ((0, 1), (0, 2), (1, 2))
    ]

    np.testing.assert_allclose(gaps, 3.0, atol=0.35)


@pytest.mark.parametrize('path', LAWS, ids=lambda p: p.stem)
def test_every_built_in_works_for_any_number_of_robots(path):
    for nb_robots in (1, 2, 9, 30):
        poses = start_poses(nb_robots)
        for robot in (1, nb_robots):
            velocity = ControlLaw(path, robot, nb_robots)(poses, 0.0)
            assert np.isfinite(velocity).all()


@pytest.mark.parametrize('path', LAWS, ids=lambda p: p.stem)
def test_velocities_below_a_centimetre_per_second_become_zero(path):
    law = ControlLaw(path, 1, 1)
    target = law._control.__globals__.get('WPL', [[2, 0]])[0]
    resting = np.array([[target[0] + 0.001], [target[1]], [0.0]])
    if path.stem == 'traj_tracking':
        law._control.__globals__['W'] = 0.0

    assert law(resting, 0.0) == (0.0, 0.0)
