import numpy as np
import pytest
from circling_fleets import circling_fleet
from matplotlib.figure import Figure

from setcmas_tools.plots.distances import draw_distances
from setcmas_tools.plots.plot import plot
from setcmas_tools.plots.style import plot_style
from setcmas_tools.plots.trajectories import draw_trajectories
from setcmas_tools.run.description import describe

RUN_YAML = 'parameters: {algo: leader_follower_formation, nb_robots: 4}'


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
