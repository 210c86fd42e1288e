import re
import struct
import subprocess
import sys

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.figure import Figure

from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet import plot_colour, start_poses
from setcmas_tools.csv_to_plot import plot
from setcmas_tools.fleet_table import fleet_table, write_csv
from setcmas_tools.plot_distances import draw_distances
from setcmas_tools.plot_style import finish, line_look, plot_style, robot_colour
from setcmas_tools.plot_time_series import draw_heading, draw_positions, draw_velocities
from setcmas_tools.plot_trajectories import draw_trajectories
from setcmas_tools.run_description import describe

RUN_YAML = 'parameters: {algo: leader_follower_formation, nb_robots: 4}'
NAMES = ['trajectories', 'positions', 'heading', 'velocities', 'distances']
DRAWINGS = [draw_trajectories, draw_positions, draw_heading, draw_velocities, draw_distances]


def circling_fleet(nb_robots, turns=1.5):
    """Robots that circle around their start poses, 12 s at 10 Hz, from 1 s before t = 0."""
    t = np.arange(-1.0, 11.0, 0.1)
    angle = 2 * np.pi * turns * (t - t[0]) / 12
    theta = np.arctan2(np.sin(angle), np.cos(angle))
    rows = [
        np.array([t, 0 * t + i, x + np.sin(angle), y - np.cos(angle), theta, 0 * t + 1, 0 * t]).T
        for i, (x, y, _) in enumerate(start_poses(nb_robots).T, start=1)
    ]
    return fleet_table(np.concatenate(rows))


@pytest.fixture
def run(tmp_path):
    """A function that makes the folder of a run with a fleet of a size."""

    def run(nb_robots):
        (tmp_path / 'csv').mkdir(exist_ok=True)
        write_csv(circling_fleet(nb_robots), tmp_path / 'csv' / 'fleet.csv')
        return tmp_path

    return run


def drawn(drawing, nb_robots, palette='robots', paper=None):
    with plot_style(palette, paper):
        figure = Figure()
        drawing(figure, circling_fleet(nb_robots))
        finish(figure, f'leader_follower_distance_formation, {nb_robots} robots')
        figure.draw_without_rendering()
    return figure


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


@pytest.mark.parametrize('given', ['.', 'csv', 'csv/fleet.csv'])
def test_what_can_be_given(run, given):
    folder = run(2)

    assert plot(folder / given)[0].parent == folder / 'plots'
    assert plot(folder / given, folder / 'figures')[0].parent == folder / 'figures'


def test_a_fleet_csv_on_its_own(tmp_path):
    write_csv(circling_fleet(2), tmp_path / 'somewhere.csv')

    assert plot(tmp_path / 'somewhere.csv')[0].parent == tmp_path / 'plots'


@pytest.mark.parametrize('paper', [None, 'column'])
def test_vector_formats_embed_their_fonts(run, paper):
    paths = plot(run(8), formats=['pdf', 'svg'], paper=paper)

    for path in paths:
        content = path.read_bytes()
        if path.suffix == '.pdf':
            assert b'/FontFile2' in content
            assert b'/Type3' not in content
        else:
            assert b'<text' not in content


def test_equal_tables_give_equal_bytes(run):
    formats = ['png', 'pdf', 'svg']
    first = [path.read_bytes() for path in plot(run(4), formats=formats)]

    assert [path.read_bytes() for path in plot(run(4), formats=formats)] == first


def test_the_users_settings_stay_and_do_not_matter(run):
    with mpl.rc_context():
        expected = [path.read_bytes() for path in plot(run(2))]
        mpl.rcParams['lines.linewidth'] = 9.0
        mpl.rcParams['font.size'] = 30
        before = dict(mpl.rcParams)

        assert [path.read_bytes() for path in plot(run(2))] == expected
        assert dict(mpl.rcParams) == before


STYLES = [('robots', None), ('okabe-ito', None), ('robots', 'column'), ('okabe-ito', 'page')]


@pytest.mark.parametrize(('palette', 'paper'), STYLES)
@pytest.mark.parametrize('nb_robots', [5, 8, 50])
@pytest.mark.parametrize('drawing', DRAWINGS)
def test_legends_and_titles_cover_nothing(drawing, nb_robots, palette, paper):
    figure = drawn(drawing, nb_robots, palette, paper)
    legends = [axes.get_legend().get_window_extent() for axes in figure.axes if axes.get_legend()]

    assert legends
    plots = [axes.get_window_extent() for axes in figure.axes]
    texts = [text.get_window_extent() for text in outer_texts(figure)]
    for i, legend in enumerate(legends):
        assert figure.bbox.x0 <= legend.x0
        assert legend.x1 <= figure.bbox.x1
        assert figure.bbox.y0 <= legend.y0
        assert legend.y1 <= figure.bbox.y1
        assert not any(legend.overlaps(other) for other in plots + texts + legends[:i])
    for i, text in enumerate(texts):
        assert not any(text.overlaps(other) for other in plots + texts[:i])


