import re

import numpy as np
import pytest
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch

from setcmas_simu.fleet.palettes import plot_colour
from setcmas_tools import simulate
from setcmas_tools.plots.communication_plots import (
    draw_counts,
    draw_graph,
    draw_instants,
    draw_intervals,
)
from setcmas_tools.plots.plot import plots_of
from setcmas_tools.plots.style import plot_style
from setcmas_tools.plots.time_plots import draw_disagreement
from setcmas_tools.run.run import Run
from setcmas_tools.run.run_tables import write_tables

PLAIN = ['trajectories', 'positions', 'heading', 'velocities', 'distances', 'disagreement']


def run_of(nb_robots, duration=15.0, **options):
    return simulate('consensus', nb_robots, duration, **options)


def drawn(draw, run):
    with plot_style():
        figure = Figure()
        draw(figure, run)
        figure.draw_without_rendering()
    return figure


@pytest.mark.parametrize(
    ('options', 'names'),
    [
        ({}, []),
        (
            {'event_triggered': True},
            ['communication_instants', 'communication_counts', 'inter_event_times', 'graph'],
        ),
        ({'graph': 'ring', 'loss': 0.1}, ['graph']),
    ],
)
def test_runs_with_a_record_get_further_plots(tmp_path, options, names):
    run = run_of(3, 2.0, **options)
    write_tables(run, tmp_path)

    assert list(plots_of(Run.load(tmp_path))) == [*PLAIN[:-1], *names, PLAIN[-1]]


@pytest.mark.parametrize('nb_robots', [4, 20])
def test_a_row_for_each_robot_with_its_instants_in_its_colour(nb_robots):
    run = run_of(nb_robots, 3.0, event_triggered=True)
    record = run.record
    (axes,) = drawn(draw_instants, run).axes

    assert len(axes.collections) == nb_robots
    for robot, row in enumerate(axes.collections, start=1):
        sent = record.triggers[(record.triggers[:, 1] == robot) & (record.triggers[:, 2] == 1), 0]
        assert row.get_positions() == sent.tolist()
        assert sent[0] == 0.0
        assert row.get_lineoffset() == robot
        assert to_rgb(row.get_color()) == plot_colour(robot, nb_robots)
    assert axes.get_ylim()[0] > nb_robots > 1 > axes.get_ylim()[1]
    assert axes.get_xlabel() == 'time (s)'


def test_counts_end_at_what_was_sent_and_evaluated():
    run = run_of(4, event_triggered=True)
    fleet, robots = drawn(draw_counts, run).axes
    periodic, triggered = (line.get_ydata() for line in fleet.get_lines()[:2])

    assert periodic[-1] == len(run.record.triggers) == 4 * 151
    assert triggered[-1] == run.record.triggers[:, 2].sum()
    for robot, line in enumerate(robots.get_lines()[:4], start=1):
        assert line.get_ydata()[-1] == run.record.robots[robot].sent
        assert line.get_xdata()[-1] == 15.0
    assert re.search(r'of 604 \([\d.]+ %\)', fleet.get_legend().get_texts()[1].get_text())


def links_of(axes):
    return [patch for patch in axes.patches if isinstance(patch, FancyArrowPatch)]


def test_the_graph_has_a_line_both_ways_and_an_arrow_one_way():
    ring, directed = (run_of(6, 1.0, graph=name) for name in ('ring', 'directed_ring'))
    host, axes = drawn(draw_graph, ring).axes
    figure = drawn(draw_graph, directed)
    arrows = figure.axes[1]

    assert len(links_of(axes)) == len(links_of(arrows)) == 6
    assert host.get_title(loc='left') == 'Communication graph'
    texts = [text.get_text() for text in figure.texts]
    assert 'arrows point to the receivers' in texts
    assert [text.get_text() for text in axes.texts] == ['1', '2', '3', '4', '5', '6']
    nodes = [line.get_markerfacecolor() for line in axes.get_lines()]
    assert nodes == [plot_colour(robot) for robot in range(1, 7)]


def test_an_arrow_points_to_the_robot_that_hears(tmp_path):
    run = run_of(2, 1.0, graph=[[0, 1], [0, 0]])  # robot 1 hears robot 2
    _, axes = drawn(draw_graph, run).axes
    (arrow,) = links_of(axes)
    first, second = (np.array(line.get_xydata()[0]) for line in axes.get_lines())

    np.testing.assert_allclose(arrow._posA_posB, [second, first])


def test_a_panel_for_each_graph_of_a_switching_one(tmp_path):
    (tmp_path / 'switch.yaml').write_text(
        'segments:\n  - {duration: 1, graph: path}\n  - {duration: 1, graph: star}\nrepeat: true\n'
    )
    run = run_of(4, 8.0, graph=tmp_path / 'switch.yaml')
    _, *panels = drawn(draw_graph, run).axes

    assert [axes.get_xlabel() for axes in panels] == [
        'from 0, 2, 4, … s on',
        'from 1, 3, 5, … s on',
    ]


def test_disagreement_is_that_of_the_metrics_on_a_log_scale():
    run = run_of(4)
    (axes,) = drawn(draw_disagreement, run).axes
    values = axes.get_lines()[0].get_ydata()
    positions = run.poses[:, :2]
    gaps = positions - positions.mean(axis=2, keepdims=True)

    assert axes.get_yscale() == 'log'
    np.testing.assert_allclose(values, np.sqrt((gaps**2).sum(axis=(1, 2)) / 4), rtol=1e-9)
    assert values[0] == pytest.approx(run.metrics()['consensus'].disagreement_at_start_m)


def test_robots_in_one_place_have_no_logarithm():
    run = simulate(lambda *_: (0.0, 0.0), 2, 1.0, poses=np.zeros((3, 2)))

    assert drawn(draw_disagreement, run).axes


@pytest.mark.parametrize('late', [0.0, 0.003])  # over ROS robots evaluate one after another
def test_the_histogram_has_each_interval_once_and_names_the_least(late):
    run = run_of(3, 8.0, event_triggered=True)
    run.record.triggers[:, 0] += late * run.record.triggers[:, 1]
    axes = drawn(draw_intervals, run).axes[0]
    intervals = np.concatenate([*run.record.intervals.values()])

    assert sum(bar.get_height() for bar in axes.patches) == len(intervals) > 10
    assert f'least: {intervals.min():.2f} s' in [
        text.get_text() for text in axes.get_legend().get_texts()
    ]
