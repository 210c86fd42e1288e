import base64
from xml.etree import ElementTree

from graded_classes import PATHS

from setcmas_tools.grade.mark_pictures import path_picture, picture_address
from setcmas_tools.grade.marks import RobotPath


def test_all_that_is_drawn_lies_in_the_picture():
    picture = ElementTree.fromstring(path_picture(PATHS, 'a "title" <b>'))
    _, _, width, height = map(float, picture.get('viewBox').split())

    lines = picture.findall('polyline')
    assert len(lines) == 6
    for line in lines:
        for point in line.get('points').split():
            x, y = map(float, point.split(','))
            assert 0 < x < width
            assert 0 < y < height


def test_robots_have_their_numbers_and_colours():
    picture = ElementTree.fromstring(path_picture(PATHS, ''))

    assert [one.text for one in picture.findall("text[@class='robot']")] == ['1', '2', '7']
    own = [line.get('stroke') for line in picture.findall("polyline[@class='own']")]
    assert own == ['#0072b2', '#d55e00', '#000000']


def test_nothing_to_draw_is_no_picture():
    assert path_picture((), '') == picture_address((RobotPath(1, (), ()),), '') == ''
    assert path_picture((RobotPath(1, ((float('nan'), 0),), ()),), '') == ''


def test_the_address_of_a_picture_holds_svg_with_its_own_style():
    encoded = picture_address(PATHS, 'paths').removeprefix('data:image/svg+xml;base64,')
    svg = ElementTree.fromstring(base64.b64decode(encoded))
    assert svg.tag == '{http://www.w3.org/2000/svg}svg'
    assert 'stroke-dasharray' in svg.findtext('{http://www.w3.org/2000/svg}style')
