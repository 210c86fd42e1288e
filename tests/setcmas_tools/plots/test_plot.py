import struct

import matplotlib as mpl
import numpy as np
import pytest
from circling_fleets import circling_fleet, drawn
from matplotlib.figure import Figure
from runs import plot, run_of

from setcmas_simu.errors import SetcmasError
from setcmas_tools.plots.style import plot_style
from setcmas_tools.plots.time_plots import draw_heading, draw_positions
from setcmas_tools.plots.trajectories import draw_trajectories
from setcmas_tools.run.fleet_motion import fleet_table
from setcmas_tools.run.run_tables import RunTables, write_tables

NAMES = ['trajectories', 'positions', 'heading', 'velocities', 'distances', 'disagreement']


@pytest.mark.parametrize('nb_robots', [1, 8])
def test_plots_of_a_run(run, nb_robots):
    folder = run(nb_robots)
    paths = plot(folder)

    names = NAMES if nb_robots > 1 else NAMES[:4]
    assert paths == [folder / 'plots' / f'{name}.png' for name in names]
    for path in paths:
        content = path.read_bytes()
        assert content.startswith(b'\x89PNG')
        width, height = struct.unpack('>II', content[16:24])
        dots_per_metre = struct.unpack('>I', content[content.index(b'pHYs') + 4 :][:4])[0]
        assert dots_per_metre == round(150 / 0.0254)
        assert width >= 1200
        assert height >= 700


@pytest.mark.nightly
def test_vector_formats_embed_their_fonts(run):
    paths = plot(run(2), format=['pdf', 'svg'])

    for path in paths:
        content = path.read_bytes()
        if path.suffix == '.pdf':
            assert b'/FontFile2' in content
            assert b'/Type3' not in content
        else:
            assert b'<text' not in content


@pytest.mark.nightly
def test_equal_tables_give_equal_bytes_whatever_the_users_settings(run):
    formats = ['png', 'pdf']
    with mpl.rc_context():
        expected = [path.read_bytes() for path in plot(run(1), format=formats)]
        mpl.rcParams['lines.linewidth'] = 9.0
        mpl.rcParams['font.size'] = 30
        before = dict(mpl.rcParams)

        assert [path.read_bytes() for path in plot(run(1), format=formats)] == expected
        assert dict(mpl.rcParams) == before


def test_plane_has_equal_scales():
    (axes,) = drawn(draw_trajectories, 3).axes
    box = axes.get_window_extent()
    (x0, x1), (y0, y1) = axes.get_xlim(), axes.get_ylim()

    assert box.width / (x1 - x0) == pytest.approx(box.height / (y1 - y0), rel=0.002)


def test_headings_have_no_jumps():
    (axes,) = drawn(draw_heading, 3).axes
    lines = [line.get_ydata() for line in axes.get_lines() if len(line.get_ydata()) > 2]

    assert len(lines) == 3
    for theta in lines:
        assert np.abs(np.diff(theta)).max() < 0.1
        assert theta[-1] - theta[0] == pytest.approx(3 * np.pi, rel=0.01)


def test_lines_break_where_data_are_missing(run):
    table = circling_fleet(8)
    lost = (table.robot == 2) & (table.t > 3) & (table.t < 6)
    table.x[lost] = np.nan
    table = table.rows(~((table.robot == 3) & (table.t > 4) & (table.t < 7)))
    folder = run(8)
    write_tables(RunTables(table), folder / 'csv')

    assert len(plot(folder)) == 6
    with plot_style():
        figure = Figure()
        draw_positions(figure, run_of(table))
    breaks = [np.isnan(line.get_ydata()).sum() for line in figure.axes[0].get_lines()[:8]]
    assert breaks == [0, 1, 1, 0, 0, 0, 0, 0]


def test_a_robot_that_never_has_a_pose_and_a_single_row(tmp_path):
    nan = float('nan')
    rows = [[0, 1, 0, 0, 0, 0, 0], [1, 2, nan, nan, nan, 0, 0]]
    write_tables(RunTables(fleet_table(rows)), tmp_path)

    assert len(plot(tmp_path / 'fleet.csv')) == 6


def test_without_a_screen_nothing_can_be_shown(run, monkeypatch):
    monkeypatch.setattr('matplotlib.pyplot.get_backend', lambda: 'agg')
    folder = run(1)

    with pytest.raises(SetcmasError, match='no screen to show plots on'):
        plot(folder, show=True)
    assert len([*(folder / 'plots').iterdir()]) == 4


def test_mistakes_get_one_line(tmp_path, run):
    folder = run(1)
    with pytest.raises(SetcmasError, match="format is 'gif'; it must be png, pdf or svg"):
        plot(folder, format=['gif'])
    (tmp_path / 'taken').write_text('a file')
    with pytest.raises(SetcmasError, match='cannot be written'):
        plot(folder, tmp_path / 'taken')


def test_curves_that_lie_on_each_other_show_in_turn():
    figure = drawn(draw_positions, 4)  # robots 1 and 2 start at x = 5, 3 and 4 at x = -5
    styles = [line._unscaled_dash_pattern for line in figure.axes[0].get_lines()[:4]]

    assert styles == [(0.0, (4.0, 4.0)), (4.0, (4.0, 4.0))] * 2
