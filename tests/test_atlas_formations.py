"""Laws of the atlas that form shapes or cover a box: what they predict."""

import numpy as np
import pytest

from setcmas_tools import simulate

THEORY = {'model': 'omnidirectional', 'vnom': 50.0, 'rate': 25.0, 'robot_rate': 25.0}
SLOWER = {**THEORY, 'rate': 10.0, 'robot_rate': 10.0}
SQUARE = [[2, 0], [0, 2], [-2, 0], [0, -2]]


def braced(tmp_path):
    """Return the options of a square with one diagonal, which is minimally rigid."""
    (tmp_path / 'braced.yaml').write_text('edges: [1 - 2, 2 - 3, 3 - 4, 1 - 4, 1 - 3]\n')
    return {'graph': str(tmp_path / 'braced.yaml')}


def decay(t, errors):
    """Return the rate in 1/s at which errors, shape (steps, M), decay over the last quarter."""
    late = slice(3 * len(t) // 4, None)
    return -np.polyfit(t[late], np.log(np.linalg.norm(errors[late], axis=1)), 1)[0]


def nudged(places, seed=0):
    """Return start poses that are a few centimetres from places, shape (N, 2)."""
    offsets = np.random.default_rng(seed).normal(0.0, 0.03, (2, len(places)))
    return [*(np.transpose(places) + offsets), np.zeros(len(places))]


def test_a_minimally_rigid_formation_has_the_rate_of_its_rigidity_matrix(tmp_path):
    links = np.array([[0, 1], [1, 2], [2, 3], [0, 3], [0, 2]])
    options = {**braced(tmp_path), 'poses': nudged(SQUARE), 'set': {'K': 0.005, 'SLOW': 0.0}}
    run = simulate('distance_formation', 4, 60.0, **options, **THEORY)
    rigidity = np.zeros((5, 8))
    for row, (i, j) in zip(rigidity, links, strict=True):
        row[2 * i : 2 * i + 2] = np.subtract(SQUARE[i], SQUARE[j])
        row[2 * j : 2 * j + 2] = -row[2 * i : 2 * i + 2]
    gaps = run.poses[:, :2, links[:, 0]] - run.poses[:, :2, links[:, 1]]
    errors = np.sum(gaps**2, axis=1) - np.sum(rigidity**2, axis=1) / 2
    rate = 2 * 0.005 * np.linalg.eigvalsh(rigidity @ rigidity.T)[0]

    assert decay(run.t, errors) == pytest.approx(rate, rel=0.01)


@pytest.mark.parametrize(
    ('nb_robots', 'settings'),
    [(4, {}), (5, {'K': 0.01}), (3, {'P': [[0, 0], [3, 0], [0, 4]]})],
)
def test_a_distance_formation_keeps_its_centre_and_gets_its_size(nb_robots, settings):
    options = {'random_poses': 'box=6x6,distance=1', 'seed': 2, 'set': {'SLOW': 0.0} | settings}
    run = simulate('distance_formation', nb_robots, 60.0, **options, **THEORY)
    metrics = run.metrics()

    assert len(metrics['prediction'].figures) == 2
    for one in metrics['prediction'].figures:
        assert one.measured == pytest.approx(one.predicted, rel=0.001, abs=1e-6)
    assert metrics['distances'].distance_error_final_largest_m < 0.001


def test_a_bearing_formation_ends_at_the_projection_of_its_starts(tmp_path):
    starts = np.array([[3.0, 1.0, -4.0, 0.0], [1.0, 2.0, 0.0, -5.0], [0.0, 0.0, 0.0, 0.0]])
    options = {**braced(tmp_path), 'poses': starts, 'set': {'P': SQUARE, 'SLOW': 0.0}}
    run = simulate('bearing_formation', 4, 120.0, **options, **THEORY)
    shape = np.transpose(SQUARE) - np.mean(SQUARE, axis=0)[:, None]
    centre = starts[:2].mean(axis=1)[:, None]
    scale = np.sum((starts[:2] - centre) * shape) / np.sum(shape**2)

    assert run.poses[-1, :2] == pytest.approx(centre + scale * shape, abs=1e-3)
    early = slice(0, len(run.t) // 2)
    rate = decay(run.t[early], (run.poses[early, :2] - centre - scale * shape).reshape(-1, 8))
    assert rate == pytest.approx(0.2 * (2 - np.sqrt(2)), rel=0.01)


def nearest(run, k):
    """Return points of the box, the nearest robot of each, and the squared distance to it."""
    x, y = np.meshgrid(*2 * [np.linspace(-6, 6, 241)])
    squares = (x - run.poses[k, 0, :, None, None]) ** 2 + (y - run.poses[k, 1, :, None, None]) ** 2
    return np.array([x, y]), squares.argmin(axis=0), squares.min(axis=0)


def test_coverage_ends_in_the_centroids_of_the_cells():
    starts = {'random_poses': 'box=4x4,distance=0.5', 'seed': 1}
    run = simulate('coverage', 6, 60.0, **starts, **SLOWER)
    points, cell, _ = nearest(run, -1)
    found = run.metrics()

    for robot in range(6):
        centroid = points[:, cell == robot].mean(axis=1)
        assert run.poses[-1, :2, robot] == pytest.approx(centroid, abs=0.1)
    assert found['coverage'].largest_rise_percent == 0.0
    costs = [nearest(run, k)[2].mean() for k in range(0, len(run.t), 100)]
    assert np.diff(costs).max() < 1e-3
    assert found['coverage'].cost_at_end_m4 < 0.4 * found['coverage'].cost_at_start_m4


def test_robots_outside_the_box_drive_into_it():
    run = simulate('coverage', 3, 30.0, poses=[[20, 21, 1], [0, 5, 1], [0, 0, 0]], **SLOWER)

    assert np.abs(run.poses[-1, :2]).max() < 6
    assert run.metrics()['coverage'].largest_rise_percent == 0


def test_too_few_points_are_reported(capsys):
    for law in ('distance_formation', 'bearing_formation'):
        simulate(law, 3, 1.0, set={'P': [[0, 0], [1, 0]]}, warn=print)
        assert 'P has 2 points for 3 robots' in capsys.readouterr().out
