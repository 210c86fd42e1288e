"""The picture of paths on a student's page."""

from dataclasses import replace

from graded_classes import PATHS
from matplotlib.cbook import is_math_text
from matplotlib.figure import Figure

from setcmas_tools.grade.mark_pictures import draw_marks, picture_url
from setcmas_tools.grade.mark_records import ScenarioMark


def test_paths_are_a_picture_and_nothing_is_none():
    drawn = ScenarioMark('a', (), paths=PATHS)

    for scenario, is_drawn in ((drawn, True), (replace(drawn, paths=()), False)):
        assert picture_url([scenario], 50).startswith('data:image/png;base64,iVBOR') == is_drawn


def test_a_name_of_a_scenario_is_no_formula():
    figure = Figure()
    scenario = ScenarioMark('from $x_1$', (), paths=PATHS)
    draw_marks(figure, [scenario])
    title = figure.axes[0].get_title()

    assert not is_math_text(title)
    assert title.startswith(r'from \$x_1\$')
