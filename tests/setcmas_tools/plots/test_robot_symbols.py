import numpy as np
import pytest
from matplotlib.figure import Figure

from setcmas_tools import simulate
from setcmas_tools.plots.looks.style import plot_style
from setcmas_tools.plots.robot_symbols import symbol
from setcmas_tools.plots.trajectories import draw_trajectories


def test_a_unicycle_is_the_dart_that_it_always_was():
    dart = [(1.0, 0.0), (-0.8, 0.7), (-0.4, 0.0), (-0.8, -0.7)]

    np.testing.assert_allclose(symbol('unicycle'), dart, atol=1e-3)


@pytest.mark.parametrize('name', ['burger', 'waffle', 'omnidirectional', 'car'])
def test_other_symbols_are_as_large_and_head_ahead(name):
    corners = symbol(name)

    assert np.prod(np.ptp(corners, axis=0)) == pytest.approx(1.8 * 1.4, rel=1e-3)
    assert corners[:, 0].max() > 0
    assert corners[:, 1].max() == pytest.approx(-corners[:, 1].min())


def test_the_ends_of_trajectories_have_the_symbols_of_the_models():
    run = simulate('consensus', 3, 2.0, model='2:car')
    figure = Figure()
    with plot_style():
        draw_trajectories(figure, run)

    ends = [line.get_marker() for line in figure.axes[0].lines if line.get_zorder() == 4]
    corners = [len(marker.vertices) for marker in ends]
    assert corners == [5, len(symbol('car')) + 1, 5]
