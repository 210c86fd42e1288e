import re

import numpy as np
import pytest
from circling_fleets import drawn

from setcmas_simu.fleet.palettes import plot_colour
from setcmas_tools.plots.style import line_look, plot_style
from setcmas_tools.plots.time_plots import (
    draw_heading,
    draw_positions,
    draw_velocities,
)
from setcmas_tools.plots.trajectories import draw_trajectories

DRAWINGS = [draw_trajectories, draw_positions, draw_heading, draw_velocities]


@pytest.mark.parametrize('nb_robots', [8, 50])
@pytest.mark.parametrize('drawing', DRAWINGS)
def test_legends_and_titles_cover_nothing(drawing, nb_robots):
    figure = drawn(drawing, nb_robots)
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


def luminance(colour):
    return np.dot((0.2126, 0.7152, 0.0722), colour)


def test_bright_lines_have_a_dark_edge():
    (axes,) = drawn(draw_trajectories, 8).axes
    paths = [line for line in axes.get_lines() if len(line.get_xdata()) > 1]

    edged = [bool(line.get_path_effects()) for line in paths]
    assert edged == [luminance(line.get_color()) > 0.7 for line in paths]
    assert edged[7]  # yellow


def test_okabe_and_itos_colours_then_dashes_then_a_scale():
    looks = {n: [robot_line(n, robot) for robot in range(1, n + 1)] for n in (8, 16, 50)}

    assert len({look['color'] for look in looks[8]}) == 8
    assert len({(look['color'], str(look['linestyle'])) for look in looks[16]}) == 16
    scale = [luminance(look['color']) for look in looks[50]]
    assert np.all(np.diff(scale) > 0)
    assert scale[-1] < 0.7
    figure = drawn(draw_trajectories, 50)
    names = [text.get_text() for text in figure.axes[0].get_legend().get_texts()]
    assert names[:5] == ['robot 1', 'robot 13', 'robot 25', 'robot 38', 'robot 50']


def robot_line(nb_robots, robot):
    with plot_style():
        look = line_look(robot, nb_robots)
        assert look['color'] == plot_colour(robot, nb_robots)
        return look


@pytest.mark.parametrize('drawing', DRAWINGS)
def test_some_robots_of_a_large_fleet_are_drawn_and_the_legend_says_how_many(drawing):
    panels = drawn(drawing, 201).axes
    lines = [line for line in panels[-1].get_lines() if len(line.get_xdata()) > 2]
    legends = [axes.get_legend() for axes in panels if axes.get_legend()]
    texts = [text.get_text() for own in legends for text in own.get_texts()]

    assert len(lines) == 101
    assert lines[-1].get_color() == plot_colour(201, 201)
    assert '101 of 201 robots drawn' in texts
