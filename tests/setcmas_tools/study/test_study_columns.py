import pytest

from setcmas_tools import simulate
from setcmas_tools.measures.metric import Measured, Value
from setcmas_tools.measures.metrics import measure
from setcmas_tools.study.study_columns import COLUMNS, numbers_of


def test_every_column_is_a_number_of_some_run():
    runs = [
        simulate('consensus', 3, 15, loss=0.2),
        simulate('leader_follower_formation', 3, 5),
        simulate('leader_follower_distance_formation', 3, 5),
        simulate('traj_tracking', 2, 5),
    ]
    found = [numbers_of(measure(run)) for run in runs]

    names = {name for numbers in found for name in numbers}
    assert names == {*COLUMNS}
    motions = measure(runs[0])['robots'].values()
    assert found[0]['communications'] == sum(motion['communications'] for motion in motions)
    assert found[0]['path_length'] == pytest.approx(
        sum(motion['path_length_m'] for motion in motions) / 3
    )
    assert found[3]['tracking_error'] > 0


def test_metrics_of_plugins_have_columns_of_their_own():
    parts = {
        'excursion': Value('excursion', {1: 2.0, 2: 4.0}, 'm'),
        'fruit': Measured({'apples': -0.0, 'pears': {1: 1.0, 2: 2.0}, 'name': 'basket'}),
    }

    assert numbers_of(parts) == {
        'excursion': 3.0,
        'fruit_apples': 0.0,
        'fruit_pears': 1.5,
    }
