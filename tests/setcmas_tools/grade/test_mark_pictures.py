"""The picture of paths on a student's page."""

from xml.etree import ElementTree

import pytest
from graded_classes import PATHS

from setcmas_tools.grade.mark_pictures import path_picture
from setcmas_tools.grade.marks import RobotPath

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