def outer_texts(figure):
    """Return the titles and labels that are there."""
    for axes in figure.axes:
        titles = [axes.title, axes._left_title, axes._right_title]
        for text in (*titles, axes.xaxis.label, axes.yaxis.label):
            if text.get_text():
                yield text


@pytest.mark.parametrize('drawing', DRAWINGS)
def test_axes_have_labels_with_units(drawing):
    figure = drawn(drawing, 8)

    for axes in figure.axes:
        assert re.search(r'\((m|rad|m/s|rad/s)\)$', axes.get_ylabel())
    assert re.search(r'\((s|m)\)$', figure.axes[-1].get_xlabel())


def test_robots_have_the_colours_of_the_fleet():
    (axes,) = drawn(draw_trajectories, 8).axes
    paths = [line for line in axes.get_lines() if len(line.get_xdata()) > 1]

    assert [line.get_color() for line in paths] == [plot_colour(i) for i in range(1, 9)]


def luminance(colour):
    return np.dot((0.2126, 0.7152, 0.0722), colour)


def test_bright_lines_have_a_dark_edge():
    (axes,) = drawn(draw_trajectories, 8).axes
    paths = [line for line in axes.get_lines() if len(line.get_xdata()) > 1]

    edged = [bool(line.get_path_effects()) for line in paths]
    assert edged == [luminance(line.get_color()) > 0.7 for line in paths]
    assert edged[3]  # yellow
    assert edged[4]  # light grey


def test_okabe_and_itos_colours_then_dashes_then_a_scale():
    looks = {n: [robot_line(n, robot) for robot in range(1, n + 1)] for n in (8, 16, 50)}

    assert len({look['color'] for look in looks[8]}) == 8
    assert len({(look['color'], str(look['linestyle'])) for look in looks[16]}) == 16
    scale = [luminance(look['color']) for look in looks[50]]
    assert np.all(np.diff(scale) > 0)
    assert scale[-1] < 0.7
    figure = drawn(draw_trajectories, 50, 'okabe-ito')
    names = [text.get_text() for text in figure.axes[0].get_legend().get_texts()]
    assert names[:5] == ['robot 1', 'robot 13', 'robot 25', 'robot 38', 'robot 50']


def robot_line(nb_robots, robot):
    with plot_style('okabe-ito'):
        look = line_look(robot, nb_robots)
        assert look['color'] == robot_colour(robot, nb_robots)
        return look


@pytest.mark.parametrize(('paper', 'width'), [('column', 3.5), ('page', 7.16)])
def test_sizes_on_paper(paper, width):
    figure = drawn(draw_positions, 8, paper=paper)

    assert figure.get_figwidth() == pytest.approx(width)
    assert {text.get_fontsize() for text in outer_texts(figure)} == {8}
    assert {text.get_fontname() for text in outer_texts(figure)} == {'STIXGeneral'}
    assert not any(axes.get_title(loc=loc) for axes in figure.axes for loc in ('left', 'right'))


def test_titles_name_the_run_and_references_are_drawn(run):
    folder = run(4)
    path = folder / 'plots' / 'trajectories.svg'
    without = plot(folder, formats=['svg']) and path.read_text()
    (folder / 'run.yaml').write_text(RUN_YAML)
    described = describe(folder / 'csv' / 'fleet.csv', [1, 2, 3, 4])

    assert described.title == 'leader_follower_formation, 4 robots'
    assert plot(folder, formats=['svg'])
    assert path.read_text() != without
    with plot_style():
        figure = Figure()
        draw_trajectories(figure, circling_fleet(4), described)
    names = [text.get_text() for text in figure.axes[0].get_legend().get_texts()]
    assert names[-2:] == ['waypoints', 'places at the end']
    places = figure.axes[0].get_lines()[-1].get_xydata()
    leader = circling_fleet(4).of(1)
    assert places[0] == pytest.approx([leader.x[-1] - 1.5, leader.y[-1] + 0.866])
    assert len(places) == 3


@pytest.mark.parametrize(
    ('algo', 'name'), [('nav_wp', 'waypoints'), ('traj_tracking', 'reference')]
)
def test_references_of_single_robots(run, algo, name):
    folder = run(1)
    (folder / 'run.yaml').write_text(f'parameters: {{algo: {algo}}}')
    known = describe(folder / 'csv' / 'fleet.csv', [1])
    with plot_style():
        figure = Figure()
        draw_trajectories(figure, circling_fleet(1), known)

    assert known.title == f'{algo}, 1 robot'
    assert figure.axes[0].get_legend().get_texts()[-1].get_text() == name


