import math
from pathlib import Path

import numpy as np
import pytest
from metrics_runs import T, compute, table, write_run
from runs import measure

from setcmas_tools import simulate


def test_path_length_and_speed_of_a_circle():
    t = np.linspace(-1, 10 * math.pi, 400)
    motion = measure(table((t, 2 * np.cos(0.2 * t), 2 * np.sin(0.2 * t), 0.4)))['robots'][1]

    assert motion['path_length_m'] == pytest.approx(0.4 * t[t >= 0].max(), rel=5e-3)
    assert motion['mean_speed_m_s'] == pytest.approx(0.4, rel=1e-3)
    assert motion['largest_speed_m_s'] == pytest.approx(0.4)
    assert motion['end_x_m'] == pytest.approx(2.0)


def test_the_least_separation_with_its_time_and_robots():
    # Robot 1 passes robot 2 at 0.3 m, between two samples.
    near = measure(table((T, T - 5.03, 0), (T, 0, 0.3), (T, 5, 6)))['separation']

    assert near.least_separation_m == pytest.approx(0.3)
    assert near.least_separation_time_s == pytest.approx(5.03)
    assert near.least_separation_robots == (1, 2)
    assert near.largest_distance_at_end_m == pytest.approx(math.hypot(14.97, 0.3))


def test_the_least_separation_of_many_is_that_of_all_pairs_at_all_times():
    x, y = np.random.default_rng(1).normal(size=(2, 12, len(T))).cumsum(axis=-1)
    near = measure(table(*((T, *track) for track in zip(x, y, strict=True))))['separation']

    shares = np.linspace(0, 1, 400)
    fine = [rows[:, :-1, None] + np.diff(rows)[..., None] * shares for rows in (x, y)]
    expected = min(
        np.hypot(fine[0][i] - fine[0][j], fine[1][i] - fine[1][j]).min()
        for i in range(12)
        for j in range(i)
    )
    assert near.least_separation_m == pytest.approx(expected, abs=0.02)
    assert near.least_separation_m <= expected


def test_time_in_saturation():
    v = np.where((T > 2) & (T <= 5), 0.4997, 0.3)
    v[[100, 150]] = -0.5, 0.4994
    fleet = table((T, 0, 0, v))

    assert measure(fleet, vnom=0.5)['robots'][1]['time_in_saturation_s'] == pytest.approx(3.1)
    assert measure(fleet, vnom=0.3)['robots'][1]['time_in_saturation_s'] == pytest.approx(20.0)


def test_a_gap_is_not_time_in_saturation():
    t = T[(T <= 5) | (T >= 15)]

    assert measure(table((t, 0, 0, 0.5)))['robots'][1]['time_in_saturation_s'] == pytest.approx(
        10.0
    )


@pytest.mark.parametrize(
    ('values', 'vnom'),
    [
        ({}, 0.5),
        ({'vnom': 0.2}, 0.2),
        ({'limits': 'burger'}, 0.2108),
        ({'limits': 'ideal'}, 0.5),
        ({'lab': {'limits': {'V_max': 0.15}}}, 0.15),
        ({'lab': {'limits': {}}}, 0.5),
    ],
)
def test_vnom_is_what_robots_can_reach_at_most(tmp_path, values, vnom):
    run = write_run(tmp_path, table((T, 0, 0, 0.2)), **values)

    assert compute(run).vnom_m_s == vnom


def test_a_model_file_that_a_run_keeps_has_the_limits_of_its_robots(tmp_path):
    model = Path('inputs', 'model', 'model.yaml')
    run = write_run(tmp_path, table((T, 0, 0, 0.2)), limits='ideal', model=str(model))
    (tmp_path / model).parent.mkdir(parents=True)
    (tmp_path / model).write_text('limits: burger\nothers: {turn: {lag: 0.1}}\n')

    assert compute(run).vnom_m_s == 0.2108


def test_rows_before_the_first_command_do_not_count():
    t = np.arange(-50, 51) / 10
    metrics = measure(table((t, np.minimum(t, 0), 0, 0.5), (t, 3, 0)))

    assert metrics['robots'][1]['path_length_m'] == 0.0
    assert metrics['robots'][1]['time_in_saturation_s'] == pytest.approx(5.0)
    assert metrics['separation'].least_separation_time_s == 0.0
    assert metrics.duration_s == pytest.approx(5.0)


def test_the_speed_of_robots_that_drive_in_any_direction_is_that_of_their_way():
    run = simulate('consensus', 8, 20.0, model='omnidirectional')
    fifth = run.metrics()['robots'][5]  # drives along -y

    assert fifth['largest_speed_m_s'] == pytest.approx(0.5, rel=1e-3)
    assert fifth['time_in_saturation_s'] > 3.0
    assert fifth['time_in_dead_band_s'] < 10.0
