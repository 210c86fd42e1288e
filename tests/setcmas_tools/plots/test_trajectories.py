import numpy as np
import pytest
from circling_fleets import circling_fleet
from matplotlib.figure import Figure
from runs import run_of

from setcmas_ctrl.laws.drawing import Sphere
from setcmas_ctrl.laws.references import References
from setcmas_simu.robots.models_by_name import symbol
from setcmas_tools import simulate
from setcmas_tools.plots.reference_lines import draw_references
from setcmas_tools.plots.style import plot_style
from setcmas_tools.plots.time_plots import draw_distances, draw_errors
from setcmas_tools.plots.trajectories import draw_trajectories
from setcmas_tools.run.run import Run
from setcmas_tools.run.run_info import RunInfo, write_info
from setcmas_tools.run.run_records import MARKER, TRAIL, Drawing

PLACES = [[-1.5, 0.866], [-1.5, -0.866], [1.5, -0.866]]


def drawn(draw, nb_robots, references=None, **parameters):
    with plot_style():
        figure = Figure()
        draw(figure, run_of(circling_fleet(nb_robots), references=references, **parameters))
    return figure.axes[0]


def names(axes):
    return [text.get_text() for text in axes.get_legend().get_texts()]


def test_places_and_waypoints_of_a_formation():
    values = {'PLACES': PLACES, 'WPL': [[2, 2], [-2, 2]], 'REACHED': 0.1}
    references = References('formation', values)
    axes = drawn(draw_trajectories, 4, references)
    leader = circling_fleet(4).of(1)
    places = axes.get_lines()[-1].get_xydata()

    assert names(axes)[-2:] == ['waypoints', 'places at the end']
    assert places[0] == pytest.approx([leader.x[-1] - 1.5, leader.y[-1] + 0.866])
    assert len(places) == 3

    run, film = run_of(circling_fleet(4), references=references), Figure().add_subplot()
    marks = draw_references(film, run, is_film=True)
    assert [one.get_label() for one in marks] == ['waypoints']  # the places would have to move


@pytest.mark.parametrize(
    ('references', 'name'),
    [
        (References('waypoints', {'WPL': [[1, 1]], 'REACHED': 0.1}), 'waypoints'),
        (References('tracking', {'R': 2.0, 'W': 0.2}), 'reference'),
    ],
)
def test_references_of_single_robots(references, name):
    assert names(drawn(draw_trajectories, 1, references))[-1] == name


def test_the_cells_of_a_coverage_have_the_colours_of_their_robots():
    axes = drawn(draw_trajectories, 3, References('coverage', {'BOX': [[-9, -9], [9, 9]]}))
    (cells,) = axes.get_images()

    assert names(axes)[-1] == 'box'
    assert len(np.unique(cells.get_array().reshape(-1, 3), axis=0)) == 3


def test_errors_of_a_task_are_plotted():
    axes = drawn(draw_errors, 1, References('tracking', {'R': 2.0, 'W': 0.2}))
    (error,) = [line.get_ydata() for line in axes.get_lines()]
    start = circling_fleet(1).rows(circling_fleet(1).t >= -1e-9)

    assert error[0] == pytest.approx(np.hypot(start.x[0] - 2, start.y[0]), abs=1e-6)
    for task, values in (
        ('formation', {'PLACES': PLACES}),
        ('distances', {'D': 2.0}),
    ):
        assert names(drawn(draw_errors, 3, References(task, values)))[-1] == 'robot 3'


def test_what_scripts_draw_is_in_the_plane():
    goal, other = Sphere(2, 3, 0, 0.4, (1, 0, 0), 1), Sphere(4, 3, 0, 0.4, (1, 0, 0), 1)
    shown = [
        Drawing(0.0, 1, 'goal', MARKER, goal),
        Drawing(1.0, 1, 'way', TRAIL, goal),
        Drawing(2.0, 1, 'goal', MARKER, other),
    ]
    figure = Figure()
    with plot_style():
        draw_trajectories(figure, Run(circling_fleet(1), drawings=shown))
    trails, markers = figure.axes[0].collections

    assert names(figure.axes[0])[-1] == 'drawn by the script'
    assert [path.get_extents().x0 for path in trails.get_paths()] == pytest.approx([1.8])
    assert [path.get_extents().x0 for path in markers.get_paths()] == pytest.approx([3.8])


def test_the_arena_of_an_experiment():
    axes = drawn(draw_trajectories, 2, arena=[-3, 2, -1, 4])
    (line,) = [line for line in axes.get_lines() if line.get_label() == 'arena']

    assert np.ptp(line.get_xydata(), axis=0).tolist() == [5, 5]
    assert line.get_xydata().min(axis=0).tolist() == [-3, -1]


def test_the_distance_of_a_formation_is_drawn():
    assert 'reference, 3 m' in names(drawn(draw_distances, 3, References('distances', {'D': 3.0})))
    shape = References('distances', {'D': [[0, 0], [3, 0], [0, 4]]})
    assert 'reference, 3, 4, 5 m' in names(drawn(draw_distances, 3, shape))


def test_a_task_that_is_not_installed_here_is_not_drawn():
    assert drawn(draw_trajectories, 2, References('dance', {})).get_lines()


@pytest.mark.parametrize('text', ['parameters: 3', ': :', 'format: 7'])
def test_a_run_that_is_not_known_is_plotted_all_the_same(run, text, capsys):
    folder = run(2)
    write_info(RunInfo(), folder)
    (folder / 'run.yaml').write_text(text)

    assert Run.load(folder).plot().axes
    assert 'its parameters are not known' in capsys.readouterr().out


def test_the_ends_of_trajectories_have_the_symbols_of_the_models():
    run = simulate('consensus', 3, 2.0, model='2:car')
    figure = Figure()
    with plot_style():
        draw_trajectories(figure, run)

    ends = [line.get_marker() for line in figure.axes[0].lines if line.get_zorder() == 4]
    corners = [len(marker.vertices) for marker in ends]
    assert corners == [5, len(symbol('car')) + 1, 5]
