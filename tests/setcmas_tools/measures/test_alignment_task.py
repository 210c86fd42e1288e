import numpy as np
import pytest

from setcmas_tools import simulate
from setcmas_tools.measures.alignment_task import alignment, spread


@pytest.mark.parametrize(
    ('degrees', 'expected'),
    [([10, 350], 20), ([0, 90, 180], 180), ([5], 0), ([], 0), ([0, 120, 240], 240)],
)
def test_the_spread_of_directions_is_the_smallest_sector_with_all(degrees, expected):
    angles = np.radians(degrees)
    velocities = 0.3 * np.array([np.cos(angles), np.sin(angles)])
    at_rest = np.zeros((2, 1))

    assert spread(*np.hstack([velocities, at_rest])) == pytest.approx(np.radians(expected))


def test_velocities_that_converge_have_a_rate_and_keep_their_mean():
    t = np.arange(0, 201) / 10
    gaps = 0.1 * np.exp(-0.4 * t)
    found = alignment(t, np.array([0.2 + gaps, 0.2 - gaps]), np.zeros((2, len(t))))

    assert found.convergence_rate_1_s == pytest.approx(0.4)
    assert found.disagreement_at_start_m_s == pytest.approx(0.1)
    assert found.final_mean_vx_m_s == pytest.approx(0.2)
    assert found.spread_of_directions_at_end_rad == 0.0


def test_a_law_that_aligns_has_its_metrics_lines_and_plot():
    run = simulate('velocity_alignment', 3, 20.0)

    assert 'disagreement of velocities: ' in str(run.metrics())
    assert 'centre at the end' not in str(run.metrics())
    assert run.plot('errors').axes[0].get_title('left') == 'Alignment error'
    assert 'alignment' not in simulate('velocity_alignment', 1, 2.0).metrics()
