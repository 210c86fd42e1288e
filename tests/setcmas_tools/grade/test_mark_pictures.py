"""The picture of paths on a student's page."""

from xml.etree import ElementTree

import pytest
from graded_classes import PATHS
from matplotlib.cbook import is_math_text
from matplotlib.figure import Figure

from setcmas_tools.grade.mark_pictures import draw_marks, path_picture
from setcmas_tools.grade.marks import Marks, RobotPath, ScenarioMark
from setcmas_tools.submissions.student import Student

PICTURE = ElementTree.fromstring(path_picture(PATHS, 'a "title" <b>'))


def test_all_that_is_drawn_lies_in_the_picture_which_has_round_numbers_along_its_sides():
    _, _, width, height = map(float, PICTURE.get('viewBox').split())

    lines = PICTURE.findall('polyline')
    assert len(lines) == 6
    for line in lines:
        for point in line.get('points').split():
            x, y = map(float, point.split(','))
            assert 0 < x < width
            assert 0 < y < height
    numbers = [one.text for one in PICTURE.findall('g/text')]
    assert numbers == ['-4', '-2', '0', '2', '4', '-4', '-2', '0', '2', '4', 'x (m)', 'y (m)']


def test_robots_have_their_numbers_and_colours():
    assert [one.text for one in PICTURE.findall("text[@class='robot']")] == ['1', '2', '7']
    own = [line.get('stroke') for line in PICTURE.findall("polyline[@class='own']")]
    assert own == ['#0072b2', '#d55e00', '#000000']


@pytest.mark.parametrize('paths', [(), (RobotPath(1, (), ()),), (RobotPath(1, ((1e9, 0),), ()),)])
def test_nothing_to_draw_is_no_picture(paths):
    assert path_picture(paths, '') == ''


def test_a_name_of_a_scenario_is_no_formula():
    figure = Figure()
    scenario = ScenarioMark('from $x_1$', (), paths=PATHS)
    draw_marks(figure, Marks('law.py', Student('law'), '', (scenario,)))
    title = figure.axes[0].get_title()

    assert not is_math_text(title)
    assert title.startswith(r'from \$x_1\$')


def test_more_than_two_scenarios_stand_below_each_other():
    figure = Figure()
    scenarios = tuple(ScenarioMark(name, (), paths=PATHS) for name in 'abc')
    draw_marks(figure, Marks('law.py', Student('law'), '', scenarios))

    places = [axes.get_subplotspec() for axes in figure.axes]
    assert [(one.rowspan.start, one.colspan.start) for one in places] == [(0, 0), (0, 1), (1, 0)]