@pytest.mark.parametrize(
    ('recorded', 'drawn'),
    [('[-3, 2, -1, 4]', ['arena']), ('[-3, 2]', []), ('wide', []), ('7', [])],
)
def test_the_arena_of_an_experiment(run, recorded, drawn):
    folder = run(2)
    (folder / 'run.yaml').write_text(f'parameters: {{algo: consensus, arena: {recorded}}}')
    known = describe(folder / 'csv' / 'fleet.csv', [1, 2])
    with plot_style():
        figure = Figure()
        draw_trajectories(figure, circling_fleet(2), known)

    lines = [line for line in figure.axes[0].get_lines() if line.get_label() == 'arena']
    assert [line.get_label() for line in lines] == drawn
    for line in lines:
        assert np.ptp(line.get_xydata(), axis=0).tolist() == [5, 5]
        assert line.get_xydata().min(axis=0).tolist() == [-3, -1]


def test_the_distance_of_a_formation_is_drawn(run):
    folder = run(3)
    (folder / 'run.yaml').write_text('parameters: {algo: leader_follower_distance_formation}')
    known = describe(folder / 'csv' / 'fleet.csv', [1, 2, 3])
    with plot_style():
        figure = Figure()
        draw_distances(figure, circling_fleet(3), known.references)

    names = [text.get_text() for text in figure.axes[0].get_legend().get_texts()]
    assert 'reference, 3 m' in names


@pytest.mark.parametrize('text', ['parameters: 3', ': :', 'parameters: {algo: gone.py}'])
def test_a_run_that_is_not_known_is_plotted_all_the_same(run, text):
    folder = run(2)
    (folder / 'run.yaml').write_text(text)

    assert len(plot(folder)) == 5
    known = describe(folder / 'csv' / 'fleet.csv', [1, 2])
    assert known.title.endswith('2 robots')
    assert known.references is None


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
    write_csv(table, folder / 'csv' / 'fleet.csv')

    assert len(plot(folder)) == 5
    with plot_style():
        figure = Figure()
        draw_positions(figure, table)
    breaks = [np.isnan(line.get_ydata()).sum() for line in figure.axes[0].get_lines()[:8]]
    assert breaks == [0, 1, 1, 0, 0, 0, 0, 0]


def test_a_robot_that_never_has_a_pose_and_a_single_row(tmp_path):
    nan = float('nan')
    for rows in ([[0, 1, 0, 0, 0, 0, 0]], [[0, 1, 0, 0, 0, 0, 0], [1, 2, nan, nan, nan, 0, 0]]):
        write_csv(fleet_table(rows), tmp_path / 'fleet.csv')
        assert plot(tmp_path / 'fleet.csv')


def test_without_a_screen_nothing_can_be_shown():
    code = (
        'import sys; from pathlib import Path; from setcmas_tools.csv_to_plot import plot\n'
        'from setcmas_tools.fleet_table import fleet_table, write_csv\n'
        'import tempfile\n'
        'from setcmas_simu.errors import SetcmasError\n'
        'with tempfile.TemporaryDirectory() as folder:\n'
        '    path = Path(folder) / "fleet.csv"\n'
        '    write_csv(fleet_table([[0, 1, 0, 0, 0, 0, 0]]), path)\n'
        '    plot(path)\n'
        '    assert "matplotlib.pyplot" not in sys.modules\n'
        '    try:\n'
        '        plot(path, show=True)\n'
        '    except SetcmasError as error:\n'
        '        print(error, len(list((Path(folder) / "plots").iterdir())))\n'
    )
    environment = {'PATH': '', 'PYTHONPATH': ':'.join(sys.path), 'MPLBACKEND': 'agg'}
    result = subprocess.run(
        [sys.executable, '-c', code], env=environment, capture_output=True, text=True, check=True
    )

    assert 'there is no screen to show plots on' in result.stdout
    assert result.stdout.endswith(' 4\n')
    assert not result.stderr


def test_mistakes_get_one_line(tmp_path, run):
    with pytest.raises(SetcmasError, match='there is no'):
        plot(tmp_path / 'missing')
    with pytest.raises(SetcmasError, match=r'there is no fleet\.csv'):
        plot(tmp_path)
    (tmp_path / 'bag').mkdir()
    with pytest.raises(SetcmasError, match='make it with bag_to_csv'):
        plot(tmp_path)
    folder = run(1)
    with pytest.raises(SetcmasError, match="format 'gif' is unknown; accepted are png, pdf, svg"):
        plot(folder, formats=['gif'])
    with pytest.raises(SetcmasError, match="palette 'grey' is unknown; accepted are robots, ok"):
        plot(folder, palette='grey')
    with pytest.raises(SetcmasError, match="paper 'a4' is unknown; accepted are column, page"):
        plot(folder, paper='a4')
    (tmp_path / 'taken').write_text('a file')
    with pytest.raises(SetcmasError, match='cannot be written'):
        plot(folder, tmp_path / 'taken')
